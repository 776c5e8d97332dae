#include "mesh/read_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>

#include "base/ending.h"
#include "base/read_file.h"
#include "mesh/error.h"
#include "raw_mesh.h"

namespace road {
namespace {

// A race track is between a kart track and the Nordschleife with the hills around it.
constexpr double kSmallestMesh_m = 3.0;
constexpr double kLargestMesh_m = 40e3;
constexpr double kLargestCoordinate_m = 1e7;
// Coordinates that snap to more than this ruin a 10 cm grid; below 1 mm nobody needs to know.
constexpr double kWorstResolution_m = 0.1;
constexpr double kNotableResolution_m = 1e-3;
// The flat faces of a track (road, terrain) outweigh its walls and trees; a clear verdict is 2 : 1.
constexpr double kClearVerdict = 2.0;
// Of 23 tracks of a game whose walls and caves are large, the net share along the axis that is up
// is at least 0.14 on 21 and at most 0.01 on two; along the other axis at most 0.13, and never more
// than a quarter of it.
constexpr double kLeastNet = 0.1, kClearNet = 3.0;
constexpr double kNoChance = 4.0;  // standard deviations

std::string load(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw Error(
        fmt::format("{}: is a folder; give a mesh file (.obj .glb .ply .stl .acc ...)", path));
  }
  std::string bytes = base::read_file(path, kLargestMeshFile);
  if (bytes.empty())
    throw Error(fmt::format("{}: the file is empty; copy or export the mesh again", path));
  return bytes;
}

void check_glb_length(std::string_view bytes, const std::string& path) {
  if (bytes.size() < 12 || !bytes.starts_with("glTF")) {
    throw Error(
        fmt::format("{}: no binary glTF (wanted 'glTF' at its beginning); give a mesh file", path));
  }
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, sizeof length);
  if (bytes.size() < length) {
    throw Error(
        fmt::format("{}: the file is truncated: its header promises {} bytes, it has {}; copy or "
                    "export it again",
                    path, length, bytes.size()));
  }
}

void check_3ds_length(std::string_view bytes, const std::string& path) {
  std::uint32_t length = 0;
  if (bytes.size() >= 6) std::memcpy(&length, bytes.data() + 2, sizeof length);
  if (bytes.size() < 6 || bytes.size() < length) {
    throw Error(fmt::format(
        "{}: the file is truncated: its main chunk promises {} bytes, it has {}; copy or export it "
        "again",
        path, length, bytes.size()));
  }
}

using Opened = std::function<void(std::size_t)>;

/// In a process of its own unless the options say otherwise.
RawMesh read_apart(std::string_view bytes, const std::string& path, const MeshReadOptions& options,
                   const std::function<RawMesh(const Opened&)>& read) {
  return options.own_process ? read_in_child(path, bytes.size(), read) : read({});
}

RawMesh read_foreign(std::string_view bytes, const std::string& path, const Eigen::Vector3d& origin,
                     const MeshReadOptions& options) {
  check_nesting(bytes, path);
  return read_apart(bytes, path, options, [&](const Opened& opened) {
    return read_with_assimp(bytes, path, origin, options, opened);
  });
}

RawMesh read_raw(const std::string& path, const MeshReadOptions& options) {
  const std::string bytes = load(path);
  const std::string extension = base::ending_of(path);
  if (extension == ".stl") return read_stl(bytes, path);
  if (extension == ".ply") return read_ply(bytes, path);
  if (extension == ".obj") {
    const auto read = [&](const Opened& opened) {
      return read_obj_file(bytes, path, options, opened);
    };
    // Foreign code reads pictures alone, and handing a mesh over takes a quarter of the time.
    return options.want_colours ? read_apart(bytes, path, options, read) : read([](std::size_t) {});
  }
  if (extension == ".ac" || extension == ".acc") {
    const LocalText local = localise_ac3d(bytes, path);
    RawMesh mesh = read_foreign(local.text, path, local.origin, options);
    mesh.stored_as_float32 = local.float32_quantised;
    mesh.local_magnitude = 0.0;
    mesh.remarks.insert(mesh.remarks.begin(), local.remarks.begin(), local.remarks.end());
    mesh.up = 'y';
    mesh.metres_per_unit = 0.0;
    return mesh;
  }
  if (extension == ".glb") check_glb_length(bytes, path);
  if (extension == ".3ds") check_3ds_length(bytes, path);
  RawMesh mesh = read_foreign(bytes, path, Eigen::Vector3d::Zero(), options);
  if (extension == ".glb" || extension == ".gltf") {
    mesh.up = 'y';
    mesh.metres_per_unit = 1.0;
  }
  if (extension == ".b3d") mesh.up = 'y';
  // assimp turns Collada and 3DS scenes to y up and Collada lengths to metres.
  if (extension == ".dae") {
    mesh.up = 'y';
    mesh.metres_per_unit = 1.0;
  }
  return mesh;
}

std::string unit_name(double metres_per_unit) {
  for (const NamedUnit& known : kUnits)
    if (std::abs(metres_per_unit - known.metres) < 1e-6 * known.metres) return known.name;
  return fmt::format("{} m", metres_per_unit);
}

