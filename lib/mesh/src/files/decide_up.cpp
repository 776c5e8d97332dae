#include "decide_up.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "base/ending.h"
#include "mesh/error.h"
#include "stands_on.h"

namespace road {
namespace {

// The flat faces of a track (road, terrain) outweigh its walls and trees; a clear verdict is 2 : 1.
constexpr double kClearVerdict = 2.0;
// Of 23 tracks of a game whose walls and caves are large, the net share along the axis that is up
// is at least 0.14 on 21 and at most 0.01 on two; along the other axis at most 0.13, and never more
// than a quarter of it.
constexpr double kLeastNet = 0.1, kClearNet = 3.0;
constexpr double kNoChance = 4.0;  // standard deviations
// Road and ground are within 30 degrees of level.
constexpr double kFlat = 0.866;
// Of the flat faces of 40 tracks of TORCS at least 97 % look up, of ten circuits that lie on their
// back at least 94 % look down. A body with an underside has half.
constexpr double kOneSided = 0.9;
constexpr double kNearlyAll = 0.98;  // a sea seen from below, in one of these games, is 93 %

constexpr int kGroundCells = 200;  // along the longer side of the mesh

// Nothing lies over a road but a bridge and its own underside; a line across the walls of a ring
// meets at least four of them.
constexpr double kWalls = 1.5, kEnoughFlat = 0.05;

constexpr const char* kLines[] = {"x", "y", "z"};

/// One of the three lines through the faces of a mesh.
struct AlongLine {
  double area = 0.0;    ///< of all faces, projected along it
  double net = 0.0;     ///< the same with signs, as a share of the area of all faces
  double chance = 0.0;  ///< what faces turned at random would leave, likewise
  /// Of flat faces: those that look along it, those that look against it.
  std::array<double, 2> flat_area{};
  std::array<std::size_t, 2> flat_faces{};
};

using Facing = std::array<AlongLine, 3>;

void add_face(const Eigen::Vector3d& normal, double area, Facing& out) {
  for (int k = 0; k < 3; ++k) {
    AlongLine& along = out[static_cast<std::size_t>(k)];
    // Squares: a slope of 45 degrees shall not count for both lines alike with a meadow.
    along.area += normal[k] * normal[k] / area;
    along.net += normal[k];
    along.chance += normal[k] * normal[k];
    if (std::abs(normal[k]) < kFlat * area) continue;
    const std::size_t side = normal[k] > 0.0 ? 0 : 1;
    along.flat_area[side] += area;
    ++along.flat_faces[side];
  }
}

/// What goes round cancels out: walls face all ways, ground only up. Where faces are turned at
/// random, or a roof lies over all of it, nothing is left along any line.
Facing facing(const RawMesh& mesh) {
  Facing out;
  double all = 0.0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                       .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]) /
                                   2.0;
    const double area = normal.norm();
    if (!(area > 0.0)) continue;
    add_face(normal, area, out);
    all += area;
  }
  if (!(all > 0.0)) return out;
  for (AlongLine& along : out)
    along.net = std::abs(along.net) / all, along.chance = std::sqrt(along.chance) / all;
  return out;
}

/// How many faces lie over each other, of those that are flat along a line.
double times_over(const RawMesh& mesh, int line) {
  const int a = (line + 1) % 3, b = (line + 2) % 3;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : mesh.vertices) box.extend(v);
  const double cell = std::max(box.sizes()[a], box.sizes()[b]) / kGroundCells;
  if (!(cell > 0.0)) return 0.0;
  constexpr double kMostSamples = 1e8;  // of all faces: huge ones are looked at less closely
  const double most_parts =
      std::clamp(std::sqrt(kMostSamples / static_cast<double>(mesh.triangles.size())), 1.0,
                 2.0 * kGroundCells);
  std::unordered_map<std::int64_t, double> area_of;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d p = mesh.vertices[t[0]], q = mesh.vertices[t[1]] - p,
                          r = mesh.vertices[t[2]] - p;
    const Eigen::Vector3d normal = q.cross(r) / 2.0;
    if (!(std::abs(normal[line]) >= kFlat * normal.norm() && normal.norm() > 0.0)) continue;
    const double longest = std::max({q.norm(), r.norm(), (q - r).norm()});
    const int parts = static_cast<int>(std::ceil(std::min(2.0 * longest / cell, most_parts)));
    const double share = std::abs(normal[line]) / (parts * parts);
    const auto add = [&](double i, double j) {
      const Eigen::Vector3d at = p + (q * i + r * j) / parts - box.min();
      area_of[static_cast<std::int64_t>(at[a] / cell) * (kGroundCells + 1) +
              static_cast<std::int64_t>(at[b] / cell)] += share;
    };
    // The middles of the parts, of those that lie the other way round too.
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        add(i + 1.0 / 3.0, j + 1.0 / 3.0);
        if (i + j + 1 < parts) add(i + 2.0 / 3.0, j + 2.0 / 3.0);
      }
  }
  double all = 0.0, squares = 0.0;
  for (const auto& [at, area] : area_of) all += area, squares += area * area;
  return all > 0.0 ? squares / (all * cell * cell) : 0.0;
}

