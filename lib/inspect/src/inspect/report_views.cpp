#include "report_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/statistics.h"
#include "nan.h"
#include "road/roughness.h"

namespace road {
namespace {

/// Half of a car's track width; the wheel paths lie this far beside the middle of the road.
constexpr double kHalfTrack_m = 0.8;

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

/// Whether a wheel path rides the same before and after: IRI to its last digit in the report.
bool rides_the_same(const report::RoughnessTrack& a, const report::RoughnessTrack& b) {
  return std::ranges::equal(a.iri, b.iri, [](const auto& s, const auto& t) {
    return (std::isnan(s.iri_m_per_km) && std::isnan(t.iri_m_per_km)) ||
           std::abs(s.iri_m_per_km - t.iri_m_per_km) < 0.005;
  });
}

}  // namespace

report::ComparisonView view_of(const Comparison& c, std::string key, std::string reference) {
  report::ComparisonView view;
  // The largest error of some rows in place of each: what a picture shows of them.
  constexpr std::size_t kMostCells = 150'000;
  const std::size_t columns = c.v_m.size(),
                    some =
                        std::max<std::size_t>(1, (c.error_m.size() + kMostCells - 1) / kMostCells);
  view.u_begin_m = c.u_begin_m;
  view.u_cell_m = c.u_cell_m * static_cast<double>(some);
  view.v_m = c.v_m;
  view.rows = (c.rows + some - 1) / some;
  view.error_m.assign(view.rows * columns, kNanF);
  view.without_reference.assign(view.error_m.size(), 0);
  for (std::size_t k = 0; k < c.error_m.size(); ++k) {
    const std::size_t at = k / columns / some * columns + k % columns;
    if (float& worst = view.error_m[at];
        std::isnan(worst) || std::abs(c.error_m[k]) > std::abs(worst))
      worst = c.error_m[k];
    if (!c.without_reference.empty()) view.without_reference[at] |= c.without_reference[k];
  }
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

void add_kerbs(const HeightMap& map, const KerbStrips& kerbs, const Comparisons& comparisons,
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
      view.profile.at_v_m = comparisons.front().second.kerb_cuts[k].at_v_m;
    } else {
      for (double v = std::max(low - 1.5, map.v_m.front());
           v <= std::min(high + 1.5, map.v_m.back()); v += 0.05)
        view.profile.at_v_m.push_back(v);
    }
    view.profile.lines.emplace_back("file",
                                    heights_at(map, strip.u_of_profile_m, view.profile.at_v_m));
    for (const auto& [key, c] : comparisons)
      view.profile.lines.emplace_back(key, c.kerb_cuts[k].reference_z_m);
    report.kerbs.push_back(std::move(view));
  }
}

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
    const auto facets = facet_spacing(sections[0], step_m);
    // Through its own facets a mesh has any class, and through the rounding of flat heights.
    constexpr double kSmoothest_m3 = 1e-9;  // a hundredth of what is polished
    if (const auto fit = fit_iso8608(psd); fit && !facets && fit->psd_at_n0_m3 > kSmoothest_m3) {
      track.iso_class = std::string(1, fit->iso_class);
      track.psd_at_n0_m3 = fit->psd_at_n0_m3;
      track.exponent = fit->exponent;
      track.fit_n_min_cpm = fit->n_min_cpm;
      track.fit_n_max_cpm = fit->n_max_cpm;
      track.band_cut = fit->band_cut;
    }
    if (facets) {
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

}  // namespace road
