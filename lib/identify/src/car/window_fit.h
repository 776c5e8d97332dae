// What fits to the windows of a drive share.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/interval90.h"
#include "identify/clustered_fit.h"
#include "identify/drive_fits.h"

namespace identify {

using Windows = std::vector<const DriveWindow*>;

inline std::size_t blocks_of(const Windows& windows) {
  std::set<std::size_t> out;
  for (const DriveWindow* w : windows) out.insert(w->block);
  return out.size();
}

/// Lateral acceleration of a window: recorded, else by turning; 0 where neither was.
inline double left_mps2(const DriveWindow& w) {
  if (std::isfinite(w.left_mps2)) return w.left_mps2;
  return std::isfinite(w.yaw_rate_radps) ? w.yaw_rate_radps * w.vx_mps : 0.0;
}

inline constexpr double kUnbraked_pa = 5e4;
/// Whether any brake was pressed harder; not where none was recorded.
inline bool braked(const DriveWindow& w, double most_pa) {
  return std::any_of(w.brake_pa.begin(), w.brake_pa.end(), [&](double pa) { return pa > most_pa; });
}

/// One standard deviation of a number of the vehicle file, a share.
inline double share_sd(const Prior& prior, vehicle::Parameter parameter) {
  return 0.5 * prior[static_cast<std::size_t>(parameter)];
}

// Standard deviations of what no file states: rolling resistance as a share, an accelerometer's
// offset (5 thousandths of gravity).
inline constexpr double kRollingShare = 0.15, kOffset_mps2 = 0.05;

/// Standard deviation of what is one of two things, or between, over half their distance: both lie
/// within the 90 % interval.
inline constexpr double kBetween = 0.8;

/// Sums of pairs, for what one is over the other. A pair with a NaN does not count.
struct Pairs {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  void add(double a, double b) {
    if (!std::isfinite(a + b)) return;
    n += 1.0, x += a, y += b, xx += a * a, xy += a * b, yy += b * b;
  }
  double variance() const { return (xx - x * x / n) / n; }
  /// NaN where all x are the same.
  double slope() const {
    const double spread = n * xx - x * x;
    return spread > 0.0 ? (n * xy - x * y) / spread : std::numeric_limits<double>::quiet_NaN();
  }
  /// Of the other regression: noise in x lowers the one, noise in y raises this.
  double steepest() const { return (yy - y * y / n) / (xy - x * y / n); }
  double correlation() const {
    return (xy - x * y / n) / std::sqrt((xx - x * x / n) * (yy - y * y / n));
  }
};

inline Found found_of(std::string name, std::string unit, double stated, std::string unseen = {}) {
  return {std::move(name), std::move(unit), 0.0, 0.0, 0.0, 0.0, stated, std::move(unseen)};
}

/// A value with its interval: what the drive leaves open with `freedom` degrees, and the file.
inline void set_found(Found& f, double value, double freedom, double sd_drive, double sd_file) {
  f.value = value;
  f.sd_drive = sd_drive;
  f.sd = std::hypot(sd_drive, sd_file);
  f.within = base::half_width_90(freedom, sd_drive, sd_file);
}

/// A number whose 90 % interval is wider either way, as a share of it, is unseen.
inline constexpr double kMostShare = 0.25;
inline std::string too_wide(double within) {
  return fmt::format("its 90 % interval would be {:.3g} either way", within);
}
inline void hide_wide(Found& f, const std::string& more = {}) {
  if (!(f.within <= kMostShare * std::abs(f.value))) f.unseen = too_wide(f.within) + more;
}

/// `key = value prior p` with the prior that the found deviation makes (two of them, as a share of
/// the value), or a remark why there is no number. `value`: f.value in the key's own terms.
inline std::string sheet_line(const Found& f, const std::string& key, double value) {
  if (!f.unseen.empty()) return fmt::format("# {} not observable: {}\n", key, f.unseen);
  const double prior = 2.0 * f.sd / std::abs(f.value);
  if (!(prior > 0.0) || !std::isfinite(prior) || value == 0.0)
    return fmt::format("{} = {:.6g}\n", key, value);
  return fmt::format("{} = {:.6g} prior {:.3g}\n", key, value, prior);
}

/// Lines without priors, the names' first _ as the key's point; factors on a map are remarks.
inline std::string plain_sheet(const std::vector<Found>& found) {
  std::string out;
  for (const Found& f : found) {
    std::string key = f.name;
    key[key.find('_')] = '.';
    out += !f.unseen.empty() ? fmt::format("# {} not observable: {}\n", key, f.unseen)
           : f.unit == "1"
               ? fmt::format("# {}: {:.4g} times the vehicle file's map\n", key, f.value)
               : fmt::format("{} = {:.6g}\n", key, f.value);
  }
  return out;
}

}  // namespace identify
