#include "road/write_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "base/parallel.h"
#include "base/sha256.h"
#include "base/statistics.h"
#include "base/write_file.h"
#include "crg/check.h"
#include "crg/surface.h"
#include "report/track_report.h"
#include "road/compare.h"
#include "road/error.h"
#include "road/height_map.h"
#include "road/kerb_strips.h"
#include "road/ray_surface.h"
#include "road/roughness.h"
#include "road/summary.h"

namespace road {

namespace {

constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// As the reader of the report finds it.
std::string shown_path(const std::string& path, const ReportRequest& request) {
  const bool moves =
      !request.shown_folder.empty() && std::filesystem::path(path).parent_path() ==
                                           std::filesystem::path(request.crg_path).parent_path();
  return moves ? (std::filesystem::path(request.shown_folder) / file_name(path)).string() : path;
}

// --- along u -----------------------------------------------------------------------------------

constexpr std::size_t kMostCurvePoints = 60'000;

double heading_change(double from, double to) {
  return std::remainder(to - from, 2.0 * std::numbers::pi);
}

/// Change of heading per metre over 2 m: single steps of float32 headings are noise.
std::vector<float> curvature_of(const HeightMap& map) {
  const crg::ReferenceLine& line = map.line;
  std::vector<float> curvature(map.rows(), 0.0f);
  const auto reach = std::max<std::size_t>(1, static_cast<std::size_t>(1.0 / line.u_step_m + 0.5));
  for (std::size_t i = 0; i < map.rows(); ++i) {
    // heading[k] belongs to the segment before node k, so the segments i - reach + 1 .. i + reach
    // span the change.
    const std::size_t low = std::max<std::size_t>(1, i >= reach ? i - reach + 1 : 1),
                      high = std::min(map.rows() - 1, i + reach);
    if (high <= low) continue;
    curvature[i] =
        static_cast<float>(heading_change(line.heading_rad[low], line.heading_rad[high]) /
                           (static_cast<double>(high - low) * line.u_step_m));
  }
  return curvature;
}

/// Rise per metre of the height over 2 m.
std::vector<float> slope_of(const std::vector<double>& z_m, double u_step_m) {
  std::vector<float> slope(z_m.size(), kNanF);
  const auto reach = std::max<std::size_t>(1, static_cast<std::size_t>(1.0 / u_step_m + 0.5));
  for (std::size_t i = 0; i < z_m.size(); ++i) {
    const std::size_t low = i >= reach ? i - reach : 0, high = std::min(z_m.size() - 1, i + reach);
    slope[i] =
        static_cast<float>((z_m[high] - z_m[low]) / (static_cast<double>(high - low) * u_step_m));
  }
  return slope;
}

/// Least-squares slope across, over what has a height within 3 m of the reference line (or of the
/// middle of the road where the line has none).
std::vector<float> banking_of(const HeightMap& map, const std::vector<RowExtent>& extents) {
  std::vector<float> banking(map.rows(), kNanF);
  base::parallel_for(map.rows(), 512, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (extents[i].empty()) continue;
      const double low = map.v_m[extents[i].first], high = map.v_m[extents[i].last];
      const double middle = low < -1.0 && high > 1.0 ? 0.0 : 0.5 * (low + high);
      double n = 0, sv = 0, sz = 0, svv = 0, svz = 0;
      const auto from = static_cast<std::size_t>(
          std::lower_bound(map.v_m.begin(), map.v_m.end(), middle - 3.0) - map.v_m.begin());
      for (std::size_t j = from; j < map.columns() && map.v_m[j] <= middle + 3.0; ++j) {
        const double z = map.at(i, j), v = map.v_m[j];
        if (std::isnan(z)) continue;
        n += 1, sv += v, sz += z, svv += v * v, svz += v * z;
      }
      const double spread = n * svv - sv * sv;
      if (n >= 3 && spread > 0.0) banking[i] = static_cast<float>((n * svz - sv * sz) / spread);
    }
  });
  return banking;
}

std::vector<float> every(const std::vector<float>& values, std::size_t stride) {
  std::vector<float> result;
  for (std::size_t i = 0; i < values.size(); i += stride) result.push_back(values[i]);
  return result;
}

struct AlongU {
  std::vector<float> elevation_m, slope, banking, curvature_1pm, width_m, v_left_m, v_right_m;
};

