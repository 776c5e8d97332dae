// Wavefront .obj. Of assimp 5.2.5 it is known that it puts the faces of an object that comes again
// into another one, or nowhere.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/one_line.h"
#include "base/text_lines.h"
#include "mesh/error.h"
#include "raw_mesh.h"
#include "text_vertices.h"

namespace road {
namespace {

// Half a second, and some for each megabyte: a face of 2,000 corners needs up to four million, with
// vertices of its own not half of these per byte. A damaged file must not take hours.
constexpr std::size_t kEarTests = 20'000'000, kEarTestsPerByte = 100;

/// Longer names are cut: one text repeated for a million materials would fill the memory.
constexpr std::size_t kLongestName = 1000;

bool is_word(std::string_view word, std::string_view lower_case) {
  return std::equal(
      word.begin(), word.end(), lower_case.begin(), lower_case.end(),
      [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

std::string name_of(std::string_view rest) {
  return base::one_line(std::string(base::trimmed(rest).substr(0, kLongestName)));
}

/// The file that a map_Kd line names, without the options before it.
std::string texture_of(std::string_view rest) {
  while (true) {
    std::string_view after = rest;
    const std::string_view option = base::take_word(after);
    if (option.size() < 2 || option.front() != '-') break;
    // -o, -s and -t have one to three numbers, -mm has two, all others one word.
    const bool is_vector = option.size() == 2 && option.find_first_of("ost") == 1;
    const int words = is_vector ? 3 : is_word(option, "-mm") ? 2 : 1;
    for (int i = 0; i < words; ++i) {
      std::string_view next = after;
      const std::string_view word = base::take_word(next);
      if (is_vector && i > 0 && !base::to_number<double>(word)) break;
      after = next;
    }
    rest = after;
  }
  return name_of(rest);
}

std::optional<LinearColour> colour_of(std::string_view rest) {
  std::array<double, 3> rgb{};
  for (double& part : rgb) {
    const auto number = base::to_number<double>(base::take_word(rest));
    if (!number) return std::nullopt;
    part = *number;
  }
  return base_colour(rgb, false);
}

/// Material -> its base texture and colour. What else a list of materials says is not used.
void add_looks(std::string_view text, std::map<std::string, BaseLook>& looks) {
  base::Lines lines(text);
  std::string_view line;
  std::string material;
  while (lines.next(line)) {
    std::string_view rest = line;
    const std::string_view word = base::take_word(rest);
    if (is_word(word, "newmtl")) {
      material = name_of(rest);
    } else if (is_word(word, "map_kd") && !material.empty()) {
      looks[material].picture = texture_of(rest);
    } else if (is_word(word, "kd") && !material.empty()) {
      looks[material].colour = colour_of(rest);
    }
  }
}

class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& path, const MaterialLibrary& library)
      : lines_(bytes),
        bytes_(bytes.size()),
        ends_whole_(bytes.ends_with('\n')),
        path_(path),
        library_(library) {
    // Room that is not used costs nothing; growing to a million triangles costs as much as reading.
    constexpr std::size_t kBytesPerTriangle = 32;
    mesh_.triangles.reserve(bytes.size() / kBytesPerTriangle);
    mesh_.object_of_triangle.reserve(bytes.size() / kBytesPerTriangle);
    mesh_.vertices.reserve(bytes.size() / (2 * kBytesPerTriangle));
  }

  RawMesh read() {
    while (next_line()) {
      std::string_view rest = line_;
      const std::string_view word = base::take_word(rest);
      last_corners_ = 3;
      if (word == "v") {
        check_count(mesh_.vertices.size());
        mesh_.vertices.push_back(take_vertex(rest, path_, lines_.number(), line_));
        bounds_.add(mesh_.vertices.back());
      } else if (word == "f") {
        add_face(rest);
      } else if (word == "o" || word == "g") {
        name_ = name_of(rest);
        current_ = kNone;
      } else if (word == "usemtl") {
        material_ = name_of(rest);
        current_ = kNone;
      } else if (word == "mtllib") {
        add_library(name_of(rest));
      }
    }
    check_end();
    cut_polygons();
    put_looks();
    mesh_.stored_as_float32 = bounds_.float32_quantised();
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  /// A face of more than three corners: cut only when all vertices are known.
  struct Polygon {
    std::size_t triangles_before, begin, end;  ///< the last two of polygon_corners_
    std::uint32_t object;
  };

  /// One line; a vertex or face whose line ends in a stroke goes on in the next.
  bool next_line() {
    if (!lines_.next(line_)) return false;
    if (line_number_ == 0 && line_.starts_with("\xef\xbb\xbf")) line_.remove_prefix(3);
    line_number_ = lines_.number();
    if (!line_.ends_with('\\')) return true;
    std::string_view rest = line_;
    const std::string_view word = base::take_word(rest);
    if (word != "v" && word != "f") return true;
    joined_.assign(line_);
    while (joined_.ends_with('\\')) {
      joined_.back() = ' ';
      if (lines_.next(line_)) joined_ += line_;
    }
    line_ = joined_;
    return true;
  }

  void check_count(std::size_t count) const {
    if (count < kNone) return;
    throw Error(fmt::format(
        "{}: more than 4,294,967,294 vertices or corners of faces; reduce the mesh", path_));
  }

  void add_face(std::string_view rest) {
    const auto vertices = static_cast<std::int64_t>(mesh_.vertices.size());
    corners_.clear();
    for (std::string_view word = base::take_word(rest); !word.empty();
         word = base::take_word(rest)) {
      auto index = base::to_number<std::int64_t>(word.substr(0, word.find('/'))).value_or(0);
      if (index < 0) index += vertices + 1;
      if (index <= 0 || index > kNone) {
        throw Error(
            fmt::format("{}:{}: '{}': wanted numbers of vertices from 1 on, or from -1 back to "
                        "-{}; export the mesh "
                        "again",
                        path_, line_number_, line_.substr(0, 60), vertices));
      }
      if (index > largest_index_) {
        largest_index_ = index;
        largest_index_line_ = line_number_;
      }
      corners_.push_back(static_cast<std::uint32_t>(index - 1));
    }
    ++faces_seen_;
    last_corners_ = corners_.size();
    if (last_corners_ < 3) return;
    if (current_ == kNone) {
      const auto next = static_cast<std::uint32_t>(mesh_.objects.size());
      const auto [known, is_new] = numbers_.try_emplace({name_, material_}, next);
      if (is_new) mesh_.objects.push_back({name_, material_, ""});
      current_ = known->second;
    }
    if (last_corners_ == 3) {
      check_count(mesh_.triangles.size());
      mesh_.triangles.push_back({corners_[0], corners_[1], corners_[2]});
      mesh_.object_of_triangle.push_back(current_);
      return;
    }
    const std::size_t begin = polygon_corners_.size();
    check_count(begin + last_corners_);
    polygon_corners_.insert(polygon_corners_.end(), corners_.begin(), corners_.end());
    polygons_.push_back({mesh_.triangles.size(), begin, begin + last_corners_, current_});
  }

  void add_library(const std::string& name) {
    if (name.empty() || !libraries_.insert(name).second) return;
    if (const auto text = library_(name)) add_looks(*text, looks_);
  }

  void check_end() const {
    if (last_corners_ < 3 && !ends_whole_) {
      throw Error(fmt::format(
          "{}:{}: the file is truncated: its last face has {} corners; copy or export it again",
          path_, lines_.number(), last_corners_));
    }
    if (faces_seen_ == 0) {
      throw Error(
          fmt::format("{}: no faces ('f' lines) in {} lines; wanted an .obj mesh; give a mesh file",
                      path_, lines_.number()));
    }
    if (largest_index_ > static_cast<std::int64_t>(mesh_.vertices.size())) {
      throw Error(fmt::format(
          "{}:{}: a face has corner {}, but there are {} vertices; export the mesh again", path_,
          largest_index_line_, largest_index_, mesh_.vertices.size()));
    }
  }

  /// Only now: materials may stand behind the faces.
  void put_looks() {
    std::map<std::string, std::uint32_t> number;
    mesh_.looks.emplace_back();  // of materials that no list has
    for (const auto& [material, look] : looks_) {
      number.emplace(material, static_cast<std::uint32_t>(mesh_.looks.size()));
      mesh_.looks.push_back(look);
    }
    for (MeshObject& object : mesh_.objects) {
      const auto known = number.find(object.material);
      mesh_.look_of_object.push_back(known == number.end() ? 0 : known->second);
      const std::string& picture = mesh_.looks[mesh_.look_of_object.back()].picture;
      object.texture = picture.substr(picture.find_last_of("/\\") + 1);
    }
  }

  /// Only now: faces may stand before their vertices. What they become stands where they stood.
  void cut_polygons() {
    if (polygons_.empty()) return;
    const auto triangles = std::exchange(mesh_.triangles, {});
    const auto objects = std::exchange(mesh_.object_of_triangle, {});
    mesh_.triangles.reserve(triangles.size() + polygon_corners_.size());
    std::size_t at = 0, ear_tests = 0;
    const auto take_triangles = [&](std::size_t end) {
      mesh_.triangles.insert(mesh_.triangles.end(), triangles.begin() + difference(at),
                             triangles.begin() + difference(end));
      mesh_.object_of_triangle.insert(mesh_.object_of_triangle.end(),
                                      objects.begin() + difference(at),
                                      objects.begin() + difference(end));
      at = end;
    };
    std::vector<std::uint32_t> corners;
    for (const Polygon& polygon : polygons_) {
      take_triangles(polygon.triangles_before);
      corners.assign(polygon_corners_.begin() + difference(polygon.begin),
                     polygon_corners_.begin() + difference(polygon.end));
      ear_tests += triangulate(mesh_.vertices, corners, mesh_.triangles);
      if (ear_tests > kEarTests + kEarTestsPerByte * bytes_) {
        throw Error(fmt::format(
            "{}: cutting its faces of up to 2,000 corners into triangles takes so long that it was "
            "given up; cut them into triangles in the program that made it and export it again",
            path_));
      }
      mesh_.object_of_triangle.resize(mesh_.triangles.size(), polygon.object);
    }
    take_triangles(triangles.size());
  }

  static std::ptrdiff_t difference(std::size_t count) { return static_cast<std::ptrdiff_t>(count); }

  base::Lines lines_;
  std::size_t bytes_;
  bool ends_whole_;
  const std::string& path_;
  const MaterialLibrary& library_;
  std::string_view line_;
  std::string joined_;
  std::size_t line_number_ = 0;

  RawMesh mesh_;
  TextBounds bounds_;
  std::string name_, material_;    ///< in force
  std::uint32_t current_ = kNone;  ///< the object of both; none before a face of it
  std::map<std::pair<std::string, std::string>, std::uint32_t> numbers_;
  std::map<std::string, BaseLook> looks_;
  std::set<std::string> libraries_;
  std::vector<Polygon> polygons_;
  std::vector<std::uint32_t> polygon_corners_;  ///< of all of them, counted from 0
  std::vector<std::uint32_t> corners_;          ///< of the face that is read, likewise
  std::size_t faces_seen_ = 0, last_corners_ = 3;
  std::int64_t largest_index_ = 0;
  std::size_t largest_index_line_ = 0;
};

}  // namespace

RawMesh read_obj(std::string_view bytes, const std::string& path, const MaterialLibrary& library) {
  return ObjReader(bytes, path, library).read();
}

}  // namespace road
