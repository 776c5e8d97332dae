#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/surface.h"
#include "load_car.h"
#include "recording/recording.h"
#include "report/plot_page.h"
#include "vehicle/error.h"
#include "vehicle/road.h"

namespace crgdrive {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A drive seen along the road. Rows as in the recording; at the begin of a lap u breaks.
struct AlongRoad {
  std::string name;
  std::vector<double> u_m, v_m, heading_error_rad, sideslip_rad;
  recording::Recording recording;
};

AlongRoad see(const crg::Surface& road, const std::string& road_path, const std::string& path,
              const std::string& mapping_path) {
  AlongRoad out;
  out.name = path;
  recording::Mapping mapping;
  if (!mapping_path.empty()) mapping = recording::read_mapping(mapping_path);
  out.recording = recording::read_recording(path, mapping);
  const recording::Table& t = out.recording.table;
  const auto* const x = t.find("x_m");
  const auto* const y = t.find("y_m");
  if (x == nullptr || y == nullptr)
    throw vehicle::Error(path + ": no channels x_m and y_m; name their columns in a mapping");
  require_on_road(road, road_path, t, path);
  const auto* const yaw = t.find("yaw_rad");
  const auto* const vx = t.find("vx_mps");
  const auto* const vy = t.find("vy_mps");
  const auto* const z = t.find("z_m");
  vehicle::RoadTracker tracker(road);
  double last_u = kNaN;
  for (std::size_t i = 0; i < t.rows(); ++i) {
    crg::UV place{kNaN, kNaN};
    double heading = kNaN;
    if (std::isfinite((*x)[i]) && std::isfinite((*y)[i])) {
      place = tracker.at((*x)[i], (*y)[i], z == nullptr ? kNaN : (*z)[i]);
      const crg::Point2 a = road.xy_of_uv(place.u_m, 0.0), b = road.xy_of_uv(place.u_m, 1.0);
      heading = std::atan2(-(b.x_m - a.x_m), b.y_m - a.y_m);  // the normal points left
    }
    // Over the seam: a gap in the curve.
    const bool jump = std::isfinite(last_u) && std::abs(place.u_m - last_u) > 100.0;
    last_u = place.u_m;
    out.u_m.push_back(jump ? kNaN : place.u_m);
    out.v_m.push_back(place.v_m);
    out.heading_error_rad.push_back(
        yaw == nullptr ? kNaN : std::remainder((*yaw)[i] - heading, 2.0 * std::numbers::pi));
    const bool fast = vx != nullptr && vy != nullptr && (*vx)[i] > 3.0;
    out.sideslip_rad.push_back(fast ? std::atan2((*vy)[i], (*vx)[i]) : kNaN);
  }
  return out;
}

}  // namespace

int report(const ReportCommand& command, Terminal& terminal) {
  const crg::Surface road(crg::read(command.track_path));
  std::vector<AlongRoad> drives;
  for (std::size_t i = 0; i < command.telemetry.size(); ++i)
    drives.push_back(
        see(road, command.track_path, command.telemetry[i], i == 0 ? command.mapping_path : ""));
  report::PlotPage page;
  page.title = "Drives along " + command.track_path;
  const auto add = [&](const char* title, const char* unit, const auto& values) {
    report::Plot plot{title, "u, m", unit, {}};
    for (const AlongRoad& drive : drives) {
      const std::vector<double>* const y = values(drive);
      if (y != nullptr) plot.lines.push_back({drive.name, drive.u_m, *y});
    }
    if (!plot.lines.empty()) page.plots.push_back(std::move(plot));
  };
  const auto channel = [](const char* name) {
    return [name](const AlongRoad& d) { return d.recording.table.find(name); };
  };
  add("Speed", "m/s", channel("vx_mps"));
  add("Sideslip", "rad", [](const AlongRoad& d) { return &d.sideslip_rad; });
  add("Lateral deviation from the reference line", "m", [](const AlongRoad& d) { return &d.v_m; });
  add("Heading against the reference line", "rad",
      [](const AlongRoad& d) { return &d.heading_error_rad; });
  add("Load front left", "N", channel("fz_fl_n"));
  add("Load front right", "N", channel("fz_fr_n"));
  add("Load rear left", "N", channel("fz_rl_n"));
  add("Load rear right", "N", channel("fz_rr_n"));
  page.facts.push_back(
      {"road", command.track_path + "  " + base::sha256_of_file(command.track_path).substr(0, 16)});
  for (const AlongRoad& drive : drives) {
    const auto& time = *drive.recording.table.find("time_s");
    page.facts.push_back(
        {drive.name,
         fmt::format("{} rows, {:.2f} s, {}", drive.recording.table.rows(),
                     time.back() - time.front(), base::sha256_of_file(drive.name).substr(0, 16))});
  }
  base::write_file(command.out_path, report::plot_page(page));
  if (terminal.json)
    terminal.print(base::json_text(nlohmann::ordered_json{
        {"curves", page.plots.size()}, {"drives", command.telemetry}, {"page", command.out_path}}));
  else
    terminal.print(fmt::format("{} curves of {} drives: {}\n", page.plots.size(), drives.size(),
                               command.out_path));
  return kOk;
}

}  // namespace crgdrive