AlongU along_u(const HeightMap& map, const std::vector<RowExtent>& extents) {
  AlongU curves;
  // The height of the middle of the road where the reference line has none.
  std::vector<double> z_m = long_section(map, 0.0);
  for (std::size_t i = 0; i < map.rows(); ++i) {
    if (std::isnan(z_m[i]) && !extents[i].empty())
      z_m[i] = map.at(i, (extents[i].first + extents[i].last) / 2);
  }
  curves.slope = slope_of(z_m, map.line.u_step_m);
  curves.curvature_1pm = curvature_of(map);
  curves.banking = banking_of(map, extents);
  for (std::size_t i = 0; i < map.rows(); ++i) {
    curves.elevation_m.push_back(static_cast<float>(z_m[i] + map.z_base_m));
    const bool bare = extents[i].empty();
    curves.v_right_m.push_back(bare ? kNanF : static_cast<float>(map.v_m[extents[i].first]));
    curves.v_left_m.push_back(bare ? kNanF : static_cast<float>(map.v_m[extents[i].last]));
    curves.width_m.push_back(curves.v_left_m.back() - curves.v_right_m.back());
  }
  return curves;
}

void add_curves(const HeightMap& map, const AlongU& along,
                const std::vector<std::pair<std::string, const Comparison*>>& comparisons,
                report::TrackReport& report) {
  const std::size_t stride = (map.rows() + kMostCurvePoints - 1) / kMostCurvePoints;
  report.u_begin_m = map.line.u_begin_m;
  report.u_step_m = map.line.u_step_m * static_cast<double>(stride);
  report.u_end_m = map.u_end_m();
  const auto add = [&](const char* key, const char* name, const char* unit,
                       const std::vector<float>& values, double factor = 1.0) {
    report.curves.push_back({key, name, unit, every(values, stride), factor});
  };
  add("elevation_m", "Elevation", "m", along.elevation_m);
  add("slope", "Slope", "%", along.slope, 100.0);
  add("banking", "Banking", "%", along.banking, 100.0);
  add("curvature_1pm", "Curvature", "1/m", along.curvature_1pm);
  add("width_m", "Width", "m", along.width_m);
  add("v_left_m", "Left limit v", "m", along.v_left_m);
  add("v_right_m", "Right limit v", "m", along.v_right_m);
  for (const auto& [key, comparison] : comparisons) {
    std::vector<float> largest(map.rows(), kNanF);
    const std::size_t columns = comparison->v_m.size();
    std::vector<float> of_row(comparison->rows, kNanF);
    for (std::size_t k = 0; k < comparison->error_m.size(); ++k) {
      const float size = std::abs(comparison->error_m[k]);
      float& best = of_row[k / columns];
      if (!(best >= size) && !std::isnan(size)) best = size;
    }
    for (std::size_t i = 0; i < map.rows(); ++i) {
      const double row = (map.u_of(i) - comparison->u_begin_m) / comparison->u_cell_m;
      largest[i] = of_row[static_cast<std::size_t>(
          std::clamp(row, 0.0, static_cast<double>(comparison->rows - 1)))];
    }
    report.curves.push_back({"largest_error_" + key + "_m", "Largest error (" + key + ")", "mm",
                             every(largest, stride), 1000.0});
  }
}

// --- sheets ------------------------------------------------------------------------------------

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

void add_fields(report::Sheet& sheet, const HeightMap& map, const AlongU& along,
                const std::vector<std::pair<std::string, const Comparison*>>& comparisons,
                const crg::Surface* grip, const std::vector<Provenance>* provenance) {
  const auto row_of = [&](double u_m) {
    return static_cast<std::size_t>(std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m + 0.5,
                                               0.0, static_cast<double>(map.rows() - 1)));
  };
  const auto add_row_field = [&](const char* key, const char* name, const char* unit,
                                 const std::vector<float>& curve, double factor) {
    sheet.fields.push_back({key,
                            name,
                            unit,
                            on_sheet(sheet, [&](double u_m, double) { return curve[row_of(u_m)]; }),
                            factor,
                            true,
                            {}});
  };
  add_row_field("slope", "Slope", "%", along.slope, 100.0);
  add_row_field("banking", "Banking", "%", along.banking, 100.0);
  // Curvature in 1/km, so that its numbers survive the page's steps of 1e-5.
  std::vector<float> per_km = along.curvature_1pm;
  for (float& value : per_km) value *= 1000.0f;
  add_row_field("curvature", "Curvature", "1/m", per_km, 1e-3);
  for (const auto& [key, c] : comparisons) {
    const double v_cell_m = c->v_m.size() > 1 ? c->v_m[1] - c->v_m[0] : 1.0;
    sheet.fields.push_back(
        {"error_" + key,
         "Error (" + key + ")",
         "mm",
         on_sheet(
             sheet,
             [&, comparison = c](double u_m, double v_m) {
               const double i = std::clamp((u_m - comparison->u_begin_m) / comparison->u_cell_m,
                                           0.0, static_cast<double>(comparison->rows - 1));
               const double j = std::clamp((v_m - comparison->v_m[0]) / v_cell_m + 0.5, 0.0,
                                           static_cast<double>(comparison->v_m.size() - 1));
               return comparison->error_m[static_cast<std::size_t>(i) * comparison->v_m.size() +
                                          static_cast<std::size_t>(j)];
             }),
         1000.0,
         true,
         {}});
  }
  if (grip != nullptr) {
    sheet.fields.push_back(
        {"grip",
         "Grip",
         "1",
         on_sheet(sheet, [&](double u_m, double v_m) { return grip->z_at_uv(u_m, v_m); }),
         1.0,
         false,
         {}});
  }
  if (provenance != nullptr) {
    sheet.fields.push_back(
        {"provenance",
         "Provenance",
         "",
         on_sheet(sheet,
                  [&](double u_m, double v_m) {
                    const auto j = static_cast<std::size_t>(
                        std::lower_bound(map.v_m.begin(), map.v_m.end(), v_m - 1e-9) -
                        map.v_m.begin());
                    return static_cast<double>((
                        *provenance)[row_of(u_m) * map.columns() + std::min(j, map.columns() - 1)]);
                  }),
         1.0,
         false,
         {"none", "measured on the mesh", "filled"}});
  }
}

