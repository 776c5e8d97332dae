#include "map_lead.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/statistics.h"
#include "no_value.h"

namespace cloud {
namespace {

/// Where a node's height comes from.
enum Origin : std::size_t { kMeasured, kBesideMeasured, kBaseOnly, kOrigins };

/// None for a hole.
std::size_t origin_of(float source) {
  if (!std::isfinite(source)) return kOrigins;
  if (source == static_cast<float>(NodeSource::base)) return kBaseOnly;
  return source == static_cast<float>(NodeSource::blended) ? kBesideMeasured : kMeasured;
}

/// Stretches of rows in which nothing was measured, from and to.
std::vector<std::pair<std::size_t, std::size_t>> unseen_rows(const crg::Grid& source) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  for (std::size_t i = 0; i < source.rows(); ++i) {
    bool seen = false, is_road = false;
    for (std::size_t j = 0; j < source.columns(); ++j) {
      const std::size_t origin = origin_of(source.at(i, j));
      seen |= origin == kMeasured, is_road |= origin != kOrigins;
    }
    if (seen || !is_road) continue;
    if (!out.empty() && out.back().second == i)
      ++out.back().second;
    else
      out.emplace_back(i, i + 1);
  }
  return out;
}

/// The longest three, and how much there is in all.
std::string unseen_text(const crg::Grid& source, double u_begin_m, double u_step_m) {
  std::vector<std::pair<std::size_t, std::size_t>> rows = unseen_rows(source);
  if (rows.empty()) return "nothing along the whole road";
  double all_m = 0.0;
  for (const auto& [from, to] : rows) all_m += static_cast<double>(to - from) * u_step_m;
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
    return a.second - a.first > b.second - b.first;
  });
  std::vector<std::string> longest;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, rows.size()); ++k)
    longest.push_back(fmt::format("{:.0f} to {:.0f}",
                                  u_begin_m + static_cast<double>(rows[k].first) * u_step_m,
                                  u_begin_m + static_cast<double>(rows[k].second - 1) * u_step_m));
  return fmt::format("{:.0f} m of the road, u {}{}: no point that counts lies there", all_m,
                     fmt::join(longest, ", "), rows.size() > 3 ? ", ..." : "");
}

}  // namespace

std::vector<report::Fact> lead_of(const MapResult& result, double u_begin_m, double u_step_m) {
  const MapReport& facts = result.report;
  std::array<std::vector<float>, kOrigins> stddev_m;
  std::size_t nodes = 0;
  for (std::size_t k = 0; k < result.source.z_m.size(); ++k) {
    const std::size_t origin = origin_of(result.source.z_m[k]);
    if (origin == kOrigins) continue;
    ++nodes, stddev_m[origin].push_back(result.stddev.z_m[k]);
  }
  const auto part = [&](Origin origin) {
    const std::size_t count = stddev_m[origin].size();
    if (count == 0) return std::string("none");
    return fmt::format(
        "{:.1f} % of the nodes, standard deviation {:.1f} mm in the median",
        100.0 * static_cast<double>(count) / static_cast<double>(nodes),
        1e3 * static_cast<double>(base::median_or(0.0f, std::vector<float>(stddev_m[origin]))));
  };
  std::vector<report::Fact> lead{
      {"Mended", fmt::format("heights moved by {:.1f} mm in the median, {:.1f} mm at most",
                             1e3 * facts.changed_p50_m, 1e3 * facts.changed_max_m)},
      {"Measured", part(kMeasured)},
      {"Beside measured", part(kBesideMeasured)},
      {"Base only", part(kBaseOnly)},
      {"Never seen", unseen_text(result.source, u_begin_m, u_step_m)}};
  if (facts.left_out_nodes > 0)
    lead.insert(lead.begin() + 2,
                {"90 % intervals", fmt::format("held {:.0f} % where one pass was left out",
                                               100.0 * facts.left_out_within_90)});
  return lead;
}

report::SheetField completeness_of(const report::Sheet& sheet, const crg::Grid& source,
                                   double u_begin_m) {
  report::SheetField field{"completeness",
                           "Where heights come from",
                           "",
                           {},
                           1.0,
                           false,
                           {"measured", "beside measured", "base only"}};
  field.values.reserve(sheet.z_m.size());
  for (std::size_t i = 0; i < sheet.x_m.size(); ++i) {
    const double u_m = sheet.u_begin_m + static_cast<double>(i) * sheet.u_step_m;
    const auto row = static_cast<std::size_t>(std::clamp(
        (u_m - u_begin_m) / source.u_step_m + 0.5, 0.0, static_cast<double>(source.rows() - 1)));
    for (const double v_m : sheet.v_m) {
      const auto column = static_cast<std::size_t>(
          std::lower_bound(source.v_m.begin(), source.v_m.end(), v_m - 1e-9) - source.v_m.begin());
      const std::size_t origin = origin_of(source.at(row, std::min(column, source.columns() - 1)));
      field.values.push_back(origin == kOrigins ? kNoValue : static_cast<float>(origin));
    }
  }
  return field;
}

}  // namespace cloud