/// Walls that face each other are flat along a line too: they lie over each other where the faces
/// that are flat along the other line do not.
bool are_walls(const RawMesh& mesh, const Facing& all, int line, int other) {
  const auto flat = [&](int k) {
    const auto& area = all[static_cast<std::size_t>(k)].flat_area;
    return area[0] + area[1];
  };
  return flat(other) > kEnoughFlat * flat(line) &&
         times_over(mesh, line) > kWalls * times_over(mesh, other);
}

/// Along y or z (1, 2) where the faces tell it, else -1: by what they project, and by which way
/// they look. Large walls can outweigh a small road; then the two contradict each other and nothing
/// is told, or nothing is left along either line.
int seen_y_or_z(const RawMesh& mesh, const Facing& all) {
  const AlongLine &y = all[1], &z = all[2];
  int flat = -1, net = -1;
  if (y.area > kClearVerdict * z.area) flat = 1;
  if (z.area > kClearVerdict * y.area) flat = 2;
  if (y.net > std::max(kLeastNet, kClearNet * z.net)) net = 1;
  if (z.net > std::max(kLeastNet, kClearNet * y.net)) net = 2;
  if (flat >= 0 && net < 0) return are_walls(mesh, all, flat, 3 - flat) ? -1 : flat;
  if (flat >= 0) return net == flat ? flat : -1;
  // Alone it must be more than chance; to contradict, less will do.
  const AlongLine& left = net == 1 ? y : z;
  return left.net > kNoChance * left.chance ? net : -1;
}

/// Few files have x up, so both must say so; where one does, the other lines are not to be trusted.
int seen_line(const RawMesh& mesh, const Facing& all) {
  const auto& [x, y, z] = all;
  if (x.area <= kClearVerdict * std::max(y.area, z.area)) return seen_y_or_z(mesh, all);
  return x.net > std::max(kLeastNet, kClearNet * std::max(y.net, z.net)) ? 0 : -1;
}

/// 1, -1: nearly all flat faces look along a line, or against it; 0: neither.
int side_of(const AlongLine& along) {
  const double both = along.flat_area[0] + along.flat_area[1];
  if (!(both > 0.0)) return 0;
  if (along.flat_area[0] >= kOneSided * both) return 1;
  return along.flat_area[1] >= kOneSided * both ? -1 : 0;
}

UpAxis measured(const Facing& all, int line) {
  return up_along(line, side_of(all[static_cast<std::size_t>(line)]) < 0);
}

std::string with_commas(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
  return text;
}

std::string from_faces(const AlongLine& along) {
  const auto& [plus, minus] = along.flat_faces;
  const int side = side_of(along);
  if (side == 0)
    return fmt::format("from the faces of {} triangles, which look both ways",
                       with_commas(plus + minus));
  return fmt::format("from the faces of {} triangles", with_commas(side > 0 ? plus : minus));
}

constexpr const char* kRuleOfGltf = "as glTF files have it";

/// Whose rule it is that a file follows.
std::string rule_of(const std::string& path) {
  const std::string ending = base::ending_of(path);
  for (const auto& [known, name] : {std::pair{".glb", "glTF"},
                                    {".gltf", "glTF"},
                                    {".ac", "AC3D"},
                                    {".acc", "AC3D"},
                                    {".b3d", "Blitz3D"},
                                    {".dae", "Collada"}})
    if (ending == known) return fmt::format("as {} files have it", name);
  return "as the file states";
}

std::string figures_of(const Facing& all) {
  const auto& [x, y, z] = all;
  return fmt::format(
      "faces that point along x: {:.0f}, along y: {:.0f}, along z: {:.0f} square units; of all "
      "area {:.0f} % is left along x, {:.0f} % is left along y and {:.0f} % along z when faces "
      "that look against each other cancel out",
      x.area, y.area, z.area, 100.0 * x.net, 100.0 * y.net, 100.0 * z.net);
}

std::string other_way(UpAxis up) { return name_of(up_along(line_of(up), !is_minus(up))); }

/// "95 % of the flat faces look to -z".
std::string look_to(const AlongLine& along, UpAxis to) {
  const double area = along.flat_area[is_minus(to) ? 1 : 0];
  return fmt::format("{:.0f} % of the flat faces look to {}",
                     100.0 * area / (along.flat_area[0] + along.flat_area[1]), name_of(to));
}

Up as_told(const RawMesh& mesh, const Facing& all, UpAxis told, const std::string& path,
           std::vector<std::string>& remarks) {
  const int line = seen_line(mesh, all);
  if (line >= 0 && line != line_of(told)) {
    const char* seen = name_of(measured(all, line));
    throw Error(
        fmt::format("{}: told that {} is up, but the large flat faces say {} ({}); give "
                    "--up {}",
                    path, name_of(told), seen, figures_of(all), seen));
  }
  const AlongLine& along = all[static_cast<std::size_t>(line_of(told))];
  if (side_of(along) == (is_minus(told) ? 1 : -1)) {
    const std::string other = other_way(told);
    remarks.push_back(fmt::format(
        "told that {} is up, but {}; if the road is upside down and mirrored, give --up {}",
        name_of(told), look_to(along, up_called(other)), other));
  }
  return {told, "as told"};
}

