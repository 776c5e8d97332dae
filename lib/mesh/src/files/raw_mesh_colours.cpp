// The colours of a mesh's objects: from its materials, and from their pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "base/one_line.h"
#include "raw_mesh_companions.h"
#include "report/mean_colour.h"

namespace road {
namespace {

namespace fs = std::filesystem;

// Of all pictures of a mesh together, and of one. Reading so many pixels takes two seconds.
constexpr std::size_t kMostPictures = 1000;
constexpr std::size_t kMostPixelsOfAll = 100'000'000;
constexpr std::size_t kLargestPicture = 50'000'000, kMostBytesOfAll = 400'000'000;

/// Reads each picture once.
class Pictures {
 public:
  Pictures(const std::string& mesh_path, bool allow_outside,
           const std::function<void(std::size_t)>& opened, const EmbeddedPicture& embedded)
      : companions_(mesh_path, allow_outside, opened),
        folder_(fs::path(mesh_path).parent_path()),
        embedded_(embedded) {}

  std::optional<LinearColour> colour_of(const std::string& name) {
    const auto known = colours_.find(name);
    if (known != colours_.end()) return known->second;
    std::optional<LinearColour> colour;
    if (colours_.size() < kMostPictures) {
      colour = look_at(name);
    } else {
      say(name, fmt::format("more than {} pictures", kMostPictures));
    }
    return colours_.emplace(name, colour).first->second;
  }

  const std::vector<MeshFile>& files() const { return companions_.files(); }

  /// One for all that tell nothing.
  std::optional<std::string> remark() const {
    if (without_ == 0) return std::nullopt;
    return fmt::format(
        "no name tells what is road, so colours may, but {} of {} pictures tell none; the first: "
        "{}",
        without_, colours_.size(), first_);
  }

 private:
  std::optional<LinearColour> look_at(const std::string& name) {
    try {
      std::string content;
      std::optional<std::string_view> bytes;
      if (embedded_) bytes = embedded_(name);
      if (!bytes) {
        auto file = read_beside(name);
        if (!file) return std::nullopt;
        content = std::move(*file);
        bytes = content;
      }
      const std::array<double, 3> mean = report::mean_colour(*bytes, pixels_left_);
      return LinearColour{static_cast<float>(mean[0]), static_cast<float>(mean[1]),
                          static_cast<float>(mean[2])};
    } catch (const std::exception& error) {  // damaged, too large, no memory for it
      say(name, error.what());
      return std::nullopt;
    }
  }

  /// Where the mesh says, else by its name alone beside the mesh: paths of another machine.
  std::optional<std::string> read_beside(const std::string& name) {
    std::string turned = name;
    std::replace(turned.begin(), turned.end(), '\\', '/');
    const std::string alone = turned.substr(turned.find_last_of('/') + 1);
    if (alone.empty()) {
      say(name, "no name of a file");
      return std::nullopt;
    }
    std::vector<std::string> places{(folder_ / alone).string()};
    const bool is_absolute = turned.front() == '/' || turned.find(':') != std::string::npos;
    if (!is_absolute && alone != turned) places.insert(places.begin(), (folder_ / turned).string());
    for (const std::string& place : places) {
      if (!companions_.exists(place)) continue;
      const std::size_t problems = companions_.problems().size();
      auto content = companions_.read(place, std::min(kLargestPicture, bytes_left_));
      if (content) {
        bytes_left_ -= std::min(bytes_left_, content->size());
        return content;
      }
      say(name, companions_.problems().size() > problems ? companions_.problems().back()
                                                         : "cannot be read");
      return std::nullopt;
    }
    say(name, companions_.outside().empty()
                  ? "not there"
                  : "it lies outside the folder of the mesh; move it below that folder, or give "
                    "--allow-outside (recipe: allow_outside: true)");
    return std::nullopt;
  }

  void say(const std::string& name, const std::string& why) {
    ++without_;
    if (first_.empty()) first_ = base::one_line(fmt::format("'{}': {}", name, why));
  }

  Companions companions_;
  fs::path folder_;
  const EmbeddedPicture& embedded_;
  std::map<std::string, std::optional<LinearColour>> colours_;
  std::size_t pixels_left_ = kMostPixelsOfAll, bytes_left_ = kMostBytesOfAll;
  std::size_t without_ = 0;
  std::string first_;
};

}  // namespace

void put_colours(const std::string& mesh_path, bool allow_outside,
                 const std::function<void(std::size_t)>& opened, const EmbeddedPicture& embedded,
                 RawMesh& mesh) {
  Pictures pictures(mesh_path, allow_outside, opened, embedded);
  std::vector<std::optional<LinearColour>> colours;
  std::vector<bool> is_used(mesh.looks.size(), false);
  for (const std::uint32_t look : mesh.look_of_object) is_used[look] = true;
  for (std::size_t k = 0; k < mesh.looks.size(); ++k) {
    const BaseLook& look = mesh.looks[k];
    colours.push_back(look.colour);
    if (!is_used[k] || look.picture.empty()) continue;
    colours.back() = pictures.colour_of(look.picture);
    if (!colours.back() || !look.colour) continue;
    for (std::size_t c = 0; c < 3; ++c) (*colours.back())[c] *= (*look.colour)[c];
  }
  for (std::size_t i = 0; i < mesh.objects.size() && i < mesh.look_of_object.size(); ++i)
    mesh.objects[i].colour = colours[mesh.look_of_object[i]];
  for (const MeshFile& file : pictures.files()) {
    const auto has_its_path = [&](const MeshFile& other) { return other.path == file.path; };
    if (std::none_of(mesh.files.begin(), mesh.files.end(), has_its_path))
      mesh.files.push_back(file);
  }
  if (auto remark = pictures.remark()) mesh.remarks.push_back(std::move(*remark));
}

}  // namespace road
