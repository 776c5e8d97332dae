#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "base/statistics.h"
#include "defects.h"
#include "residuals.h"

namespace road {
namespace {

struct Swelling {
  double u_begin_m, u_end_m, v_begin_m, v_end_m, u_m, v_m, value_m;
};

std::vector<Swelling> find_swellings(const HeightMap& map, const Residuals& r,
                                     const FindingOptions& options, double sign) {
  const std::size_t rows = r.row.size(), columns = r.column.size();
  // Threshold per column: run-off may be rougher than the road.
  std::vector<double> threshold(columns, options.min_bump_m);
  std::vector<float> sizes;
  for (std::size_t b = 0; b < columns; ++b) {
    sizes.clear();
    for (std::size_t a = 0; a < rows; a += 3) {
      const float z = r.z_m[a * columns + b];
      if (!std::isnan(z)) sizes.push_back(std::abs(z));
    }
    if (!sizes.empty())
      threshold[b] =
          std::max(threshold[b], 5.5 * 1.4826 * static_cast<double>(base::quantile(sizes, 0.5)));
  }
  std::vector<Swelling> found;
  std::vector<std::uint8_t> seen(rows * columns, 0);
  const auto over = [&](std::size_t a, std::size_t b) {
    return sign * static_cast<double>(r.z_m[a * columns + b]) > threshold[b];  // false for NaN
  };
  std::vector<std::pair<std::size_t, std::size_t>> stack;
  for (std::size_t a = 0; a < rows; ++a) {
    for (std::size_t b = 0; b < columns; ++b) {
      if (!over(a, b) || seen[a * columns + b]) continue;
      Swelling s{};
      s.u_begin_m = s.u_end_m = map.u_of(r.row[a]);
      s.v_begin_m = s.v_end_m = map.v_m[r.column[b]];
      stack.assign(1, {a, b});
      seen[a * columns + b] = 1;
      while (!stack.empty()) {
        const auto [i, j] = stack.back();
        stack.pop_back();
        const double u = map.u_of(r.row[i]), v = map.v_m[r.column[j]];
        const double value = sign * static_cast<double>(r.z_m[i * columns + j]);
        s.u_begin_m = std::min(s.u_begin_m, u), s.u_end_m = std::max(s.u_end_m, u);
        s.v_begin_m = std::min(s.v_begin_m, v), s.v_end_m = std::max(s.v_end_m, v);
        if (value > s.value_m) s.value_m = value, s.u_m = u, s.v_m = v;
        for (std::size_t p = i > 2 ? i - 2 : 0; p <= std::min(rows - 1, i + 2); ++p) {
          for (std::size_t q = j > 2 ? j - 2 : 0; q <= std::min(columns - 1, j + 2); ++q) {
            if (seen[p * columns + q] || !over(p, q)) continue;
            seen[p * columns + q] = 1;
            stack.emplace_back(p, q);
          }
        }
      }
      // Pieces of one swelling that the scatter of a rough road cuts apart.
      const auto part = std::find_if(found.begin(), found.end(), [&](const Swelling& other) {
        return s.u_begin_m < other.u_end_m + 2.0 && s.u_end_m > other.u_begin_m - 2.0 &&
               s.v_begin_m < other.v_end_m + 3.0 && s.v_end_m > other.v_begin_m - 3.0;
      });
      if (part == found.end()) {
        found.push_back(s);
        continue;
      }
      part->u_begin_m = std::min(part->u_begin_m, s.u_begin_m),
      part->u_end_m = std::max(part->u_end_m, s.u_end_m);
      part->v_begin_m = std::min(part->v_begin_m, s.v_begin_m),
      part->v_end_m = std::max(part->v_end_m, s.v_end_m);
      if (s.value_m > part->value_m)
        part->value_m = s.value_m, part->u_m = s.u_m, part->v_m = s.v_m;
    }
  }
  return found;
}

/// Whether all of the road rises or falls here, and nowhere as steeply as where a layer changes.
bool is_crest(const HeightMap& map, const Swelling& s, double max_slope) {
  const auto row = [&](double u_m) {
    return static_cast<std::size_t>(std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m + 0.5,
                                               0.0, static_cast<double>(map.rows() - 1)));
  };
  constexpr double kAllOfTheWidth = 0.9;
  double low_m = 0.0, high_m = 0.0;
  for (std::size_t j = 0; j < map.columns(); ++j) {
    if (std::isnan(map.at(row(s.u_m), j))) continue;
    low_m = std::min(low_m, map.v_m[j]), high_m = std::max(high_m, map.v_m[j]);
  }
  if (s.v_end_m - s.v_begin_m < kAllOfTheWidth * (high_m - low_m)) return false;
  for (std::size_t i = row(s.u_begin_m - 1.0); i < row(s.u_end_m + 1.0); ++i)
    for (std::size_t j = 0; j < map.columns(); ++j) {
      const float rise_m = map.at(i + 1, j) - map.at(i, j);
      if (std::abs(rise_m) > static_cast<float>(max_slope * map.line.u_step_m)) return false;
    }
  return true;
}

/// Crests and troughs that follow each other at one distance become one finding: four lines say no
/// more than one.
std::vector<Finding> join_waves(std::vector<Finding> found) {
  constexpr double kLongestWave_m = 24.0;
  constexpr std::size_t kFewestSwellings = 4;
  std::stable_sort(found.begin(), found.end(),
                   [](const Finding& a, const Finding& b) { return a.u_begin_m < b.u_begin_m; });
  const auto middle_m = [](const Finding& f) { return 0.5 * (f.u_begin_m + f.u_end_m); };
  std::vector<Finding> joined;
  std::vector<std::uint8_t> taken(found.size(), 0);
  for (std::size_t first = 0; first < found.size(); ++first) {
    if (taken[first]) continue;
    std::vector<std::size_t> run = {first};
    for (std::size_t k = first + 1; k < found.size(); ++k) {
      const Finding &last = found[run.back()], &next = found[k];
      const double distance_m = middle_m(next) - middle_m(last);
      if (distance_m > 0.5 * kLongestWave_m) break;
      if (taken[k] || next.kind == last.kind || next.v_begin_m > last.v_end_m + 1.0 ||
          next.v_end_m < last.v_begin_m - 1.0)
        continue;
      if (run.size() > 1) {
        const double before_m = middle_m(last) - middle_m(found[run[run.size() - 2]]);
        if (distance_m < 0.6 * before_m || distance_m > 1.6 * before_m) continue;
      }
      run.push_back(k);
    }
    if (run.size() < kFewestSwellings) {
      joined.push_back(found[first]);
      continue;
    }
    Finding f = found[first];
    for (const std::size_t k : run) {
      taken[k] = 1;
      if (found[k].value > f.value) f.value = found[k].value, f.kind = found[k].kind;
      if (found[k].severity == Severity::error) f.severity = Severity::error;
      f.u_end_m = std::max(f.u_end_m, found[k].u_end_m);
      f.v_begin_m = std::min(f.v_begin_m, found[k].v_begin_m),
      f.v_end_m = std::max(f.v_end_m, found[k].v_end_m);
    }
    const double wave_m = 2.0 * (middle_m(found[run.back()]) - middle_m(found[first])) /
                          static_cast<double>(run.size() - 1);
    f.text = fmt::format(
        "Waves of up to {:.0f} mm, {:.1f} m from crest to crest, {} crests and troughs from u = "
        "{:.1f} m to {:.1f} m",
        1000.0 * f.value, wave_m, run.size(), f.u_begin_m, f.u_end_m);
    joined.push_back(std::move(f));
  }
  return joined;
}

}  // namespace

