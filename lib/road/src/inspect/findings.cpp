#include "road/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "base/statistics.h"

namespace road {

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Finding finding(const HeightMap& map, const char* kind, double u_begin_m, double u_end_m,
                double value, const char* unit, Severity severity, std::string text) {
  Finding f;
  f.kind = kind;
  f.u_begin_m = u_begin_m;
  f.u_end_m = u_end_m;
  f.v_begin_m = map.v_m.front();
  f.v_end_m = map.v_m.back();
  f.value = value;
  f.unit = unit;
  f.severity = severity;
  f.text = std::move(text);
  return f;
}

/// Keeps the largest ones when there are too many, and says so.
void append(std::vector<Finding>& all, std::vector<Finding> some, const HeightMap& map,
            std::size_t limit) {
  if (some.size() > limit) {
    const std::size_t left_out = some.size() - limit;
    std::stable_sort(some.begin(), some.end(), [](const Finding& a, const Finding& b) {
      return std::abs(a.value) > std::abs(b.value);
    });
    const Finding next = some[limit];
    some.resize(limit);
    some.push_back(finding(
        map, next.kind.c_str(), map.line.u_begin_m, map.u_end_m(), next.value, next.unit.c_str(),
        next.severity,
        fmt::format(
            "{} more places of the kind {} are not listed; the largest of them has {:.3g} {}",
            left_out, next.kind, next.value, next.unit)));
  }
  std::stable_sort(some.begin(), some.end(),
                   [](const Finding& a, const Finding& b) { return a.u_begin_m < b.u_begin_m; });
  for (Finding& f : some) all.push_back(std::move(f));
}

// --- steps across the road ---------------------------------------------------------------------

std::vector<Finding> find_tile_steps(const HeightMap& map, const FindingOptions& options) {
  std::vector<Finding> found;
  const std::size_t rows = map.rows(), columns = map.columns();
  if (rows < 4) return found;
  const std::size_t stride = std::max<std::size_t>(1, columns / 96);
  std::vector<float> step(rows, 0.0f), share(rows, 0.0f);
  base::parallel_for(rows - 3, 1024, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<float> jumps;
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = k + 1;  // between rows i and i + 1
      jumps.clear();
      std::size_t present = 0;
      for (std::size_t j = 0; j < columns; j += stride) {
        // What is left of the rise over one step after the mean of the rises before and behind it.
        const float a = map.at(i - 1, j), b = map.at(i, j), c = map.at(i + 1, j),
                    d = map.at(i + 2, j);
        present += !std::isnan(b);
        const float jump = 1.5f * (c - b) - 0.5f * (d - a);
        if (!std::isnan(jump)) jumps.push_back(jump);
      }
      if (jumps.size() < 3 || 2 * jumps.size() < present) continue;
      const float median = base::quantile(jumps, 0.5);
      std::size_t alike = 0;
      for (const float jump : jumps) alike += jump * median > 0.25f * median * median;
      step[i] = median;
      share[i] = static_cast<float>(alike) / static_cast<float>(jumps.size());
    }
  });
  std::vector<float> sizes;
  for (std::size_t i = 1; i + 2 < rows; ++i) sizes.push_back(std::abs(step[i]));
  const double threshold =
      std::max(options.min_tile_step_m, 10.0 * static_cast<double>(base::quantile(sizes, 0.5)));
  for (std::size_t i = 1; i + 2 < rows; ++i) {
    const double size = std::abs(step[i]);
    if (size < threshold || static_cast<double>(share[i]) < options.min_tile_share) continue;
    // The rows beside a step show half of it with the other sign.
    bool largest = true;
    for (std::size_t k = i > 3 ? i - 2 : 1; k <= std::min(i + 2, rows - 3); ++k) {
      if (std::abs(step[k]) > std::abs(step[i]) ||
          (k < i && std::abs(step[k]) == std::abs(step[i])))
        largest = false;
    }
    if (!largest) continue;
    found.push_back(finding(
        map, "tile_step", map.u_of(i), map.u_of(i + 1), step[i], "m",
        size > options.max_tile_step_m ? Severity::error : Severity::remark,
        fmt::format("The road steps {} by {:.1f} mm at u = {:.1f} m, over {:.0f} % of its width",
                    step[i] > 0 ? "up" : "down", 1000.0 * size, map.u_of(i),
                    100.0 * static_cast<double>(share[i]))));
  }
  return found;
}