/// Heights at every v, in rows about 0.25 m apart or as close as 3 MB of the page allow.
void add_detail(const HeightMap& map, report::TrackReport& report) {
  constexpr std::size_t kMostNodes = 1'000'000;
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

constexpr std::size_t kMostWindows = 24;
constexpr double kWindow_m = 16.0;

/// Full detail around findings first, then kerbs from high to low.
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
  for (const auto& [u_m, title] : places) {
    const double first = (u_m - 0.5 * kWindow_m - map.line.u_begin_m) / map.line.u_step_m;
    const auto begin =
        static_cast<std::size_t>(std::clamp(first, 0.0, static_cast<double>(map.rows() - 2)));
    const auto count =
        std::max<std::size_t>(2, static_cast<std::size_t>(kWindow_m / map.line.u_step_m) + 1);
    const std::size_t end = std::min(map.rows(), begin + count);
    if (end - begin < 2) continue;
    report::Sheet window = sheet_of(map, begin, end, std::max<std::size_t>(1, count / 400), 0.0);
    if (window.z_m.size() > 120'000) continue;
    window.title = title;
    report.windows.push_back(std::move(window));
  }
}

// --- comparisons, kerbs, roughness ---------------------------------------------------------------

std::vector<double> heights_at(const HeightMap& map, double u_m,
                               const std::vector<double>& at_v_m) {
  const auto row =
      static_cast<std::size_t>(std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m + 0.5, 0.0,
                                          static_cast<double>(map.rows() - 1)));
  std::vector<double> z_m;
  for (const double v_m : at_v_m) {
    const auto j = static_cast<std::size_t>(
        std::upper_bound(map.v_m.begin() + 1, map.v_m.end() - 1, v_m) - map.v_m.begin());
    const double t = (v_m - map.v_m[j - 1]) / (map.v_m[j] - map.v_m[j - 1]), a = map.at(row, j - 1),
                 b = map.at(row, j);
    const double z = t <= 0.0 ? a : t >= 1.0 ? b : a + t * (b - a);
    z_m.push_back(v_m < map.v_m.front() || v_m > map.v_m.back() ? kNan : z + map.z_base_m);
  }
  return z_m;
}

report::ComparisonView view_of(const Comparison& c, std::string key, std::string reference) {
  report::ComparisonView view;
  view.u_begin_m = c.u_begin_m;
  view.u_cell_m = c.u_cell_m;
  view.v_m = c.v_m;
  view.rows = c.rows;
  view.error_m = c.error_m;
  view.without_reference = c.without_reference;
  view.points = c.points;
  view.share_without_reference = c.share_without_reference;
  view.mean_m = c.mean_error_m;
  view.p50_m = c.abs_error_m.p50;
  view.p95_m = c.abs_error_m.p95;
  view.p99_m = c.abs_error_m.p99;
  view.max_m = c.abs_error_m.max;
  view.histogram_begin_m = c.histogram_begin_m;
  view.histogram_step_m = c.histogram_step_m;
  view.histogram = c.histogram;
  for (const CrossCut& cut : c.worst) {
    view.worst.push_back({fmt::format("u = {:.1f} m, v = {:.2f} m: {:+.1f} mm", cut.u_m, cut.v_m,
                                      1000.0 * cut.error_m),
                          cut.u_m,
                          cut.v_m,
                          cut.error_m,
                          cut.at_v_m,
                          {{"file", cut.file_z_m}, {key, cut.reference_z_m}}});
  }
  view.key = std::move(key);
  view.reference = std::move(reference);
  return view;
}

