#include "road/clean.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <regex>
#include <unordered_map>
#include <unordered_set>

#include "road/error.h"

namespace road {
namespace {

constexpr double kZeroArea_m2 = 1e-8;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Lower case outside escapes: \S must not become \s. Matching lower-cased text with a lower-cased
/// pattern is several times faster than std::regex::icase.
std::string lower_case_pattern(std::string pattern) {
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] == '\\') {
      ++i;
    } else {
      pattern[i] = static_cast<char>(std::tolower(static_cast<unsigned char>(pattern[i])));
    }
  }
  return pattern;
}

/// Name rules, compiled. Materials and textures recur, so their answers are kept.
class NameTable {
 public:
  explicit NameTable(const std::vector<NameRule>& rules) {
    for (const NameRule& rule : rules) {
      try {
        compiled_.push_back({rule.field,
                             rule.surface_class,
                             std::regex(lower_case_pattern(rule.pattern),
                                        std::regex::ECMAScript | std::regex::optimize),
                             {}});
      } catch (const std::regex_error& error) {
        throw Error(fmt::format("name rule '{}': {}; wanted an ECMAScript regular expression",
                                rule.pattern, error.what()));
      }
    }
  }

  std::optional<SurfaceClass> class_of(const MeshObject& object) {
    const std::array<std::string, 3> text{lower_case(object.name), lower_case(object.material),
                                          lower_case(object.texture)};
    for (Rule& rule : compiled_) {
      const std::string& subject = text[static_cast<std::size_t>(rule.field)];
      if (subject.empty()) continue;
      bool matches = false;
      if (rule.field == NameRule::Field::object) {
        matches = std::regex_search(subject, rule.pattern);
      } else {
        const auto [known, inserted] = rule.answers.try_emplace(subject, false);
        if (inserted) known->second = std::regex_search(subject, rule.pattern);
        matches = known->second;
      }
      if (matches) return rule.surface_class;
    }
    return std::nullopt;
  }

 private:
  struct Rule {
    NameRule::Field field;
    SurfaceClass surface_class;
    std::regex pattern;
    std::unordered_map<std::string, bool> answers;
  };
  std::vector<Rule> compiled_;
};

/// For every vertex the lowest vertex within `tolerance_m` (chains of close vertices are not
/// followed, so nothing moves farther than the tolerance).
std::vector<std::uint32_t> weld(const std::vector<Eigen::Vector3d>& vertices_m,
                                double tolerance_m) {
  // Cells much larger than the tolerance: nearly every vertex needs to look into one cell only.
  const double cell_m = std::max(tolerance_m * 16.0, 1e-6);
  using Cell = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Cell& cell) const {
      return static_cast<std::size_t>(cell[0] * 73856093 ^ cell[1] * 19349663 ^ cell[2] * 83492791);
    }
  };
  std::unordered_map<Cell, std::vector<std::uint32_t>, Hash> cells;
  cells.reserve(vertices_m.size() / 2);
  std::vector<std::uint32_t> target(vertices_m.size());
  const auto cell_of = [cell_m](double value) {
    return static_cast<std::int64_t>(std::floor(value / cell_m));
  };
  for (std::uint32_t i = 0; i < vertices_m.size(); ++i) {
    const Eigen::Vector3d& v = vertices_m[i];
    std::uint32_t found = kNone;
    const Cell low{cell_of(v.x() - tolerance_m), cell_of(v.y() - tolerance_m),
                   cell_of(v.z() - tolerance_m)};
    const Cell high{cell_of(v.x() + tolerance_m), cell_of(v.y() + tolerance_m),
                    cell_of(v.z() + tolerance_m)};
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto cell = cells.find({x, y, z});
          if (cell == cells.end()) continue;
          for (const std::uint32_t other : cell->second) {
            if (other < found && (vertices_m[other] - v).norm() <= tolerance_m) found = other;
          }
        }
      }
    }
    target[i] = found == kNone ? i : found;
    if (found == kNone) cells[{cell_of(v.x()), cell_of(v.y()), cell_of(v.z())}].push_back(i);
  }
  return target;
}