// --- missing heights ---------------------------------------------------------------------------

struct RowRun {
  std::size_t begin, end;  ///< end is one past the last
};

/// Rows that lose at least half of the road's width at once and get it back at once, or all of it.
std::vector<RowRun> find_bare_rows(const std::vector<RowExtent>& extents, double u_step_m) {
  const std::size_t rows = extents.size();
  const auto reach = std::max<std::size_t>(2, static_cast<std::size_t>(10.0 / u_step_m));
  const auto largest_between = [&](std::size_t begin, std::size_t end) {
    std::size_t largest = 0;
    for (std::size_t i = begin; i < end; ++i) largest = std::max(largest, extents[i].count);
    return largest;
  };
  std::vector<RowRun> runs;
  for (std::size_t i = 0; i < rows;) {
    const std::size_t before = i > 0 ? extents[i - 1].count : 0;
    if (extents[i].empty() || 2 * extents[i].count < before) {
      std::size_t end = i + 1;
      while (end < rows && (extents[end].empty() || 2 * extents[end].count < before) &&
             (end - i < reach || extents[end].empty()))
        ++end;
      const std::size_t behind = end < rows ? largest_between(end, std::min(rows, end + 2)) : 0;
      const std::size_t inside = largest_between(i, end);
      if (inside == 0 || (2 * inside < before && 2 * inside < behind)) {
        runs.push_back({i, end});
        i = end;
        continue;
      }
    }
    ++i;
  }
  return runs;
}

std::vector<Finding> find_missing(const HeightMap& map, const FindingOptions& options,
                                  std::vector<Finding>& stripes) {
  const std::size_t rows = map.rows(), columns = map.columns();
  const std::vector<RowExtent> extents = row_extents(map);
  std::vector<std::uint8_t> bare(rows, 0);
  for (const RowRun& run : find_bare_rows(extents, map.line.u_step_m)) {
    std::fill(bare.begin() + static_cast<std::ptrdiff_t>(run.begin),
              bare.begin() + static_cast<std::ptrdiff_t>(run.end), 1);
    const double length_m = static_cast<double>(run.end - run.begin) * map.line.u_step_m;
    stripes.push_back(finding(
        map, "nan_stripe", map.u_of(run.begin), map.u_of(run.end - 1), length_m, "m",
        Severity::error,
        fmt::format("No road over {:.2f} m from u = {:.1f} m: {} of the width is missing", length_m,
                    map.u_of(run.begin), extents[run.begin].empty() ? "all" : "more than half")));
  }

  // Nodes without height between the outermost heights of their row, joined to pieces.
  std::vector<Finding> holes;
  std::vector<std::uint8_t> seen;
  const auto is_hole = [&](std::size_t i, std::size_t j) {
    return !bare[i] && j > extents[i].first && j < extents[i].last && std::isnan(map.at(i, j));
  };
  std::vector<std::pair<std::size_t, std::size_t>> stack;
  for (std::size_t i = 0; i < rows; ++i) {
    const RowExtent& extent = extents[i];
    if (bare[i] || extent.empty() || extent.count == extent.last - extent.first + 1) continue;
    for (std::size_t j = extent.first; j <= extent.last; ++j) {
      if (!is_hole(i, j)) continue;
      if (seen.empty()) seen.resize(rows * columns, 0);
      if (seen[i * columns + j]) continue;
      std::size_t nodes = 0, i_low = i, i_high = i, j_low = j, j_high = j;
      stack.assign(1, {i, j});
      seen[i * columns + j] = 1;
      while (!stack.empty()) {
        const auto [a, b] = stack.back();
        stack.pop_back();
        ++nodes;
        i_low = std::min(i_low, a), i_high = std::max(i_high, a);
        j_low = std::min(j_low, b), j_high = std::max(j_high, b);
        for (std::size_t p = a > 0 ? a - 1 : 0; p <= std::min(rows - 1, a + 1); ++p) {
          for (std::size_t q = b > 0 ? b - 1 : 0; q <= std::min(columns - 1, b + 1); ++q) {
            if (seen[p * columns + q] || !is_hole(p, q)) continue;
            seen[p * columns + q] = 1;
            stack.emplace_back(p, q);
          }
        }
      }
      // The hole reaches halfway to the nodes around it.
      const double length_m = static_cast<double>(i_high - i_low + 1) * map.line.u_step_m;
      const double width_m =
          0.5 * (map.v_m[j_high + 1] - map.v_m[j_low - 1] + map.v_m[j_high] - map.v_m[j_low]);
      const double size_m = std::max(length_m, width_m);
      const bool stripe = size_m >= 5.0 && size_m > 5.0 * std::min(length_m, width_m);
      Finding f = finding(
          map, stripe ? "nan_stripe" : "hole", map.u_of(i_low), map.u_of(i_high), size_m, "m",
          size_m > options.max_hole_m ? Severity::error : Severity::remark,
          fmt::format(
              "{} of {:.2f} m x {:.2f} m ({} nodes without height) at u = {:.1f} m, v = {:.1f} m",
              stripe ? "Stripe" : "Hole", length_m, width_m, nodes, map.u_of(i_low),
              0.5 * (map.v_m[j_low] + map.v_m[j_high])));
      f.v_begin_m = map.v_m[j_low];
      f.v_end_m = map.v_m[j_high];
      (stripe ? stripes : holes).push_back(std::move(f));
    }
  }
  return holes;
}