void add_kerbs(const HeightMap& map, const KerbStrips& kerbs,
               const std::vector<std::pair<std::string, const Comparison*>>& comparisons,
               report::TrackReport& report) {
  for (std::size_t k = 0; k < kerbs.strips.size(); ++k) {
    const KerbStrip& strip = kerbs.strips[k];
    report::KerbView view;
    view.u_begin_m = strip.u_begin_m;
    view.u_end_m = strip.u_end_m;
    view.v_begin_m = strip.v_begin_m;
    view.v_end_m = strip.v_end_m;
    view.height_m = strip.height_m;
    view.width_m = strip.width_m;
    view.side = strip.left ? "left" : "right";
    const auto [low, high] = std::minmax(strip.v_begin_m, strip.v_end_m);
    view.profile.title = fmt::format("{} kerb, u = {:.1f} m", view.side, strip.u_of_profile_m);
    view.profile.u_m = strip.u_of_profile_m;
    view.profile.v_m = 0.5 * (low + high);
    view.profile.value_m = strip.height_m;
    if (!comparisons.empty()) {
      view.profile.at_v_m = comparisons.front().second->kerb_cuts[k].at_v_m;
    } else {
      for (double v = std::max(low - 1.5, map.v_m.front());
           v <= std::min(high + 1.5, map.v_m.back()); v += 0.05)
        view.profile.at_v_m.push_back(v);
    }
    view.profile.lines.emplace_back("file",
                                    heights_at(map, strip.u_of_profile_m, view.profile.at_v_m));
    for (const auto& [key, c] : comparisons)
      view.profile.lines.emplace_back(key, c->kerb_cuts[k].reference_z_m);
    report.kerbs.push_back(std::move(view));
  }
}

/// Half of a car's track width; the wheel paths lie this far beside the middle of the road.
constexpr double kHalfTrack_m = 0.8;

double middle_of_road(const HeightMap& map, const std::vector<RowExtent>& extents) {
  std::size_t good = 0;
  std::vector<double> middles;
  for (const RowExtent& extent : extents) {
    if (extent.empty()) continue;
    good += map.v_m[extent.first] <= -kHalfTrack_m && map.v_m[extent.last] >= kHalfTrack_m;
    middles.push_back(0.5 * (map.v_m[extent.first] + map.v_m[extent.last]));
  }
  if (middles.empty() || 20 * good >= 19 * middles.size()) return 0.0;
  return base::median(std::move(middles));
}

/// Whether a wheel path rides the same before and after: IRI to its last digit in the report.
bool rides_the_same(const report::RoughnessTrack& a, const report::RoughnessTrack& b) {
  return std::ranges::equal(a.iri, b.iri, [](const auto& s, const auto& t) {
    return (std::isnan(s.iri_m_per_km) && std::isnan(t.iri_m_per_km)) ||
           std::abs(s.iri_m_per_km - t.iri_m_per_km) < 0.005;
  });
}

/// The tracks of the road before refinement are left out where they ride as those after it.
void add_roughness(const HeightMap& map, double middle_m, bool before,
                   report::TrackReport& report) {
  const double step_m = map.line.u_step_m;
  for (const bool left : {true, false}) {
    report::RoughnessTrack track;
    track.name = fmt::format("{} wheel{}", left ? "left" : "right", before ? " before" : "");
    track.before = before;
    track.v_m = middle_m + (left ? kHalfTrack_m : -kHalfTrack_m);
    const std::vector<std::vector<double>> sections{long_section(map, track.v_m)};
    DisplacementPsd psd = displacement_psd(sections, step_m);
    if (const auto fit = fit_iso8608(psd)) {
      track.iso_class = std::string(1, fit->iso_class);
      track.psd_at_n0_m3 = fit->psd_at_n0_m3;
      track.exponent = fit->exponent;
      track.fit_n_min_cpm = fit->n_min_cpm;
      track.fit_n_max_cpm = fit->n_max_cpm;
      track.band_cut = fit->band_cut;
    }
    if (const auto facets = facet_spacing(sections[0], step_m)) {
      track.facet_median_m = facets->median_m;
      track.facet_p10_m = facets->p10_m;
      track.facet_p90_m = facets->p90_m;
    }
    track.n_cpm = std::move(psd.n_cpm);
    track.psd_m3 = std::move(psd.psd_m3);
    if (step_m <= 0.3) {
      for (const IriSegment& segment : iri(sections[0], step_m)) {
        track.iri.push_back({map.line.u_begin_m + segment.begin_m,
                             map.line.u_begin_m + segment.end_m, segment.iri_m_per_km});
      }
    }
    if (before && !track.iri.empty() && rides_the_same(report.roughness[left ? 0 : 1], track))
      continue;
    report.roughness.push_back(std::move(track));
  }
}