[[noreturn]] void ask_for_up(const Facing& all, const std::string& path) {
  const auto& [x, y, z] = all;
  std::vector<UpAxis> could_be{measured(all, 1), measured(all, 2)};
  if (x.area > kClearVerdict * std::max(y.area, z.area)) could_be.push_back(measured(all, 0));
  std::string flags;
  for (const UpAxis up : could_be)
    flags += fmt::format("{}--up {}", flags.empty() ? "" : " or ", name_of(up));
  throw UnknownUp(
      fmt::format("{}: cannot tell which axis is up ({}; wanted {} times as much area along one, "
                  "or {} times as much left, and no contradiction); give {}",
                  path, figures_of(all), kClearVerdict, kClearNet, flags),
      could_be);
}

/// Faces look against an axis: the mesh lies on its back, or its faces are wound the other way
/// round, as those of a mirrored plan are. `told` is what speaks for the latter; empty: nothing.
[[noreturn]] void ask_for_side(const AlongLine& along, UpAxis seen, const std::string& told,
                               const std::string& path) {
  const UpAxis other = up_called(other_way(seen));
  const std::string on_its_back = fmt::format("--up {} (it lies on its back)", name_of(seen)),
                    not_so = fmt::format(
                        "--up {0} --mirror (left and right exchanged) or --up {0} (faces wound the "
                        "other way round)",
                        name_of(other));
  const bool is_told = !told.empty();
  throw UnknownUp(
      fmt::format("{}: cannot tell which way is up: {}, {}; give {} or {}", path,
                  look_to(along, seen), is_told ? told : "and nothing stands or lies on them",
                  is_told ? not_so : on_its_back, is_told ? on_its_back : not_so),
      is_told ? std::vector{other, seen} : std::vector{seen, other});
}

/// Asks unless what stands or lies on the ground says that faces which look against a line are
/// right.
void confirm_minus(const RawMesh& mesh, const AlongLine& along, int line, const std::string& path) {
  const int things = side_of_things(mesh, line);
  const int sheets = things == 0 ? side_of_sheets(mesh, line) : 0;
  if (things < 0 || sheets < 0) return;
  ask_for_side(along, up_along(line, true),
               things > 0 ? fmt::format("but what is steep stands towards {}", kLines[line])
               : sheets > 0
                   ? fmt::format("but small objects lie on large ones towards {}", kLines[line])
                   : "",
               path);
}

/// The format's line is the one that the faces tell. Whoever opened such a file saw it the right
/// way up; of two-sided faces nobody sees the winding. Viewers of glTF leave out what is seen from
/// behind: a file that nobody can have seen may be mirrored.
Up as_the_format(const AlongLine& along, UpAxis up, const std::string& path,
                 std::vector<std::string>& remarks) {
  const int side = side_of(along);
  if (side == 0) return {up, rule_of(path) + "; faces look both ways"};
  if (side == (is_minus(up) ? -1 : 1)) return {up, from_faces(along)};
  const UpAxis other = up_called(other_way(up));
  const double area = along.flat_area[is_minus(other) ? 1 : 0];
  if (rule_of(path) == kRuleOfGltf &&
      area >= kNearlyAll * (along.flat_area[0] + along.flat_area[1]))
    ask_for_side(along, other, fmt::format("but up is {}, {}", name_of(up), rule_of(path)), path);
  remarks.push_back(
      fmt::format("{}, but up is {}, {}; if the road is upside down and mirrored, give --up {}",
                  look_to(along, other), name_of(up), rule_of(path), name_of(other)));
  return {up, fmt::format("{}; faces look to {}", rule_of(path), name_of(other))};
}

}  // namespace

Up decide_up(const RawMesh& mesh, UpAxis told, const std::string& path,
             std::vector<std::string>& remarks) {
  const Facing all = facing(mesh);
  if (told != UpAxis::automatic) return as_told(mesh, all, told, path, remarks);
  const int line = seen_line(mesh, all);
  if (line < 0) {
    if (mesh.up == UpAxis::automatic) ask_for_up(all, path);
    return {mesh.up, rule_of(path) + "; the faces do not tell"};
  }
  const AlongLine& along = all[static_cast<std::size_t>(line)];
  if (line == line_of(mesh.up)) return as_the_format(along, mesh.up, path, remarks);
  const UpAxis up = measured(all, line);
  if (is_minus(up)) confirm_minus(mesh, along, line, path);
  const std::string inverted =
      is_minus(up) ? fmt::format("; if their winding alone is inverted, give --up {}", kLines[line])
                   : "";
  if (mesh.up != UpAxis::automatic) {
    remarks.push_back(
        fmt::format("the format says {} is up, the large flat faces say {} ({}): took {}{}",
                    name_of(mesh.up), name_of(up), figures_of(all), name_of(up), inverted));
  } else if (is_minus(up)) {
    remarks.push_back(look_to(along, up) + ": took this as up" + inverted);
  }
  return {up, from_faces(along)};
}

}  // namespace road
