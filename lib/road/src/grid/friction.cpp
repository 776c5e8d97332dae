#include "road/friction.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "base/csv.h"
#include "base/parallel.h"
#include "base/read_file.h"
#include "mesh/error.h"
#include "report/picture.h"

namespace road {

namespace {

constexpr double kHitReach_m = 0.1;  // smoothing and float32 move a node by less
constexpr double kLargest = 3.0;
constexpr std::size_t kMaxPictureBytes = 500'000'000;

enum class GroundKind : std::uint8_t { road, kerb, grass, gravel, paint, concrete, painted };
constexpr std::array<const char*, 7> kNames{"road",  "kerb",     "grass",  "gravel",
                                            "paint", "concrete", "painted"};

/// What the names of one object say: its kind on the road and on the run-off.
struct ObjectKind {
  GroundKind on_road = GroundKind::road, on_runoff = GroundKind::grass;
};

ObjectKind ground_kinds_of(const MeshObject& object) {
  static const std::regex kPaint("paint|marking|(^|[^a-z])lines?([^a-z]|$)", std::regex::icase),
      kConcrete("concrete|(^|[^a-z])conc([^a-z]|$)", std::regex::icase),
      kGravel("gravel|(^|[^a-z])sand", std::regex::icase),
      kGrass("grass|(^|[^a-z])turf", std::regex::icase),
      kAsphalt("asphalt|asph|tarmac", std::regex::icase);
  // The most particular name first: what an object is called says more than its texture.
  for (const std::string* name : {&object.name, &object.material, &object.texture}) {
    const auto says = [&](const std::regex& word) {
      return std::regex_search(name->substr(0, 200), word);
    };
    if (says(kPaint)) return {GroundKind::paint, GroundKind::paint};
    if (says(kConcrete)) return {GroundKind::concrete, GroundKind::concrete};
    if (says(kGravel)) return {GroundKind::gravel, GroundKind::gravel};
    if (says(kGrass)) return {GroundKind::grass, GroundKind::grass};
    if (says(kAsphalt)) return {GroundKind::road, GroundKind::road};
  }
  return {};
}

}  // namespace

std::vector<FrictionZone> read_friction_zones(const std::string& path) {
  const base::CsvTable table =
      base::read_csv(path, {"u_begin_m", "u_end_m", "v_begin_m", "v_end_m", "friction"});
  std::vector<FrictionZone> zones;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const FrictionZone zone{table.value(i, 0), table.value(i, 1), table.value(i, 2),
                            table.value(i, 3), table.value(i, 4)};
    if (zone.v_begin_m > zone.v_end_m) {
      throw Error(
          fmt::format("{}:{}: v_begin_m {} lies left of v_end_m {}; wanted from right to left",
                      path, table.line[i], zone.v_begin_m, zone.v_end_m));
    }
    if (!(zone.friction >= 0.0 && zone.friction <= kLargest)) {
      throw Error(fmt::format("{}:{}: friction is {}; wanted 0 to {}", path, table.line[i],
                              zone.friction, kLargest));
    }
    zones.push_back(zone);
  }
  return zones;
}

std::optional<double> FrictionPicture::at(double x_m, double y_m) const {
  const Eigen::Vector2d pixel = pixel_m_px.inverse() * (Eigen::Vector2d(x_m, y_m) - first_pixel_m);
  const double column = std::floor(pixel.x() + 0.5), row = std::floor(pixel.y() + 0.5);
  if (!(column >= 0.0 && column < width_px && row >= 0.0 && row < height_px)) return std::nullopt;
  const std::uint8_t* colour =
      &rgba[4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
                 static_cast<std::size_t>(column))];
  if (colour[0] != colour[1] || colour[1] != colour[2] || colour[3] != 255) return std::nullopt;
  return colour[0] / 100.0;
}

std::optional<std::string> world_file_of(const std::string& picture_path) {
  for (const char* ending : {".pgw", ".wld"}) {
    std::string path = std::filesystem::path(picture_path).replace_extension(ending).string();
    if (std::filesystem::exists(path)) return path;
  }
  return std::nullopt;
}