// --- what the file is ----------------------------------------------------------------------------

const char* format_name(crg::Format format) {
  switch (format) {
    case crg::Format::KRBI:
      return "KRBI (float32, binary)";
    case crg::Format::KDBI:
      return "KDBI (float64, binary)";
    case crg::Format::LRFI:
      return "LRFI (text, 10 characters)";
    case crg::Format::LDFI:
      return "LDFI (text, 20 characters)";
  }
  return "";
}

void add_header(const crg::Crg& file, report::TrackReport& report) {
  const auto section = [&](const char* name, const std::vector<crg::HeaderEntry>& entries,
                           bool present) {
    if (!present) return;
    if (entries.empty()) report.header.push_back({name, "(empty)"});
    for (const crg::HeaderEntry& entry : entries) {
      if (entry.key == "*") continue;
      report.header.push_back({fmt::format("{} {}", name, entry.key),
                               entry.text.empty() ? fmt::format("{}", entry.value) : entry.text});
    }
  };
  section("ROAD_CRG", file.road, true);
  section("ROAD_CRG_OPTS", file.options, file.has_option_section || !file.options.empty());
  section("ROAD_CRG_MODS", file.modifiers, file.has_modifier_section);
  section("ROAD_CRG_MPRO", file.projection, !file.projection.empty());
  report.comment = file.comment;
}