// --- folds -------------------------------------------------------------------------------------

std::vector<Finding> find_folds(const HeightMap& map) {
  const std::vector<RowExtent> extents = row_extents(map);
  const double step_m = map.line.u_step_m;
  std::vector<double> depth_m(map.rows(), 0.0);
  for (std::size_t i = 0; i + 1 < map.rows(); ++i) {
    if (extents[i].empty() || extents[i + 1].empty()) continue;
    const double heading = map.line.heading_rad[i + 1];
    const double c = std::cos(heading), s = std::sin(heading);
    for (const std::size_t j : {std::max(extents[i].first, extents[i + 1].first),
                                std::min(extents[i].last, extents[i + 1].last)}) {
      const double v_m = map.v_m[j];
      const crg::Point2 a = crg::node_position(map.line, i, v_m),
                        b = crg::node_position(map.line, i + 1, v_m);
      const double advance_m = (b.x_m - a.x_m) * c + (b.y_m - a.y_m) * s;
      // The advance shrinks linearly with v: it is the step at v = 0 and nothing at the fold.
      if (advance_m < 0.0)
        depth_m[i] = std::max(depth_m[i], std::abs(v_m) * -advance_m / (step_m - advance_m));
    }
  }
  std::vector<Finding> found;
  const auto gap = static_cast<std::size_t>(std::ceil(1.0 / step_m));
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    if (!(depth_m[i] > 0.0)) continue;
    std::size_t last = i;
    double deepest = depth_m[i];
    for (std::size_t k = i; k < depth_m.size() && k <= last + gap; ++k) {
      if (!(depth_m[k] > 0.0)) continue;
      last = k;
      deepest = std::max(deepest, depth_m[k]);
    }
    found.push_back(finding(
        map, "fold", map.u_of(i), map.u_of(last + 1), deepest, "m", Severity::error,
        fmt::format(
            "The grid folds over itself from u = {:.1f} m to {:.1f} m: the bend is tighter than "
            "the road is wide by up to {:.2f} m; trim v there or move the reference line outwards",
            map.u_of(i), map.u_of(last + 1), deepest)));
    i = last;
  }
  return found;
}

// --- the seam ----------------------------------------------------------------------------------

