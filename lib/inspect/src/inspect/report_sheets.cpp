#include "report_sheets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "nan.h"

namespace road {
namespace {

/// Rows and columns of the map as a grid in space.
report::Sheet sheet_of(const HeightMap& map, std::size_t row_begin, std::size_t row_end,
                       std::size_t row_stride, double v_step_m) {
  report::Sheet sheet;
  sheet.u_begin_m = map.u_of(row_begin);
  sheet.u_step_m = map.line.u_step_m * static_cast<double>(row_stride);
  sheet.z_base_m = map.z_base_m;
  std::vector<std::size_t> rows, columns;
  for (std::size_t i = row_begin; i < row_end; i += row_stride) rows.push_back(i);
  for (std::size_t j = 0; j < map.columns(); ++j) {
    if (columns.empty() || map.v_m[j] - map.v_m[columns.back()] >= v_step_m ||
        j + 1 == map.columns())
      columns.push_back(j);
  }
  for (const std::size_t j : columns) sheet.v_m.push_back(map.v_m[j]);
  for (const std::size_t i : rows) {
    const crg::Point2 middle = crg::node_position(map.line, i, 0.0),
                      one = crg::node_position(map.line, i, 1.0);
    sheet.x_m.push_back(middle.x_m);
    sheet.y_m.push_back(middle.y_m);
    sheet.normal_x.push_back(one.x_m - middle.x_m);
    sheet.normal_y.push_back(one.y_m - middle.y_m);
    for (const std::size_t j : columns) sheet.z_m.push_back(map.at(i, j));
  }
  return sheet;
}

/// `value(u, v)` at every node of a sheet.
template <typename Value>
std::vector<float> on_sheet(const report::Sheet& sheet, const Value& value) {
  std::vector<float> values;
  values.reserve(sheet.z_m.size());
  for (std::size_t i = 0; i < sheet.x_m.size(); ++i) {
    const double u_m = sheet.u_begin_m + static_cast<double>(i) * sheet.u_step_m;
    for (std::size_t j = 0; j < sheet.v_m.size(); ++j) {
      values.push_back(std::isnan(sheet.z_m[i * sheet.v_m.size() + j])
                           ? kNanF
                           : static_cast<float>(value(u_m, sheet.v_m[j])));
    }
  }
  return values;
}

std::size_t row_of(const HeightMap& map, double u_m) {
  return static_cast<std::size_t>(std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m + 0.5,
                                             0.0, static_cast<double>(map.rows() - 1)));
}

/// What is the same over the whole width of a row.
void add_row_fields(report::Sheet& sheet, const HeightMap& map, const AlongU& along) {
  const auto add = [&](const char* key, const char* name, const char* unit,
                       const std::vector<float>& curve, double factor) {
    sheet.fields.push_back(
        {key,
         name,
         unit,
         on_sheet(sheet, [&](double u_m, double) { return curve[row_of(map, u_m)]; }),
         factor,
         true,
         {}});
  };
  add("slope", "Slope", "%", along.slope, 100.0);
  add("banking", "Banking", "%", along.banking, 100.0);
  // Curvature in 1/km, so that its numbers survive the page's steps of 1e-5.
  std::vector<float> per_km = along.curvature_1pm;
  for (float& value : per_km) value *= 1000.0f;
  add("curvature", "Curvature", "1/m", per_km, 1e-3);
}

void add_error_field(report::Sheet& sheet, const std::string& key, const Comparison& comparison) {
  const double v_cell_m = comparison.v_m.size() > 1 ? comparison.v_m[1] - comparison.v_m[0] : 1.0;
  const auto error_m = [&](double u_m, double v_m) {
    const double i = std::clamp((u_m - comparison.u_begin_m) / comparison.u_cell_m, 0.0,
                                static_cast<double>(comparison.rows - 1));
    const double j = std::clamp((v_m - comparison.v_m[0]) / v_cell_m + 0.5, 0.0,
                                static_cast<double>(comparison.v_m.size() - 1));
    return comparison
        .error_m[static_cast<std::size_t>(i) * comparison.v_m.size() + static_cast<std::size_t>(j)];
  };
  sheet.fields.push_back(
      {"error_" + key, "Error (" + key + ")", "mm", on_sheet(sheet, error_m), 1000.0, true, {}});
}

void add_provenance_field(report::Sheet& sheet, const HeightMap& map,
                          const std::vector<Provenance>& provenance) {
  const auto at = [&](double u_m, double v_m) {
    const auto j = static_cast<std::size_t>(
        std::lower_bound(map.v_m.begin(), map.v_m.end(), v_m - 1e-9) - map.v_m.begin());
    return static_cast<double>(
        provenance[row_of(map, u_m) * map.columns() + std::min(j, map.columns() - 1)]);
  };
  sheet.fields.push_back({"provenance",
                          "Provenance",
                          "",
                          on_sheet(sheet, at),
                          1.0,
                          false,
                          {"none", "measured on the mesh", "filled"}});
}

constexpr std::size_t kMostWindows = 24;
constexpr std::size_t kMostWindowNodes = 400'000;  // of all windows

constexpr double kWindow_m = 16.0;

}  // namespace