void add_facts(const HeightMap& map, const AlongU& along, const crg::Crg& file,
               const ReportRequest& request, const KerbStrips& kerbs,
               const std::optional<ValidateReport>& validated, report::TrackReport& report) {
  const auto fact = [&](const char* name, std::string value) {
    report.facts.push_back({name, std::move(value)});
  };
  const auto extremes = [](const std::vector<float>& values) {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (const float value : values) {
      if (std::isnan(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    return std::pair<double, double>(low, high);
  };
  const GridReport grid = describe(file.grid, map.line);
  fact("Length", fmt::format("{:.1f} m, {}", map.u_end_m() - map.line.u_begin_m,
                             map.line.closed ? "closed" : "open"));
  const auto width = [](double low_m, double median_m, double high_m) {
    return fmt::format("{:.1f} m ({:.1f} to {:.1f} m)", median_m, low_m, high_m);
  };
  if (request.road_width_m)
    fact("Width of the road",
         width((*request.road_width_m)[0], (*request.road_width_m)[1], (*request.road_width_m)[2]));
  if (grid.nodes_with_z > 0) {
    fact("Width of all that has a height",
         width(grid.width_min_m, grid.width_median_m, grid.width_max_m));
    fact("Kerbs", fmt::format("{}{}", kerbs.strips.size(),
                              request.kerbs ? "" : ", by the shape of the road"));
    if (validated)
      fact("Largest error against the mesh",
           fmt::format("{:.2f} mm", 1e3 * validated->z_error_m.max));
    fact("z", fmt::format("{:.3f} to {:.3f} m", grid.z_min_m, grid.z_max_m));
    const auto [z_low, z_high] = extremes(along.elevation_m);
    fact("Elevation of the line", fmt::format("{:.1f} to {:.1f} m", z_low, z_high));
    const auto [s_low, s_high] = extremes(along.slope);
    fact("Slope", fmt::format("{:+.1f} to {:+.1f} %", 100.0 * s_low, 100.0 * s_high));
    const auto [b_low, b_high] = extremes(along.banking);
    fact("Banking", fmt::format("{:+.1f} to {:+.1f} %", 100.0 * b_low, 100.0 * b_high));
  }
  const auto [k_low, k_high] = extremes(along.curvature_1pm);
  const double tightest = std::max(std::abs(k_low), std::abs(k_high));
  fact("Tightest radius", tightest > 1e-6 ? fmt::format("{:.1f} m", 1.0 / tightest) : "straight");
  fact("Grid",
       fmt::format("{} x {} nodes, {:.3g} m x {:.3g} m", map.rows(), map.columns(),
                   map.line.u_step_m,
                   (map.v_m.back() - map.v_m.front()) / static_cast<double>(map.columns() - 1)));
  const auto row = [&](const char* name, std::string value) {
    report.file.push_back({name, std::move(value)});
  };
  std::error_code ignored;
  row("File", shown_path(request.crg_path, request));
  row("Size", fmt::format("{} bytes", std::filesystem::file_size(request.crg_path, ignored)));
  row("Format", format_name(file.format));
  row("Rows x columns", fmt::format("{} x {}", map.rows(), map.columns()));
  row("u", fmt::format("{:.3f} to {:.3f} m, step {:.6f} m", map.line.u_begin_m, map.u_end_m(),
                       map.line.u_step_m));
  row("v", fmt::format("{:.3f} to {:.3f} m", map.v_m.front(), map.v_m.back()));
  row("Nodes with height", fmt::format("{} of {}", grid.nodes_with_z, grid.nodes));
  row("Missing nodes inside the road", fmt::format("{}", grid.holes));
  row("Closed", map.line.closed ? "yes" : "no");
  row("Modifiers",
      file.has_modifier_section
          ? (file.modifiers.empty() ? "none (empty section)" : "those of the file are applied")
          : "none (no section: the reference API would move the road by default)");
  if (!file.included_path.empty()) row("Included file", file.included_path);
}

/// What would have been a finding; a clean verdict says no more than that.
void add_looked_for(const FindingOptions& options,
                    const std::vector<std::pair<std::string, Comparison>>& comparisons,
                    report::TrackReport& report) {
  const auto say = [&](std::string text) { report.looked_for.push_back(std::move(text)); };
  const auto mm = [](double length_m) { return fmt::format("{:.4g} mm", 1000.0 * length_m); };
  say("Holes of one node or more, rows and stripes without road, bends in which the grid folds, "
      "and what 'crgbuild check' finds");
  say(fmt::format("Steps across the road from {} on that at least {:.0f} % of its width make alike",
                  mm(options.min_tile_step_m), 100.0 * options.min_tile_share));
  say(
      fmt::format("Bumps and potholes from {} on over the road 3 to 9 m before and behind, or from "
                  "5.5 times the scatter of the road there; "
                  "lower ones, those longer than about 6 m, and any on kerbs are not looked for",
                  mm(options.min_bump_m)));
  if (options.closed)
    say(fmt::format(
        "Steps from {}, kinks from {:.4g} mrad and gaps from {} on where the road closes",
        mm(options.min_seam_step_m), 1000.0 * options.min_seam_heading_rad,
        mm(options.max_seam_gap_m)));
  const CompareOptions compared;
  bool mesh = false;
  for (const auto& [key, comparison] : comparisons) {
    mesh = mesh || key == "mesh";
    const std::string lost =
        fmt::format("kerbs that are lower from {} on over {:.4g} m", mm(compared.min_kerb_loss_m),
                    compared.min_kerb_loss_length_m);
    if (key == "before")
      say(fmt::format("Against the road before refinement: {}", lost));
    else
      say(fmt::format("Against the {}: places from {} on over {:.4g} m2 or more, {}{}",
                      key == "against" ? "other road" : key, mm(compared.min_deviation_m),
                      compared.min_deviation_area_m2, lost,
                      key == "mesh"
                          ? fmt::format("; smaller places from {} on are listed and are no finding",
                                        mm(report.rough_limit_m))
                          : ""));
  }
  if (!mesh) say("Whether the road is where its mesh is: not looked at, no mesh was given");
}

/// Kerbs found on the mesh in the form of those found by shape.
KerbStrips strips_of(const std::vector<Kerb>& kerbs) {
  KerbStrips result;
  for (const Kerb& kerb : kerbs) {
    const bool left = kerb.v_begin_m + kerb.v_end_m > 0.0;
    const auto [inner_m, outer_m] =
        left ? std::pair(kerb.v_begin_m, kerb.v_end_m) : std::pair(kerb.v_end_m, kerb.v_begin_m);
    result.strips.push_back({kerb.u_begin_m, kerb.u_end_m, left, inner_m, outer_m, kerb.height_m,
                             kerb.v_end_m - kerb.v_begin_m, kerb.u_highest_m});
  }
  return result;
}

struct Loaded {
  std::optional<crg::Surface> against, before, grip;
  std::optional<Mesh> mesh;
  std::optional<RaySurface> rays;
};

Verdict verdict_named(const std::string& name) {
  for (const Verdict verdict : {Verdict::usable, Verdict::usable_with_remarks, Verdict::not_usable})
    if (name == to_string(verdict)) return verdict;
  throw Error(
      fmt::format("verdict '{}' seen, usable, usable_with_remarks or not_usable wanted", name));
}

}  // namespace

report::TrackReport make_report(const ReportRequest& request) {
  report::TrackReport report;
  report.title = request.title.empty() ? file_name(request.crg_path) : request.title;
  report.command_line = request.command_line;
  const auto also = [&](const char* role, const std::string& path) {
    report.inputs.push_back({role, shown_path(path, request), base::sha256_of_file(path)});
  };
  also("road", request.crg_path);

  crg::Crg stored = crg::read(request.crg_path);
  const crg::CheckReport checked = crg::check(stored);
  const crg::Surface surface(std::move(stored));
  const crg::Crg& file = surface.file();
  const HeightMap map = height_map(surface);
  const std::vector<RowExtent> extents = row_extents(map);
  if (request.provenance != nullptr && request.provenance->size() != map.z_m.size()) {
    throw Error(fmt::format("{}: {} values of provenance for {} nodes", request.crg_path,
                            request.provenance->size(), map.z_m.size()));
  }
  const KerbStrips kerbs = find_kerb_strips(map);
  FindingOptions finding_options;
  finding_options.closed = map.line.closed;
  finding_options.threads = request.threads;
  std::vector<Finding> findings = find_defects(map, kerbs, finding_options);

  // Everything there is to compare with.
  Loaded loaded;
  RotoTranslation T_global_mesh = request.T_global_mesh;
  TiltAndScale tilt_and_scale;
  if (!request.control_points.empty()) {
    const AlignReport aligned = fit_alignment(request.control_points, request.align);
    T_global_mesh = aligned.T_global_mesh;
    tilt_and_scale = aligned.tilt_and_scale;
    for (std::size_t k = 0; k < request.control_points.size(); ++k) {
      const ControlPoint& point = request.control_points[k];
      const bool left_out = std::find(aligned.outliers.begin(), aligned.outliers.end(),
                                      point.name) != aligned.outliers.end();
      report.control_points.push_back(
          {point.name, point.global_m.x(), point.global_m.y(), aligned.residual_m[k], left_out});
    }
  }
  std::optional<ValidateReport> validated;
  std::vector<std::pair<std::string, Comparison>> comparisons;
  const KerbStrips shown_kerbs = request.kerbs ? strips_of(*request.kerbs) : kerbs;
  const auto compare_with = [&](const std::string& key, const std::string& name,
                                const ReferenceHeights& reference, bool is_truth,
                                std::span<const PlaceError> known = {}) {
    CompareOptions options;
    options.max_cells = 600'000;  // 2.4 MB of the page each
    options.reference_is_truth = is_truth;
    options.threads = request.threads;
    comparisons.emplace_back(key, compare(map, shown_kerbs, reference, name, options, known));
  };
  const auto read_surface = [&](const std::string& path) { return crg::Surface(crg::read(path)); };
  if (request.mesh != nullptr || !request.mesh_path.empty()) {
    if (request.mesh == nullptr) {
      loaded.mesh = read_mesh(request.mesh_path, request.read);
      apply_to_mesh(tilt_and_scale, *loaded.mesh);
    }
    if (!request.mesh_path.empty()) also("mesh", request.mesh_path);
    loaded.rays.emplace(request.mesh != nullptr ? *request.mesh : *loaded.mesh);
    ValidateOptions validation = request.validate;
    validation.T_global_mesh = T_global_mesh;
    validated =
        request.validated ? *request.validated : validate(surface, *loaded.rays, validation);
    report.rough_limit_m = validation.named_error_m;
    std::vector<PlaceError> known{
        {validated->worst_u_m, validated->worst_v_m, validated->worst_error_m}};
    for (const RoughPlace& p : validated->rough_places) {
      report.rough_places.push_back(
          {p.u_begin_m, p.u_end_m, p.v_min_m, p.v_max_m, p.largest_error_m, p.reason});
      known.push_back({p.worst_u_m, p.worst_v_m, p.worst_error_m});
    }
    compare_with("mesh", "mesh", reference_of(*loaded.rays, T_global_mesh), true, known);
    // The numbers of the map's cells would be others than those of the validation; one of both is
    // told.
    Comparison& told = comparisons.back().second;
    told.points = validated->points;
    told.mean_error_m = validated->mean_error_m;
    told.abs_error_m = validated->z_error_m;
  }
  if (!request.against_path.empty()) {
    loaded.against.emplace(read_surface(request.against_path));
    also("against", request.against_path);
    compare_with("against", file_name(request.against_path), reference_of(*loaded.against), false);
  }
  if (!request.cloud_path.empty()) {
    compare_with("cloud", "cloud", reference_of(request.cloud_points_m), false);
  }
  if (request.before != nullptr || !request.before_path.empty()) {
    loaded.before.emplace(request.before != nullptr ? crg::Surface(*request.before)
                                                    : read_surface(request.before_path));
    if (request.before == nullptr) also("before", request.before_path);
    compare_with("before", "road before refinement", reference_of(*loaded.before), false);
    // That smoothing moved the road is its purpose; that it took a kerb away is not.
    std::erase_if(comparisons.back().second.findings,
                  [](const Finding& f) { return f.kind != "kerb_loss"; });
  }
  if (!request.grip_path.empty()) {
    loaded.grip.emplace(read_surface(request.grip_path));
    also("grip", request.grip_path);
  }
  std::vector<std::pair<std::string, const Comparison*>> views;
  for (const auto& [key, comparison] : comparisons) {
    findings.insert(findings.end(), comparison.findings.begin(), comparison.findings.end());
    views.emplace_back(key, &comparison);
  }
  report.notes = request.remarks;
  for (const crg::Finding& c : checked.findings) {
    // That lateral cuts would meet where nobody has road is no fault of the road; where there are
    // heights it is a fold, and a finding of its own.
    if (c.severity == crg::Severity::Note || c.rule.starts_with("curvature.")) {
      report.notes.push_back(fmt::format("{}: {}", c.rule, c.message));
      continue;
    }
    Finding f;
    f.kind = "file";
    f.u_begin_m = c.row ? map.u_of(std::min(*c.row, map.rows() - 1)) : map.line.u_begin_m;
    f.u_end_m = c.row ? f.u_begin_m : map.u_end_m();
    f.v_begin_m = map.v_m.front();
    f.v_end_m = map.v_m.back();
    f.value = static_cast<double>(c.count);
    f.unit = "1";
    f.severity = c.severity == crg::Severity::Error ? Severity::error : Severity::remark;
    f.text = fmt::format("{}: {}", c.rule, c.message);
    findings.push_back(std::move(f));
  }
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  report.verdict = to_string(verdict_of(findings));
  add_looked_for(finding_options, comparisons, report);
  for (const Finding& f : findings) {
    report.findings.push_back({f.kind, to_string(f.severity), f.u_begin_m, f.u_end_m, f.v_begin_m,
                               f.v_end_m, f.value, f.unit, f.text});
  }

  const AlongU along = along_u(map, extents);
  report.closed = map.line.closed;
  add_curves(map, along, views, report);
  add_facts(map, along, file, request, shown_kerbs, validated, report);
  add_header(file, report);
  const double length_m = map.u_end_m() - map.line.u_begin_m;
  const auto stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::max(0.5, length_m / 5000.0) / map.line.u_step_m + 0.5));
  report.sheet = sheet_of(map, 0, map.rows(), stride,
                          std::max(0.3, (map.v_m.back() - map.v_m.front()) / 40.0));
  report.sheet.title = "whole road";
  add_fields(report.sheet, map, along, views, loaded.grip ? &*loaded.grip : nullptr,
             request.provenance);
  add_windows(map, findings, shown_kerbs, report);
  add_detail(map, report);
  add_kerbs(map, shown_kerbs, views, report);
  const double middle_m = middle_of_road(map, extents);
  add_roughness(map, middle_m, false, report);
  if (loaded.before) add_roughness(height_map(*loaded.before), middle_m, true, report);
  for (const auto& [key, comparison] : comparisons) {
    const std::string reference = key == "mesh"      ? file_name(request.mesh_path)
                                  : key == "against" ? file_name(request.against_path)
                                  : key == "cloud"   ? file_name(request.cloud_path)
                                                     : "before refinement";
    report.comparisons.push_back(view_of(comparison, key, reference));
  }
  for (const ReportSource& source : request.sources)
    report.inputs.push_back({source.role, source.path, source.sha256});
  report.versions.push_back({"Kerbstone", KERBSTONE_VERSION});
  report.versions.push_back({"Report schema", "1"});
  return report;
}