std::vector<Finding> find_seam_faults(const HeightMap& map, const FindingOptions& options) {
  std::vector<Finding> found;
  const crg::ReferenceLine& line = map.line;
  const std::size_t n = line.size(), last = n - 1;
  if (n < 8) return found;
  const double u_begin_m = map.u_of(last - 1), u_end_m = map.u_of(last);
  const double dx = line.x_m[0] - line.x_m[last], dy = line.y_m[0] - line.y_m[last];
  const double c = std::cos(line.heading_rad[last]), s = std::sin(line.heading_rad[last]);
  const double along_m = dx * c + dy * s, across_m = -dx * s + dy * c;
  const double distance_m = std::hypot(dx, dy);
  const double turn = std::abs(
      std::remainder(line.heading_rad[1] - line.heading_rad[last], 2.0 * std::numbers::pi));
  if (!options.closed) {
    if (distance_m < std::max(1.0, 2.0 * line.u_step_m) && turn < std::numbers::pi / 3.0 &&
        u_end_m - line.u_begin_m > 100.0) {
      found.push_back(finding(
          map, "wrong_seam", u_begin_m, u_end_m, distance_m, "m", Severity::remark,
          fmt::format(
              "The road ends {:.2f} m from its start and in the same direction, but the file does "
              "not say that it is closed: a vehicle runs off its end",
              distance_m)));
    }
    return found;
  }
  if (std::abs(across_m) > options.max_seam_gap_m ||
      along_m > line.u_step_m + options.max_seam_gap_m || along_m < -options.max_seam_gap_m) {
    found.push_back(finding(map, "wrong_seam", u_begin_m, u_end_m, distance_m, "m", Severity::error,
                            fmt::format("The closed road does not close: its end lies {:.2f} m "
                                        "before and {:.2f} m beside its start",
                                        along_m, across_m)));
    return found;
  }
  double worst = 0.0;
  std::size_t one_sided = 0;
  for (std::size_t j = 0; j < map.columns(); ++j) {
    const double first = map.at(0, j), end = map.at(last, j);
    one_sided += std::isnan(first) != std::isnan(end);
    // Over a gap of up to a step the road goes on as steep as it was.
    const double slope = (end - static_cast<double>(map.at(last - 1, j))) / line.u_step_m;
    const double step = first - end - (along_m > 0.01 ? slope * along_m : 0.0);
    if (std::abs(step) > std::abs(worst)) worst = step;
  }
  if (std::abs(worst) > options.min_seam_step_m) {
    found.push_back(
        finding(map, "wrong_seam", u_begin_m, u_end_m, worst, "m",
                std::abs(worst) > options.max_seam_step_m ? Severity::error : Severity::remark,
                fmt::format("The height steps by up to {:.1f} mm where the road closes (u = {:.1f} "
                            "m back to {:.1f} m)",
                            1000.0 * std::abs(worst), u_end_m, line.u_begin_m)));
  }
  if (one_sided > 2 + map.columns() / 50) {
    found.push_back(finding(
        map, "wrong_seam", u_begin_m, u_end_m, static_cast<double>(one_sided), "1",
        Severity::remark,
        fmt::format("{} columns have a height only on one side of the place where the road closes",
                    one_sided)));
  }
  // What the line turns at the seam beyond half of what it turns at the corners before and behind.
  const auto corner = [&](double a, double b) {
    return std::remainder(b - a, 2.0 * std::numbers::pi);
  };
  const double kink = corner(line.heading_rad[last], line.heading_rad[1]) -
                      0.5 * (corner(line.heading_rad[last - 1], line.heading_rad[last]) +
                             corner(line.heading_rad[1], line.heading_rad[2]));
  if (std::abs(kink) > options.min_seam_heading_rad) {
    found.push_back(
        finding(map, "wrong_seam", u_begin_m, u_end_m, kink, "rad",
                std::abs(kink) > options.max_seam_heading_rad ? Severity::error : Severity::remark,
                fmt::format("The reference line has a kink of {:.1f} mrad where the road closes",
                            1000.0 * std::abs(kink))));
  }
  return found;
}

// --- bumps and potholes ------------------------------------------------------------------------

/// Heights over the road before and behind them, on every few rows and columns.
struct Residuals {
  std::vector<std::size_t> row, column;  ///< of the map
  std::vector<float> z_m;                ///< row.size() * column.size(); NaN where not known
};

constexpr double kShoulderNear_m = 3.0, kShoulderFar_m = 9.0;