struct Facing {
  double y_area = 0.0, z_area = 0.0;  ///< area of all faces projected along y and along z
  double y_net = 0.0, z_net = 0.0;    ///< the same with signs, as a share of the area of all faces
  double y_chance = 0.0, z_chance = 0.0;  ///< what faces turned at random would leave, likewise
};

/// What goes round cancels out: walls face all ways, ground only up. Where faces are turned at
/// random, or a roof lies over all of it, nothing is left along any axis.
Facing facing(const RawMesh& mesh) {
  Facing out;
  double all = 0.0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                       .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]) /
                                   2.0;
    // Squares: a slope of 45 degrees shall not count for both axes alike with a meadow.
    const double area = normal.norm();
    if (!(area > 0.0)) continue;
    out.y_area += normal.y() * normal.y() / area;
    out.z_area += normal.z() * normal.z() / area;
    out.y_net += normal.y();
    out.z_net += normal.z();
    out.y_chance += normal.y() * normal.y();
    out.z_chance += normal.z() * normal.z();
    all += area;
  }
  if (!(all > 0.0)) return out;
  out.y_net = std::abs(out.y_net) / all, out.z_net = std::abs(out.z_net) / all;
  out.y_chance = std::sqrt(out.y_chance) / all, out.z_chance = std::sqrt(out.z_chance) / all;
  return out;
}

/// 'y' or 'z' where the faces tell which is up, else 0: by what they project along the axes, and by
/// which way they face. Large walls can outweigh a small road; then the two contradict each other
/// and nothing is told.
char seen_up(const Facing& area) {
  char flat = 0, net = 0;
  if (area.y_area > kClearVerdict * area.z_area) flat = 'y';
  if (area.z_area > kClearVerdict * area.y_area) flat = 'z';
  if (area.y_net > std::max(kLeastNet, kClearNet * area.z_net)) net = 'y';
  if (area.z_net > std::max(kLeastNet, kClearNet * area.y_net)) net = 'z';
  if (flat != 0) return net == 0 || net == flat ? flat : 0;
  // Alone it must be more than chance; to contradict, less will do.
  const double left = net == 'y' ? area.y_net : area.z_net;
  return left > kNoChance * (net == 'y' ? area.y_chance : area.z_chance) ? net : 0;
}

void check_vertices(const RawMesh& mesh, const std::string& path) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t index : mesh.triangles[i]) {
      const Eigen::Vector3d& v = mesh.vertices[index];
      if (v.allFinite() && v.cwiseAbs().maxCoeff() < 1e12) continue;
      const std::string& name = mesh.objects[mesh.object_of_triangle[i]].name;
      throw Error(
          fmt::format("{}: object '{}', vertex {}: ({:.9g}, {:.9g}, {:.9g}); wanted finite "
                      "coordinates of at most 1e7 m; "
                      "repair the object in the program that made it, or delete it",
                      path, name, index, v.x(), v.y(), v.z()));
    }
  }
}

char decide_up(const RawMesh& mesh, UpAxis wanted, const std::string& path,
               std::vector<std::string>& remarks) {
  const Facing area = facing(mesh);
  const char seen = seen_up(area);
  const std::string figures = fmt::format(
      "faces that point along y: {:.0f}, along z: {:.0f} square units; of all area {:.0f} % is "
      "left "
      "along y and {:.0f} % along z when faces that look against each other cancel out",
      area.y_area, area.z_area, 100.0 * area.y_net, 100.0 * area.z_net);
  if (wanted != UpAxis::automatic) {
    const char told = wanted == UpAxis::y ? 'y' : 'z';
    if (seen != 0 && seen != told) {
      throw Error(
          fmt::format("{}: told that {} is up, but the large flat faces say {} ({}); give --up {}",
                      path, told, seen, figures, seen));
    }
    return told;
  }
  if (mesh.up != 0 && seen != 0 && mesh.up != seen) {
    remarks.push_back(
        fmt::format("the format says {} is up, the large flat faces say {} ({}): took {}", mesh.up,
                    seen, figures, seen));
  }
  if (seen != 0) return seen;
  if (mesh.up != 0) return mesh.up;
  throw Error(fmt::format(
      "{}: cannot tell which axis is up ({}; wanted {} times as much area along one, or "
      "{} times as much left, and no contradiction); give --up y or --up z",
      path, figures, kClearVerdict, kClearNet));
}

double float32_spacing(double magnitude) {
  const auto value = static_cast<float>(magnitude);
  return static_cast<double>(std::nextafter(value, std::numeric_limits<float>::infinity()) - value);
}

struct Bounds {
  Eigen::Vector3d lowest, highest;
};

/// Only vertices in use count: exporters leave stray ones behind.
Bounds bounds_of(const RawMesh& raw) {
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = -lowest;
  for (const auto& t : raw.triangles) {
    for (const std::uint32_t index : t) {
      lowest = lowest.cwiseMin(raw.vertices[index]);
      highest = highest.cwiseMax(raw.vertices[index]);
    }
  }
  return {lowest, highest};
}

