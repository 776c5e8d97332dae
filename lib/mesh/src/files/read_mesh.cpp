#include "mesh/read_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>

#include "base/ending.h"
#include "base/read_file.h"
#include "base/stand_in.h"
#include "decide_up.h"
#include "mesh/error.h"
#include "raw_mesh.h"

namespace road {
namespace {

// A race track is between a kart track and the Nordschleife with the hills around it.
constexpr double kSmallestMesh_m = 3.0;
constexpr double kLargestMesh_m = 40e3;
constexpr double kSmallestRoad_m = 100.0;  // of a unit to propose
constexpr double kLargestCoordinate_m = 1e7;
// Coordinates that snap to more than this ruin a 10 cm grid; below 1 mm nobody needs to know.
constexpr double kWorstResolution_m = 0.1;
constexpr double kNotableResolution_m = 1e-3;
std::string load(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw Error(
        fmt::format("{}: is a folder; give a mesh file (.obj .glb .ply .stl .acc ...)", path));
  }
  std::string bytes = base::read_file(path, kLargestMeshFile);
  if (bytes.empty())
    throw Error(fmt::format("{}: the file is empty; copy or export the mesh again", path));
  base::want_no_web_page(bytes, path);
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
    mesh.up = UpAxis::y;
    mesh.metres_per_unit = 0.0;
    return mesh;
  }
  if (extension == ".glb") check_glb_length(bytes, path);
  if (extension == ".3ds") check_3ds_length(bytes, path);
  RawMesh mesh = read_foreign(bytes, path, Eigen::Vector3d::Zero(), options);
  if (extension == ".glb" || extension == ".gltf") {
    mesh.up = UpAxis::y;
    mesh.metres_per_unit = 1.0;
  }
  if (extension == ".b3d") mesh.up = UpAxis::y;
  // assimp turns Collada and 3DS scenes to y up and Collada lengths to metres.
  if (extension == ".dae") {
    mesh.up = UpAxis::y;
    mesh.metres_per_unit = 1.0;
  }
  return mesh;
}

std::string unit_name(double metres_per_unit) {
  for (const NamedUnit& known : kUnits)
    if (std::abs(metres_per_unit - known.metres) < 1e-6 * known.metres) return known.name;
  return fmt::format("{} m", metres_per_unit);
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
    std::vector<Unit> could_be;
    for (const NamedUnit& known : kUnits) {
      const double fitted_m = extent * known.metres * options.scale;
      if (fitted_m < kSmallestRoad_m || fitted_m > kLargestMesh_m) continue;
      could_be.push_back(known.unit);
      fitting += fmt::format("{}--unit {} ({:.0f} m)", fitting.empty() ? "" : " or ", known.name,
                             fitted_m);
    }
    const std::string scaled =
        options.scale == 1.0 ? "" : fmt::format(", times the scale {:g},", options.scale);
    const std::string text =
        fmt::format("{}: the mesh is {:.6g} {}{} across; wanted {:.0f} m to {:.0f} km; {}", path,
                    extent, unit_name(unit_m), scaled, kSmallestMesh_m, kLargestMesh_m / 1000.0,
                    fitting.empty() ? "check the file and its unit"
                                    : "if the unit is another, give " + fitting);
    if (options.unit == Unit::automatic && options.scale == 1.0 && !could_be.empty())
      throw UnknownUnit(text, std::move(could_be));
    throw Error(text);
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

/// The plan, from left to right; what faced up still does.
void mirror(RawMesh& raw) {
  for (Eigen::Vector3d& v : raw.vertices) v.y() = -v.y();
  for (auto& t : raw.triangles) std::swap(t[1], t[2]);
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

  double unit_m = metres_per(options.unit);
  if (options.unit == Unit::automatic && raw.metres_per_unit > 0.0) unit_m = raw.metres_per_unit;
  const Bounds as_stored = bounds_of(raw);
  check_extent((as_stored.highest - as_stored.lowest).maxCoeff(), unit_m, options, path);
  const Up up = decide_up(raw, options.up, path, remarks);
  if (up.axis != UpAxis::z)
    for (Eigen::Vector3d& v : raw.vertices) v = turned_up(v, up.axis);
  if (options.mirror != raw.left_handed) mirror(raw);

  Bounds bounds = bounds_of(raw);
  auto& [lowest, highest] = bounds;
  const double scale = unit_m * options.scale;
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
    report->up = name_of(up.axis);
    report->up_why = up.why;
    report->mirrored = options.mirror;
    report->unit = unit_name(unit_m);
    report->unit_taken = options.unit == Unit::automatic && raw.metres_per_unit <= 0.0;
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
