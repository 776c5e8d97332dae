#include "road_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "base/error.h"
#include "vehicle/road.h"
#include "vehicle/vec3.h"

namespace sim {
namespace {

using Vec3 = vehicle::Vec3<double>;
using Rotation = vehicle::Rotation<double>;

/// Turns and moves a frame into the one around it.
struct Frame {
  Rotation turn;
  Vec3 at_m;

  Vec3 out(const Vec3& point) const { return turn.apply(point) + at_m; }
  Vec3 in(const Vec3& point) const { return turn.undo(point - at_m); }
};

Frame frame_of(const vehicle::Mounting& mounting) {
  const auto& [roll, pitch, yaw] = mounting.turned_rad;
  return {vehicle::rotation(roll, pitch, yaw),
          {mounting.at_m[0], mounting.at_m[1], mounting.at_m[2]}};
}

Frame frame_of(const Pose& pose) {
  return {vehicle::rotation(pose[3], pose[4], pose[5]), {pose[0], pose[1], pose[2]}};
}

bool pose_is_finite(const Pose& pose) {
  return std::all_of(pose.begin(), pose.end(), [](double value) { return std::isfinite(value); });
}

Vec3 direction(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

Eigen::Vector3d eigen(const Vec3& a) { return {a.x, a.y, a.z}; }

/// Where the road ends in a row: the last columns before a hole, outwards from the reference line.
std::optional<std::array<double, 2>> drivable_of(const crg::Grid& grid, std::size_t row) {
  const auto is_road = [&](std::size_t column) { return std::isfinite(grid.at(row, column)); };
  std::optional<std::size_t> middle;
  for (std::size_t j = 0; j < grid.columns(); ++j)
    if (is_road(j) && (!middle || std::abs(grid.v_m[j]) < std::abs(grid.v_m[*middle]))) middle = j;
  if (!middle) return std::nullopt;
  std::size_t right = *middle, left = *middle;
  while (right > 0 && is_road(right - 1)) --right;
  while (left + 1 < grid.columns() && is_road(left + 1)) ++left;
  return std::array{grid.v_m[left], grid.v_m[right]};
}

/// Rows of the road from behind the car to ahead of it, each `spacing_m` at fixed places of the
/// road; rising, over the seam of a closed road.
std::vector<std::size_t> rows_around(const crg::Surface& road, double u_m, double around_m,
                                     double spacing_m) {
  const crg::Grid& grid = road.grid();
  const std::size_t rows = grid.rows();
  const bool closed = road.closed();
  const double length_m = grid.u_step_m * static_cast<double>(rows - 1);
  // A car that has gone astray, too far for numbers that count rows.
  if (!(std::abs(u_m - grid.u_begin_m) < 2.0 * length_m + around_m)) return {};
  const double half_m = closed ? std::min(around_m, 0.5 * length_m) : around_m;
  const auto first =
      static_cast<std::int64_t>(std::ceil((u_m - half_m - grid.u_begin_m) / spacing_m));
  const auto last =
      static_cast<std::int64_t>(std::floor((u_m + half_m - grid.u_begin_m) / spacing_m));
  std::vector<std::size_t> out;
  for (std::int64_t k = first; k <= last; ++k) {
    double along_m = static_cast<double>(k) * spacing_m;
    if (closed) along_m -= length_m * std::floor(along_m / length_m);
    const double row = std::round(along_m / grid.u_step_m);
    if (row >= 0.0 && row < static_cast<double>(rows)) out.push_back(static_cast<std::size_t>(row));
  }
  return out;
}

}  // namespace

Scan scan_road(NearbyRoad& road, const vehicle::ScanSensor& sensor, const Pose& pose,
               base::Random random) {
  Scan out;
  out.name = sensor.name;
  out.at_m = sensor.mounting.at_m;
  out.turned_rad = sensor.mounting.turned_rad;
  if (!pose_is_finite(pose)) return out;
  const Frame car = frame_of(pose), in_car = frame_of(sensor.mounting);
  const Eigen::Vector3d from_m = eigen(car.out(in_car.at_m));
  road.look_around(from_m, sensor.reach_m);
  const std::size_t columns = sensor.columns();
  for (std::size_t i = 0; i < columns; ++i)
    for (const double beam_rad : sensor.beams_rad) {
      const double azimuth_rad =
          sensor.step_rad * (static_cast<double>(i) - 0.5 * static_cast<double>(columns - 1));
      const bool is_lost = random.uniform() < sensor.lost;
      const double noise = random.normal();
      if (is_lost) continue;
      const Vec3 along = direction(azimuth_rad, beam_rad);
      const road::Ray ray{from_m, eigen(car.turn.apply(in_car.turn.apply(along)))};
      const auto hit = road.first_hit(ray, sensor.nearest_m, sensor.reach_m);
      if (!hit) continue;
      const Vec3 point = (hit->range_m + sensor.noise_m * noise) * along;
      out.points.push_back({static_cast<float>(point.x), static_cast<float>(point.y),
                            static_cast<float>(point.z),
                            static_cast<float>(std::abs(hit->normal.dot(ray.direction)))});
    }
  return out;
}

Edges see_edges(const crg::Surface& road, const vehicle::EdgeSensor& sensor, const Pose& pose,
                base::Random random) {
  Edges out;
  out.name = sensor.name;
  if (!pose_is_finite(pose)) return out;
  const Frame car = frame_of(pose), in_car = frame_of(sensor.mounting);
  const crg::UV here = vehicle::RoadTracker(road).at(pose[0], pose[1], pose[2]);
  const double heading_rad = road.heading_at_uv(here.u_m, here.v_m).heading_rad;
  const bool against = std::cos(pose[5] - heading_rad) < 0.0;
  // A point that is near may lie further along the inside of a bend.
  std::vector<std::size_t> rows =
      rows_around(road, here.u_m, 1.5 * sensor.reach_m, sensor.spacing_m);
  if (against) std::reverse(rows.begin(), rows.end());
  const crg::Grid& grid = road.grid();
  for (const std::size_t row : rows) {
    const auto ends_m = drivable_of(grid, row);
    if (!ends_m) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      const bool is_lost = random.uniform() < sensor.lost;
      const double turn = sensor.noise_rad * random.normal(),
                   rise = sensor.noise_rad * random.normal();
      const crg::Sample edge = road.at_uv(grid.u_of(row), (*ends_m)[side]);
      const Vec3 seen = in_car.in(car.in({edge.x_m, edge.y_m, edge.z_m}));
      const double range_m = vehicle::norm(seen);
      const double azimuth_rad = std::atan2(seen.y, seen.x);
      if (is_lost || !(range_m <= sensor.reach_m && range_m > 0.0) ||
          std::abs(azimuth_rad) > 0.5 * sensor.field_rad)
        continue;
      const double elevation_rad = std::asin(std::clamp(seen.z / range_m, -1.0, 1.0));
      const Vec3 told = in_car.out(range_m * direction(azimuth_rad + turn, elevation_rad + rise));
      ((side == 0) != against ? out.left_m : out.right_m)
          .push_back(
              {static_cast<float>(told.x), static_cast<float>(told.y), static_cast<float>(told.z)});
    }
  }
  return out;
}

RoadDevices::RoadDevices(std::shared_ptr<const crg::Surface> road,
                         const vehicle::RoadSensorFile& file, std::uint64_t seed, double step_s,
                         bool waits)
    : road_(std::move(road)), file_(file), seed_(seed), step_s_(step_s), waits_(waits) {
  if (empty()) return;
  const std::string& first = file.scans.empty() ? file.edges[0].name : file.scans[0].name;
  if (road_ == nullptr)
    throw base::Error(fmt::format(
        "the sensor {} looks at the road, and none was given; give the unit's own (--road)",
        first.substr(0, 60)));
  const auto want = [&](const std::string& name, const vehicle::SensorClock& clock) {
    if (clock.rate_hz * step_s > 1.0 + 1e-9)
      throw base::Error(fmt::format(
          "the sensor {} looks {} times a second, and a step is {} s: at most once per step", name,
          clock.rate_hz, step_s));
  };
  for (const auto& scan : file.scans) want(scan.name, scan.clock);
  for (const auto& edges : file.edges) want(edges.name, edges.clock);
  if (!file.scans.empty()) triangles_ = std::make_unique<NearbyRoad>(road_);
  worker_ = std::make_unique<Worker>();
  restart();
}

void RoadDevices::restart() {
  is_.on_the_way.clear();
  is_.looks.assign(file_.scans.size() + file_.edges.size(), 0);
  is_.steps = 0;
}

bool RoadDevices::is_due(const vehicle::SensorClock& clock, std::uint64_t looks) const {
  // Half a step, so that the rounding of times decides nothing.
  return static_cast<double>(is_.steps) * step_s_ >=
         static_cast<double>(looks) / clock.rate_hz - 0.5 * step_s_;
}

base::Random RoadDevices::random_of(const std::string& name, std::uint64_t look) const {
  return base::random_of(seed_, fmt::format("look {} of {}", look, name));
}

template <class Sees>
void RoadDevices::look(const vehicle::SensorClock& clock, Sees sees) {
  if (!waits_ && static_cast<std::size_t>(std::count_if(
                     is_.on_the_way.begin(), is_.on_the_way.end(),
                     [&](const Look& one) { return one.due_step < is_.steps; })) >= kMostLate) {
    ++left_out_;
    return;
  }
  // The queue of the worker wants functions that can be copied.
  const auto task = std::make_shared<std::packaged_task<ToldSight()>>(
      [sees, time_s = static_cast<double>(is_.steps) * step_s_]() -> ToldSight {
        auto sight = sees();
        sight.time_s = time_s;
        return tell_sight(std::move(sight));
      });
  const std::uint64_t due =
      is_.steps + static_cast<std::uint64_t>(std::llround(clock.delay_s / step_s_));
  const auto after = std::find_if(is_.on_the_way.begin(), is_.on_the_way.end(),
                                  [&](const Look& other) { return other.due_step > due; });
  is_.on_the_way.insert(after, {due, task->get_future().share()});
  worker_->give([task] { (*task)(); });
}

void RoadDevices::step(const Pose& pose) {
  if (empty()) return;
  for (std::size_t k = 0; k < file_.scans.size(); ++k) {
    const vehicle::ScanSensor& sensor = file_.scans[k];
    if (!is_due(sensor.clock, is_.looks[k])) continue;
    look(sensor.clock, [this, &sensor, pose, k, random = random_of(sensor.name, is_.looks[k])] {
      Scan scan = scan_road(*triangles_, sensor, pose, random);
      scan.sensor = k;
      return scan;
    });
    ++is_.looks[k];
  }
  for (std::size_t k = 0; k < file_.edges.size(); ++k) {
    const vehicle::EdgeSensor& sensor = file_.edges[k];
    std::uint64_t& looks = is_.looks[file_.scans.size() + k];
    if (!is_due(sensor.clock, looks)) continue;
    look(sensor.clock, [this, &sensor, pose, k, random = random_of(sensor.name, looks)] {
      Edges edges = see_edges(*road_, sensor, pose, random);
      edges.sensor = k;
      return edges;
    });
    ++looks;
  }
  if (is_.steps == 0)
    for (const Look& one : is_.on_the_way) one.sight.wait();
  ++is_.steps;
}

std::vector<ToldSight> RoadDevices::arrived() {
  std::vector<ToldSight> out;
  while (!is_.on_the_way.empty() && is_.on_the_way.front().due_step < is_.steps) {
    const Look& first = is_.on_the_way.front();
    if (!waits_ && first.sight.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      break;
    if (first.due_step + 1 < is_.steps) ++late_;
    out.push_back(is_.on_the_way.front().sight.get());
    is_.on_the_way.pop_front();
  }
  return out;
}

}  // namespace sim