ReportFiles write_report(const ReportRequest& request, const std::string& output_dir) {
  const report::TrackReport made = make_report(request);
  std::error_code problem;
  std::filesystem::create_directories(output_dir, problem);
  if (problem || !std::filesystem::is_directory(output_dir)) {
    throw Error(
        fmt::format("{}: cannot make this folder: {}; give a folder that can be written with -o",
                    output_dir, problem ? problem.message() : "a file of that name is in the way"));
  }
  ReportFiles files;
  files.verdict = verdict_named(made.verdict);
  for (const auto& f : made.findings) ++(f.severity == "error" ? files.errors : files.remarks);
  const std::filesystem::path dir(output_dir);
  files.json_path = (dir / "report.json").string();
  base::write_file(files.json_path, report::report_json(made));
  if (report::page_available()) {
    files.page_path = (dir / "report.html").string();
    base::write_file(files.page_path, report::report_page(made));
  }
  return files;
}

ReportFiles read_report(const std::string& output_dir) {
  ReportFiles files;
  files.json_path = (std::filesystem::path(output_dir) / "report.json").string();
  std::ifstream file(files.json_path, std::ios::binary);
  try {
    const auto json = nlohmann::json::parse(file);
    files.verdict = verdict_named(json.at("verdict").get<std::string>());
    for (const auto& finding : json.at("findings"))
      ++(finding.at("severity") == "error" ? files.errors : files.remarks);
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: no report with a verdict; make it with 'crgbuild report'",
                            files.json_path));
  }
  const std::string page = (std::filesystem::path(output_dir) / "report.html").string();
  if (std::filesystem::exists(page)) files.page_path = page;
  return files;
}

}  // namespace road