/// Refuses a mesh that is no road's size, in units of the file.
void check_extent(double extent, double unit_m, const MeshReadOptions& options,
                  const std::string& path) {
  const double scale = unit_m * options.scale;
  if (!(extent * scale >= kSmallestMesh_m && extent * scale <= kLargestMesh_m)) {
    std::string fitting;
    for (const auto& [name, factor] : {std::pair{"mm", 0.001}, {"cm", 0.01}, {"m", 1.0}}) {
      const double fitted_m = extent * factor * options.scale;
      if (fitted_m >= 100.0 && fitted_m <= kLargestMesh_m)
        fitting +=
            fmt::format("{}--unit {} ({:.0f} m)", fitting.empty() ? "" : " or ", name, fitted_m);
    }
    const std::string scaled =
        options.scale == 1.0 ? "" : fmt::format(", times the scale {:g},", options.scale);
    throw Error(fmt::format("{}: the mesh is {:.6g} {}{} across; wanted {:.0f} m to {:.0f} km; {}",
                            path, extent, unit_name(unit_m), scaled, kSmallestMesh_m,
                            kLargestMesh_m / 1000.0,
                            fitting.empty() ? "check the file and its unit"
                                            : "if the unit is another, give " + fitting));
  }
}

/// Steps of coordinates that were stored as float32; refuses those that are too wide.
double float32_resolution_m(const RawMesh& raw, const Bounds& bounds, double scale,
                            const std::string& path, std::vector<std::string>& remarks) {
  const Eigen::Vector3d centre = (bounds.lowest + bounds.highest) / 2.0;
  const double magnitude =
      raw.local_magnitude > 0.0 ? raw.local_magnitude * scale : centre.cwiseAbs().maxCoeff();
  const double resolution_m = float32_spacing(magnitude);
  const Eigen::Vector3d origin = local_origin(bounds.lowest, bounds.highest);
  if (resolution_m > kWorstResolution_m) {
    throw Error(fmt::format(
        "{}: its coordinates (around {:.0f}, {:.0f} m) were stored as float32 and snap to {:.3g} "
        "m; wanted at most {} m; subtract ({:.0f}, {:.0f}, 0) before exporting, or export .obj "
        "or "
        ".ply in double precision",
        path, centre.x(), centre.y(), resolution_m, kWorstResolution_m, origin.x(), origin.y()));
  }
  if (resolution_m > kNotableResolution_m) {
    remarks.push_back(fmt::format(
        "the coordinates were stored as float32 far from the origin and snap to {:.1f} mm",
        1000.0 * resolution_m));
  }
  return resolution_m;
}

}  // namespace

Mesh read_mesh(const std::string& path, const MeshReadOptions& options, MeshReadReport* report) {
  RawMesh raw = read_raw(path, options);
  if (raw.triangles.empty()) {
    throw Error(fmt::format(
        "{}: no triangles ({} vertices, {} objects); wanted a surface mesh; export faces, not "
        "points or curves",
        path, raw.vertices.size(), raw.objects.size()));
  }
  check_vertices(raw, path);
  std::vector<std::string> remarks = std::move(raw.remarks);

  const char up = decide_up(raw, options.up, path, remarks);
  if (up == 'y') {
    for (Eigen::Vector3d& v : raw.vertices) v = Eigen::Vector3d(v.x(), -v.z(), v.y());
  }

  Bounds bounds = bounds_of(raw);
  auto& [lowest, highest] = bounds;
  double unit_m = metres_per(options.unit);
  if (options.unit == Unit::automatic && raw.metres_per_unit > 0.0) unit_m = raw.metres_per_unit;
  const double scale = unit_m * options.scale;
  check_extent((highest - lowest).head<2>().maxCoeff(), unit_m, options, path);
  lowest *= scale;
  highest *= scale;
  if (std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff()) >
      kLargestCoordinate_m) {
    throw Error(fmt::format(
        "{}: coordinates reach ({:.6g}, {:.6g}, {:.6g}) m; wanted at most 1e7 m from the origin; "
        "move the mesh nearer to it",
        path, highest.x(), highest.y(), highest.z()));
  }

  const double resolution_m =
      raw.stored_as_float32
          ? float32_resolution_m(raw, bounds, scale, path, remarks)
          : std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff()) * 1.2e-16;
  Mesh mesh;
  mesh.origin_m = local_origin(lowest, highest);
  mesh.vertices_m = std::move(raw.vertices);
  for (Eigen::Vector3d& v : mesh.vertices_m) v = v * scale - mesh.origin_m;
  mesh.triangles = std::move(raw.triangles);
  mesh.object_of_triangle = std::move(raw.object_of_triangle);
  mesh.objects = std::move(raw.objects);
  if (report != nullptr) {
    report->up = std::string(1, up);
    report->unit = unit_name(unit_m);
    report->scale = options.scale;
    report->metres_per_unit = scale;
    report->vertices = mesh.vertices_m.size();
    report->triangles = mesh.triangles.size();
    report->objects = mesh.objects.size();
    report->coordinate_resolution_m = resolution_m;
    report->remarks = std::move(remarks);
    report->files = std::move(raw.files);
  }
  return mesh;
}

}  // namespace road