/// Triangles with shared vertices and their classes, and how many were left out for which reason.
struct Soup {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> source;  ///< index of the triangle in the input mesh
  std::vector<SurfaceClass> surface_class;
};

Eigen::Vector3d area_vector(const Soup& soup, std::size_t i) {
  const auto& t = soup.triangles[i];
  return 0.5 * (soup.vertices_m[t[1]] - soup.vertices_m[t[0]])
                   .cross(soup.vertices_m[t[2]] - soup.vertices_m[t[0]]);
}

}  // namespace

const char* to_string(SurfaceClass surface_class) {
  switch (surface_class) {
    case SurfaceClass::road:
      return "road";
    case SurfaceClass::kerb:
      return "kerb";
    case SurfaceClass::runoff:
      return "runoff";
    case SurfaceClass::barrier:
      return "barrier";
    case SurfaceClass::scenery:
      return "scenery";
  }
  return "?";
}

std::vector<NameRule> default_name_rules() {
  using enum NameRule::Field;
  using enum SurfaceClass;
  return {
      // TORCS. Trees and boards first: most objects are of these, and the first match decides.
      {object, R"(^(obj|object|tree|trib|pub|poutre|box|rect|poly|roue|toptent)[^a-z]*)", scenery},
      {object, R"(^(b[0-9r][lr]t|p\d+ts|s[0-9t]bg))", barrier},
      {object, R"(^tkmn)", road},
      {object, R"(^[tx]k[lr]s)", runoff},
      {object, R"(^terr)", scenery},
      {texture, R"(wall|barr|fence|armco|pylon)", barrier},
      {texture, R"(kerb|curb)", kerb},
      {object, R"(^[tx]\d[lr]b)", runoff},
      // Assetto Corsa: surfaces that count are numbered, "1ROAD", "12KERB".
      {object, R"(^\d+(road|asph|pit|conc))", road},
      {object, R"(^\d+(kerb|curb))", kerb},
      {object, R"(^\d+(grass|sand|gravel|runoff|dirt|turf))", runoff},
      {object, R"(^\d+(wall|fence|armco|barr))", barrier},
      // Plain words, as object or material, rFactor's four-letter ones among them.
      {object,
       R"((^|[^a-z])(tree|bush|forest|crowd|stand|grandstand|gantry|bridge|building|house|sign|board|light|car|tent|sky|terrain|hill|mountain))",
       scenery},
      {object, R"((^|[^a-z])(wall|fence|barrier|armco|guard|tyre|tire|cone|pylon))", barrier},
      {object, R"((^|[^a-z])(kerb|curb|rmbl|rumble))", kerb},
      {object, R"((^|[^a-z])(road|asphalt|tarmac|track|rdap|racingsurface|pitlane))", road},
      {object,
       R"((^|[^a-z])(runoff|run-off|run_off|grass|grss|gravel|grav|sand|verge|shoulder|dirt|concrete|cemt))",
       runoff},
      {material,
       R"((^|[^a-z])(tree|bush|forest|crowd|stand|gantry|building|house|sign|board|leaf|leaves|trunk|sky))",
       scenery},
      {material, R"((^|[^a-z])(wall|fence|barrier|armco|guard|tyre|tire))", barrier},
      {material, R"((^|[^a-z])(kerb|curb|rmbl|rumble))", kerb},
      {material, R"((^|[^a-z])(road|asphalt|tarmac|rdap))", road},
      {material,
       R"((^|[^a-z])(runoff|run-off|run_off|grass|grss|gravel|grav|sand|verge|shoulder|dirt|cemt))",
       runoff},
  };
}