Residuals residuals(const HeightMap& map, const FindingOptions& options) {
  Residuals r;
  const double step_m = map.line.u_step_m;
  if (step_m > 1.0 || map.rows() < 8) return r;
  const auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(0.2 / step_m + 0.5));
  for (std::size_t i = 0; i < map.rows(); i += stride) r.row.push_back(i);
  for (std::size_t j = 0; j < map.columns(); ++j) {
    if (r.column.empty() || map.v_m[j] - map.v_m[r.column.back()] > 0.19) r.column.push_back(j);
  }
  const auto period = static_cast<std::ptrdiff_t>(map.rows() - 1);
  std::vector<std::ptrdiff_t> offsets;
  std::vector<double> weights, distance_m;
  const auto near = static_cast<std::ptrdiff_t>(kShoulderNear_m / step_m),
             far = static_cast<std::ptrdiff_t>(kShoulderFar_m / step_m);
  double count = 0.0, s2 = 0.0, s4 = 0.0;
  for (std::ptrdiff_t k = -far; k <= far; k += static_cast<std::ptrdiff_t>(stride)) {
    if (std::abs(k) < near) continue;
    const double s = static_cast<double>(k) * step_m;
    offsets.push_back(k);
    distance_m.push_back(s);
    count += 1.0, s2 += s * s, s4 += s * s * s * s;
  }
  // Value at 0 of the least-squares quadratic; its linear part drops out by symmetry (the offsets
  // are symmetric to within one stride).
  for (const double s : distance_m) weights.push_back((s4 - s2 * s * s) / (count * s4 - s2 * s2));
  const double fit_sum = [&] {
    double sum = 0;
    for (const double w : weights) sum += w;
    return sum;
  }();
  for (double& w : weights) w /= fit_sum;

  r.z_m.assign(r.row.size() * r.column.size(), kNan);
  base::parallel_for(r.row.size(), 256, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> base(map.columns());
    for (std::size_t a = begin; a < end; ++a) {
      const auto i = static_cast<std::ptrdiff_t>(r.row[a]);
      std::fill(base.begin(), base.end(), 0.0);
      bool inside = true;
      for (std::size_t k = 0; k < offsets.size() && inside; ++k) {
        std::ptrdiff_t at = i + offsets[k];
        if (options.closed) at = (at % period + period) % period;
        if (at < 0 || at >= static_cast<std::ptrdiff_t>(map.rows())) {
          inside = false;
          break;
        }
        const float* z = map.z_m.data() + static_cast<std::size_t>(at) * map.columns();
        const double w = weights[k];
        for (std::size_t j = 0; j < base.size(); ++j) base[j] += w * static_cast<double>(z[j]);
      }
      for (std::size_t b = 0; b < r.column.size(); ++b) {
        const std::size_t j = r.column[b];
        const double z = map.at(r.row[a], j);
        if (std::isnan(z)) continue;
        double fitted = inside ? base[j] : std::numeric_limits<double>::quiet_NaN();
        if (std::isnan(fitted)) {
          // Heights missing before or behind: the same quadratic through those that are there.
          double m[5] = {}, t[3] = {};
          std::size_t before = 0, behind = 0;
          for (std::size_t k = 0; k < offsets.size(); ++k) {
            std::ptrdiff_t at = i + offsets[k];
            if (options.closed) at = (at % period + period) % period;
            if (at < 0 || at >= static_cast<std::ptrdiff_t>(map.rows())) continue;
            const double height = map.at(static_cast<std::size_t>(at), j), s = distance_m[k];
            if (std::isnan(height)) continue;
            (s < 0 ? before : behind) += 1;
            double power = 1.0;
            for (int p = 0; p < 5; ++p, power *= s) m[p] += power;
            t[0] += height, t[1] += s * height, t[2] += s * s * height;
          }
          const std::size_t enough = offsets.size() * 3 / 10;
          if (before < enough || behind < enough) continue;
          const double det = m[0] * (m[2] * m[4] - m[3] * m[3]) -
                             m[1] * (m[1] * m[4] - m[3] * m[2]) +
                             m[2] * (m[1] * m[3] - m[2] * m[2]);
          fitted = (t[0] * (m[2] * m[4] - m[3] * m[3]) - m[1] * (t[1] * m[4] - m[3] * t[2]) +
                    m[2] * (t[1] * m[3] - m[2] * t[2])) /
                   det;
        }
        r.z_m[a * r.column.size() + b] = static_cast<float>(z - fitted);
      }
    }
  });
  return r;
}