report::Sheet whole_road(const HeightMap& map, const AlongU& along, const Comparisons& comparisons,
                         const crg::Surface* grip, const std::vector<Provenance>* provenance) {
  const double length_m = map.u_end_m() - map.line.u_begin_m;
  const auto stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::max(0.5, length_m / 4000.0) / map.line.u_step_m + 0.5));
  report::Sheet sheet = sheet_of(map, 0, map.rows(), stride,
                                 std::max(0.3, (map.v_m.back() - map.v_m.front()) / 32.0));
  sheet.title = "whole road";
  add_row_fields(sheet, map, along);
  for (const auto& [key, comparison] : comparisons) add_error_field(sheet, key, comparison);
  if (grip != nullptr) {
    const auto grip_at = [&](double u_m, double v_m) { return grip->z_at_uv(u_m, v_m); };
    sheet.fields.push_back({"grip", "Grip", "1", on_sheet(sheet, grip_at), 1.0, false, {}});
  }
  if (provenance != nullptr) add_provenance_field(sheet, map, *provenance);
  return sheet;
}

void add_windows(const HeightMap& map, const std::vector<Finding>& findings,
                 const KerbStrips& kerbs, report::TrackReport& report) {
  std::vector<std::pair<double, std::string>> places;
  const auto add = [&](double u_m, std::string title) {
    const bool near = std::any_of(places.begin(), places.end(), [&](const auto& p) {
      return std::abs(p.first - u_m) < 0.5 * kWindow_m;
    });
    if (!near && places.size() < kMostWindows) places.emplace_back(u_m, std::move(title));
  };
  for (const Severity severity : {Severity::error, Severity::remark}) {
    for (const Finding& f : findings) {
      if (f.severity != severity ||
          f.u_end_m - f.u_begin_m > 0.5 * (map.u_end_m() - map.line.u_begin_m))
        continue;
      if (places.size() < kMostWindows * 2 / 3)
        add(0.5 * (f.u_begin_m + std::min(f.u_end_m, f.u_begin_m + kWindow_m)),
            fmt::format("{} at u = {:.1f} m", f.kind, f.u_begin_m));
    }
  }
  std::vector<KerbStrip> by_height = kerbs.strips;
  std::stable_sort(by_height.begin(), by_height.end(),
                   [](const KerbStrip& a, const KerbStrip& b) { return a.height_m > b.height_m; });
  for (const KerbStrip& kerb : by_height)
    add(kerb.u_of_profile_m,
        fmt::format("{} kerb at u = {:.1f} m", kerb.left ? "left" : "right", kerb.u_of_profile_m));
  std::size_t nodes = 0;
  for (const auto& [u_m, title] : places) {
    const double first = (u_m - 0.5 * kWindow_m - map.line.u_begin_m) / map.line.u_step_m;
    const auto begin =
        static_cast<std::size_t>(std::clamp(first, 0.0, static_cast<double>(map.rows() - 2)));
    const auto count =
        std::max<std::size_t>(2, static_cast<std::size_t>(kWindow_m / map.line.u_step_m) + 1);
    const std::size_t end = std::min(map.rows(), begin + count);
    if (end - begin < 2) continue;
    report::Sheet window = sheet_of(map, begin, end, std::max<std::size_t>(1, count / 400), 0.0);
    if (window.z_m.size() > std::min<std::size_t>(120'000, kMostWindowNodes - nodes)) continue;
    nodes += window.z_m.size();
    window.title = title;
    report.windows.push_back(std::move(window));
  }
}

void add_detail(const HeightMap& map, report::TrackReport& report) {
  constexpr std::size_t kMostNodes = 500'000;
  const std::size_t stride =
      std::max({std::size_t{1}, (map.rows() * map.columns() + kMostNodes - 1) / kMostNodes,
                static_cast<std::size_t>(0.25 / map.line.u_step_m + 1e-9)});
  report::Sheet& detail = report.detail;
  detail.u_begin_m = map.u_of(0);
  detail.u_step_m = map.line.u_step_m * static_cast<double>(stride);
  detail.z_base_m = map.z_base_m;
  detail.v_m = map.v_m;
  for (std::size_t i = 0; i < map.rows(); i += stride) {
    for (std::size_t j = 0; j < map.columns(); ++j) detail.z_m.push_back(map.at(i, j));
  }
}

}  // namespace road