std::vector<Finding> find_bumps(const HeightMap& map, const KerbStrips& kerbs,
                                const FindingOptions& options, const std::vector<Finding>& steps) {
  std::vector<Finding> found;
  Residuals r = residuals(map, options);
  if (r.row.empty()) return found;
  leave_out_kerbs(map, kerbs, r);
  const std::vector<Swelling> up = find_swellings(map, r, options, 1.0),
                              down = find_swellings(map, r, options, -1.0);
  const auto is_echo = [&](const Swelling& s, const std::vector<Swelling>& others) {
    // A swelling of one sign pulls the quadratic beside it: what is left there is its echo.
    for (const Swelling& other : others) {
      if (other.value_m > 2.0 * s.value_m && s.u_begin_m < other.u_end_m + kShoulderFar_m + 1.0 &&
          s.u_end_m > other.u_begin_m - kShoulderFar_m - 1.0 && s.v_begin_m < other.v_end_m + 1.0 &&
          s.v_end_m > other.v_begin_m - 1.0) {
        return true;
      }
    }
    // A step of the whole road shows as half of itself on both of its sides.
    for (const Finding& step : steps) {
      if (s.value_m < 0.75 * std::abs(step.value) && s.u_begin_m < step.u_end_m + kShoulderFar_m &&
          s.u_end_m > step.u_begin_m - kShoulderFar_m) {
        return true;
      }
    }
    return false;
  };
  const auto is_high_crest = [&](const Swelling& s) {
    return s.value_m > options.max_bump_m && is_crest(map, s, options.max_crest_slope);
  };
  // Jumps and waves that a track was built with come in numbers; one alone is a fault of the mesh.
  // One with a flat top is two crests between two troughs: a few near each other count half.
  constexpr std::size_t kFewestHumps = 4;
  const auto humps = [&](const std::vector<Swelling>& of) {
    std::size_t count = 0, run = 0;
    double before_m = -std::numeric_limits<double>::infinity();
    const auto end_run = [&] { count += run <= kFewestHumps ? (run + 1) / 2 : run; };
    for (const Swelling& s : of) {
      if (!is_high_crest(s)) continue;
      if (s.u_m - before_m >= 2.0 * kShoulderFar_m) end_run(), run = 0;
      ++run;
      before_m = s.u_m;
    }
    end_run();
    return count;
  };
  const bool has_crests = std::max(humps(up), humps(down)) >= kFewestHumps;
  for (const bool is_bump : {true, false}) {
    for (const Swelling& s : is_bump ? up : down) {
      if (is_echo(s, is_bump ? down : up)) continue;
      Finding f = finding(map, is_bump ? "bump" : "pothole", s.u_begin_m, s.u_end_m, s.value_m, "m",
                          s.value_m > options.max_bump_m && !(has_crests && is_high_crest(s))
                              ? Severity::error
                              : Severity::remark,
                          fmt::format("{} of {:.0f} mm at u = {:.1f} m, v = {:.1f} m ({:.1f} m "
                                      "long, {:.1f} m wide where it exceeds the limit)",
                                      is_bump ? "Bump" : "Pothole", 1000.0 * s.value_m, s.u_m,
                                      s.v_m, s.u_end_m - s.u_begin_m, s.v_end_m - s.v_begin_m));
      f.v_begin_m = s.v_begin_m;
      f.v_end_m = s.v_end_m;
      found.push_back(std::move(f));
    }
  }
  return join_waves(std::move(found));
}

}  // namespace road
