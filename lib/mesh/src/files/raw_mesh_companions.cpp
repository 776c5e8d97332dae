#include "raw_mesh_companions.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/ending.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/stand_in.h"
#include "mesh/error.h"

namespace road {
namespace {

namespace fs = std::filesystem;

/// Pictures and lists of materials: a mesh is the same road without them.
bool is_for_looks(const std::string& path) {
  constexpr std::string_view kEndings[] = {".mtl", ".material", ".png", ".jpg",  ".jpeg", ".bmp",
                                           ".tga", ".dds",      ".gif", ".tiff", ".tif",  ".webp"};
  const std::string ending = base::ending_of(path);
  return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings);
}

}  // namespace

Companions::Companions(const std::string& mesh_path, bool allow_outside,
                       std::function<void(std::size_t)> opened)
    : mesh_path_(mesh_path),
      folder_(fs::canonical(fs::absolute(mesh_path).parent_path())),
      allow_outside_(allow_outside),
      opened_(std::move(opened)) {}

void Companions::add(const std::string& path, const std::string& sha256) {
  const auto known = std::find_if(files_.begin(), files_.end(),
                                  [&](const MeshFile& file) { return file.path == path; });
  if (known == files_.end()) files_.push_back({path, sha256});
}

/// Whether the file, after every link and "..", lies below the folder; if not, keeps its name.
bool Companions::may_open(const std::string& path) {
  if (allow_outside_) return true;
  std::error_code error;
  const fs::path below =
      fs::weakly_canonical(fs::absolute(path), error).lexically_relative(folder_);
  if (!error && !below.empty() && *below.begin() != "..") return true;
  if (std::find(outside_.begin(), outside_.end(), path) == outside_.end()) outside_.push_back(path);
  return false;
}

bool Companions::exists(const std::string& path) {
  if (!may_open(path)) return false;
  std::error_code error;
  if (fs::exists(path, error)) return true;
  add(path, {});
  return false;
}

std::optional<std::string> Companions::read(const std::string& path, std::size_t most_bytes) {
  if (!exists(path)) return std::nullopt;
  try {
    std::string content = base::read_file(path, most_bytes);
    base::want_no_web_page(content, path);
    if (opened_) opened_(content.size());
    add(path, base::sha256(content));
    return content;
  } catch (const Error& error) {
    add(path, {});
    problems_.emplace_back(error.what());
    return std::nullopt;
  }
}

std::vector<std::string> Companions::remarks_on_outside() const {
  std::vector<std::string> remarks;
  for (const std::string& file : outside_) {
    // assimp looks for one file in several places: the first is what the mesh says.
    if (&file != &outside_.front() && is_for_looks(file)) continue;
    const std::string seen = fmt::format("'{}' lies outside the folder of the mesh", file);
    constexpr const char* kAdvice =
        "move it below that folder, or give --allow-outside (recipe: allow_outside: true)";
    if (!is_for_looks(file)) {
      throw Error(
          fmt::format("{}: refers to a file that is not read: {}; {}", mesh_path_, seen, kAdvice));
    }
    remarks.push_back(fmt::format("refers to a file that was not read: {}; {}", seen, kAdvice));
  }
  return remarks;
}

std::string remark_on_missing(const std::string& names) {
  return fmt::format(
      "the mesh refers to files that are missing: {}; names of materials and textures may be too",
      names);
}

RawMesh read_obj_file(std::string_view bytes, const std::string& path,
                      const MeshReadOptions& options,
                      const std::function<void(std::size_t)>& opened) {
  Companions companions(path, options.allow_outside, opened);
  const fs::path folder = fs::path(path).parent_path();
  std::string missing;
  RawMesh mesh = read_obj(bytes, path, [&](const std::string& name) {
    const std::string named = (folder / name).string();
    if (companions.exists(named)) return companions.read(named);
    if (name.find('\\') != std::string::npos) {  // written on another system
      std::string turned = name;
      std::replace(turned.begin(), turned.end(), '\\', '/');
      turned = (folder / turned).string();
      if (companions.exists(turned)) return companions.read(turned);
    }
    missing += (missing.empty() ? "" : ", ") + named;
    // Mesh and list may have been given another name together.
    return companions.read(fs::path(path).replace_extension(".mtl").string());
  });
  mesh.remarks = companions.remarks_on_outside();
  if (!companions.problems().empty()) {
    mesh.remarks.push_back("refers to a file that cannot be read: " +
                           companions.problems().front());
  } else if (companions.outside().empty() && !missing.empty()) {
    mesh.remarks.push_back(remark_on_missing(missing));
  }
  mesh.files = companions.files();
  if (options.want_colours && options.want_colours(mesh.objects))
    put_colours(path, options.allow_outside, opened, {}, mesh);
  return mesh;
}

}  // namespace road