RoadMesh clean(const Mesh& mesh, const CleanOptions& options, CleanReport* report) {
  CleanReport facts;
  facts.triangles_in = mesh.triangles.size();
  facts.weld_tolerance_m = options.weld_tolerance_m;
  facts.by_names = true;

  NameTable table(options.name_rules);
  std::vector<SurfaceClass> class_of_object;
  class_of_object.reserve(mesh.objects.size());
  for (const MeshObject& object : mesh.objects) {
    class_of_object.push_back(table.class_of(object).value_or(SurfaceClass::scenery));
  }

  Soup soup;
  {
    const double min_cosine = std::cos(options.max_slope_deg * std::numbers::pi / 180.0);
    std::vector<Eigen::Vector3d> corners;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const SurfaceClass surface_class = class_of_object[mesh.object_of_triangle[i]];
      if (surface_class == SurfaceClass::barrier || surface_class == SurfaceClass::scenery) {
        ++facts.dropped[to_string(surface_class)];
        continue;
      }
      const Eigen::Vector3d normal =
          0.5 *
          (mesh.vertex(i, 1) - mesh.vertex(i, 0)).cross(mesh.vertex(i, 2) - mesh.vertex(i, 0));
      if (normal.norm() < kZeroArea_m2) {
        ++facts.dropped["zero area"];
        continue;
      }
      if (surface_class != SurfaceClass::kerb &&
          std::abs(normal.z()) < min_cosine * normal.norm()) {
        ++facts.dropped["too steep"];
        continue;
      }
      kept.push_back(i);
    }
    std::vector<std::uint32_t> compact(mesh.vertices_m.size(), kNone);
    for (const std::uint32_t i : kept) {
      for (const std::uint32_t index : mesh.triangles[i]) {
        if (compact[index] != kNone) continue;
        compact[index] = static_cast<std::uint32_t>(corners.size());
        corners.push_back(mesh.vertices_m[index]);
      }
    }
    const std::vector<std::uint32_t> target = weld(corners, options.weld_tolerance_m);
    std::vector<std::uint32_t> welded(corners.size(), kNone);
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
      if (target[i] != i) {
        ++facts.vertices_welded;
        continue;
      }
      welded[i] = static_cast<std::uint32_t>(soup.vertices_m.size());
      soup.vertices_m.push_back(corners[i]);
    }
    struct Hash {
      std::size_t operator()(const std::array<std::uint32_t, 3>& t) const {
        return (static_cast<std::size_t>(t[0]) * 73856093) ^
               (static_cast<std::size_t>(t[1]) * 19349663) ^
               (static_cast<std::size_t>(t[2]) * 83492791);
      }
    };
    std::unordered_set<std::array<std::uint32_t, 3>, Hash> seen;
    seen.reserve(2 * kept.size());
    for (const std::uint32_t i : kept) {
      std::array<std::uint32_t, 3> t{};
      for (std::size_t c = 0; c < 3; ++c) t[c] = welded[target[compact[mesh.triangles[i][c]]]];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        ++facts.dropped["zero area"];
        continue;
      }
      std::array<std::uint32_t, 3> key = t;
      std::sort(key.begin(), key.end());
      if (!seen.insert(key).second) {
        ++facts.dropped["duplicate"];
        continue;
      }
      soup.triangles.push_back(t);
      soup.source.push_back(i);
      soup.surface_class.push_back(class_of_object[mesh.object_of_triangle[i]]);
      if (area_vector(soup, soup.triangles.size() - 1).z() < 0.0)
        std::swap(soup.triangles.back()[1], soup.triangles.back()[2]);
    }
  }
  if (soup.triangles.empty()) {
    throw Error(
        fmt::format("nothing to drive on: {} triangles in {} objects, none of them road; give a "
                    "mesh with a road, "
                    "or name rules that find it",
                    mesh.triangles.size(), mesh.objects.size()));
  }

  RoadMesh road;
  road.mesh.origin_m = mesh.origin_m;
  road.mesh.vertices_m = std::move(soup.vertices_m);
  road.mesh.triangles = std::move(soup.triangles);
  road.mesh.objects = mesh.objects;
  for (const std::uint32_t i : soup.source)
    road.mesh.object_of_triangle.push_back(mesh.object_of_triangle[i]);
  road.class_of_triangle = std::move(soup.surface_class);
  for (const SurfaceClass surface_class : road.class_of_triangle)
    ++facts.kept[to_string(surface_class)];
  facts.triangles_kept = road.mesh.triangles.size();
  if (report != nullptr) *report = std::move(facts);
  return road;
}

}  // namespace road