FrictionPicture read_friction_picture(const std::string& path) {
  const std::optional<std::string> world_path = world_file_of(path);
  if (!world_path) {
    throw Error(fmt::format(
        "{}: no world file beside it ({}); wanted six lines that say where its pixels lie, as "
        "build writes for "
        "<name>.classes.png",
        path, std::filesystem::path(path).replace_extension(".pgw").filename().string()));
  }
  std::array<double, 6> world{};
  std::istringstream lines(base::read_file(*world_path, 4096));
  for (std::size_t k = 0; k < world.size(); ++k) {
    if (!(lines >> world[k]) || !std::isfinite(world[k]))
      throw Error(fmt::format("{}:{}: no number; wanted six, one a line", *world_path, k + 1));
  }
  FrictionPicture picture;
  picture.pixel_m_px << world[0], world[2], world[1], world[3];
  picture.first_pixel_m = {world[4], world[5]};
  if (!(std::abs(picture.pixel_m_px.determinant()) > 1e-12))
    throw Error(fmt::format(
        "{}: pixels of no area ({}, {}, {}, {}); wanted their size in metres in lines 1 and 4",
        *world_path, world[0], world[1], world[2], world[3]));
  try {
    report::Picture image = report::decode_png(base::read_file(path, kMaxPictureBytes));
    picture.width_px = image.width_px;
    picture.height_px = image.height_px;
    picture.rgba = std::move(image.rgba);
  } catch (const std::invalid_argument& error) {
    throw Error(
        fmt::format("{}: {}; wanted a PNG with friction times 100 as grey", path, error.what()));
  }
  return picture;
}

FrictionPaint read_friction_paint(const FrictionOptions& options) {
  FrictionPaint paint;
  if (options.zones_path) paint.zones = read_friction_zones(*options.zones_path);
  if (options.picture_path) paint.picture = read_friction_picture(*options.picture_path);
  return paint;
}

crg::Grid friction_grid(const SampledGrid& sampled, const RaySurface& surface, const RoadMesh& road,
                        const crg::ReferenceLine& line, const FrictionOptions& options,
                        const FrictionPaint& paint, unsigned threads, FrictionReport* report) {
  std::vector<ObjectKind> kinds;
  for (const MeshObject& object : road.mesh.objects) kinds.push_back(ground_kinds_of(object));
  bool named = false;
  for (const ObjectKind& kind : kinds)
    named = named || kind.on_road != GroundKind::road || kind.on_runoff != GroundKind::grass;
  const std::array<double, 6> value{options.road,   options.kerb,  options.grass,
                                    options.gravel, options.paint, options.concrete};

  crg::Grid grid = sampled.grid;
  const std::size_t rows = grid.rows(), columns = grid.columns();
  std::array<std::atomic<std::size_t>, kNames.size()> nodes{};
  base::parallel_for(rows, 64, threads, [&](std::size_t begin, std::size_t end) {
    std::array<std::size_t, kNames.size()> counted{};
    for (std::size_t i = begin; i < end; ++i) {
      const double u = grid.u_of(i);
      for (std::size_t j = 0; j < columns; ++j) {
        const std::size_t node = i * columns + j;
        const float z = sampled.grid.z_m[node];
        if (std::isnan(z)) continue;
        const SurfaceClass surface_class = sampled.surface_class[node];
        GroundKind kind = surface_class == SurfaceClass::kerb     ? GroundKind::kerb
                          : surface_class == SurfaceClass::runoff ? GroundKind::grass
                                                                  : GroundKind::road;
        if (named && kind != GroundKind::kerb) {
          const crg::Point2 p = crg::node_position(line, i, grid.v_m[j]);
          if (const auto hit = surface.nearest_hit(p.x_m, p.y_m, z, kHitReach_m)) {
            const ObjectKind& object = kinds[road.mesh.object_of_triangle[hit->triangle]];
            kind = kind == GroundKind::grass ? object.on_runoff : object.on_road;
          }
        }
        double friction = value[static_cast<std::size_t>(kind)];
        if (paint.picture) {
          const crg::Point2 p = crg::node_position(line, i, grid.v_m[j]);
          if (const auto painted = paint.picture->at(p.x_m, p.y_m)) {
            friction = *painted;
            kind = GroundKind::painted;
          }
        }
        for (const FrictionZone& zone : paint.zones) {
          const bool along = zone.u_begin_m <= zone.u_end_m
                                 ? u >= zone.u_begin_m && u <= zone.u_end_m
                                 : u >= zone.u_begin_m || u <= zone.u_end_m;
          if (!along || grid.v_m[j] < zone.v_begin_m || grid.v_m[j] > zone.v_end_m) continue;
          friction = zone.friction;
          kind = GroundKind::painted;
        }
        grid.z_m[node] = static_cast<float>(friction);
        ++counted[static_cast<std::size_t>(kind)];
      }
    }
    for (std::size_t k = 0; k < counted.size(); ++k) nodes[k] += counted[k];
  });
  if (report != nullptr) {
    for (std::size_t k = 0; k < kNames.size(); ++k) {
      if (nodes[k] > 0) report->nodes[kNames[k]] = nodes[k];
    }
  }
  return grid;
}

}  // namespace road