/// Takes out what belongs to kerbs: their edges and the ends over which they rise.
void leave_out_kerbs(const HeightMap& map, const KerbStrips& kerbs, Residuals& r) {
  const double margin_u_m = kShoulderFar_m + 1.0, margin_v_m = 0.4;
  const double step_m = map.u_of(r.row.size() > 1 ? r.row[1] : 1) - map.u_of(r.row[0]);
  for (const std::vector<KerbRow>& rows : kerbs.rows) {
    const double begin_m = map.u_of(rows.front().row) - margin_u_m,
                 end_m = map.u_of(rows.back().row) + margin_u_m;
    std::size_t k = 0;
    const auto first = static_cast<std::size_t>(
        std::max(0.0, std::floor((begin_m - map.line.u_begin_m) / step_m)));
    for (std::size_t a = first; a < r.row.size() && map.u_of(r.row[a]) <= end_m; ++a) {
      // The kerb as it lies between 10 m before and 10 m behind this row.
      double low = std::numeric_limits<double>::infinity(), high = -low;
      while (k < rows.size() && map.u_of(rows[k].row) < map.u_of(r.row[a]) - margin_u_m) ++k;
      for (std::size_t q = std::min(k, rows.size() - 1); q < rows.size(); ++q) {
        if (q > k && map.u_of(rows[q].row) > map.u_of(r.row[a]) + margin_u_m) break;
        low = std::min({low, rows[q].v_begin_m, rows[q].v_end_m});
        high = std::max({high, rows[q].v_begin_m, rows[q].v_end_m});
      }
      for (std::size_t b = 0; b < r.column.size(); ++b) {
        const double v_m = map.v_m[r.column[b]];
        if (v_m > low - margin_v_m && v_m < high + margin_v_m)
          r.z_m[a * r.column.size() + b] = kNan;
      }
    }
  }
}

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
  for (const bool is_bump : {true, false}) {
    for (const Swelling& s : is_bump ? up : down) {
      if (is_echo(s, is_bump ? down : up)) continue;
      Finding f = finding(map, is_bump ? "bump" : "pothole", s.u_begin_m, s.u_end_m, s.value_m, "m",
                          s.value_m > options.max_bump_m ? Severity::error : Severity::remark,
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

}  // namespace

std::vector<Finding> find_defects(const HeightMap& map, const KerbStrips& kerbs,
                                  const FindingOptions& options) {
  std::vector<Finding> all;
  std::vector<Finding> stripes;
  std::vector<Finding> holes = find_missing(map, options, stripes);
  std::vector<Finding> steps = find_tile_steps(map, options);
  std::vector<Finding> seam = find_seam_faults(map, options);
  std::vector<Finding> jumps = steps;
  for (const Finding& f : seam) {
    if (f.unit != "m") continue;
    // The step at the seam stands at both ends of u.
    jumps.push_back(f);
    jumps.push_back(f);
    jumps.back().u_begin_m = jumps.back().u_end_m = map.line.u_begin_m;
  }
  std::vector<Finding> bumps = find_bumps(map, kerbs, options, jumps);
  append(all, find_folds(map), map, options.max_per_kind);
  append(all, std::move(stripes), map, options.max_per_kind);
  append(all, std::move(seam), map, options.max_per_kind);
  append(all, std::move(holes), map, options.max_per_kind);
  // The flanks of a short bump step too; a step proper leaves no bump above itself.
  std::erase_if(steps, [&](const Finding& step) {
    return std::any_of(bumps.begin(), bumps.end(), [&](const Finding& bump) {
      return std::abs(step.value) < bump.value && step.u_begin_m > bump.u_begin_m - 1.0 &&
             step.u_end_m < bump.u_end_m + 1.0;
    });
  });
  append(all, std::move(steps), map, options.max_per_kind);
  append(all, std::move(bumps), map, options.max_per_kind);
  return all;
}

Verdict verdict_of(const std::vector<Finding>& findings) {
  Verdict verdict = Verdict::usable;
  for (const Finding& f : findings) {
    if (f.severity == Severity::error) return Verdict::not_usable;
    verdict = Verdict::usable_with_remarks;
  }
  return verdict;
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::usable:
      return "usable";
    case Verdict::usable_with_remarks:
      return "usable_with_remarks";
    case Verdict::not_usable:
      return "not_usable";
  }
  return "";
}

const char* to_string(Severity severity) {
  return severity == Severity::error ? "error" : "remark";
}

}  // namespace road
