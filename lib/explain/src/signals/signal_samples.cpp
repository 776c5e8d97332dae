#include "signal_samples.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"
#include "explain/signals.h"
#include "not_known.h"

namespace explain {
namespace {

/// Median distance of the samples from the smooth signal.
double beside(const Samples& s, const std::vector<double>& x) {
  std::vector<double> off;
  for (std::size_t k = 0; k < s.t.size(); ++k) {
    const double place = s.t[k] / Signals::kStep_s;
    if (!(place >= 0) || place >= static_cast<double>(x.size() - 1)) continue;
    const auto i = static_cast<std::size_t>(place);
    const double smooth = x[i] + (place - static_cast<double>(i)) * (x[i + 1] - x[i]);
    if (std::isfinite(smooth)) off.push_back(std::abs(s.x[k] - smooth));
  }
  if (off.empty()) return 0.0;
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle;
}

/// Of the polynomial that fits best, its value in the middle: of a cubic, which is that of a
/// parabola where the samples lie alike to either side. Elsewhere a parabola's value comes early or
/// late: where samples come at nearly the rate of the steps, by the same all along. Beside a gap
/// the cubic has no hold, and the parabola stays. `m`: sums of weight times powers of the distance;
/// `b`: the same times the value.
double value_of_cubic(const std::array<double, 7>& m, const Eigen::Vector4d& b, bool held) {
  const int terms = held ? 4 : 3;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Identity();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (int j = 0; j < terms; ++j) {
    right[j] = b[j];
    for (int k = 0; k < terms; ++k)
      normal(j, k) = m[static_cast<std::size_t>(j) + static_cast<std::size_t>(k)];
  }
  const Eigen::Vector4d c = normal.partialPivLu().solve(right);
  return c.allFinite() ? c[0] : kNaN;
}

}  // namespace

Samples samples_of(const recording::Table& table, const Mapping& mapping,
                   const std::string& channel, const std::vector<double>& time_s) {
  Samples out;
  for (const ColumnMapping& m : mapping.columns) {
    if (m.channel != channel) continue;
    const std::vector<double>* values = table.find(m.column);
    if (values == nullptr) continue;
    out.column = m.column;
    double last = kNaN, filtered_last = kNaN, t_last = 0;
    for (std::size_t i = 0; i < values->size(); ++i) {
      const double raw = (*values)[i];
      if (!std::isfinite(raw) || !std::isfinite(time_s[i])) continue;
      if (m.held && raw == last) continue;
      last = raw;
      double x = raw * m.scale + m.offset;
      if (m.low_pass_s > 0) {  // x + T dx/dt, taken in the middle of two samples
        const double now = x;
        if (std::isnan(filtered_last)) {
          filtered_last = now;
          t_last = time_s[i];
          continue;
        }
        const double dt = time_s[i] - t_last;
        if (!(dt > 0)) continue;
        x = 0.5 * (now + filtered_last) + m.low_pass_s * (now - filtered_last) / dt;
        out.t.push_back(0.5 * (time_s[i] + t_last) - m.delay_s);
        out.x.push_back(x);
        filtered_last = now;
        t_last = time_s[i];
        continue;
      }
      out.t.push_back(time_s[i] - m.delay_s);
      out.x.push_back(x);
    }
  }
  return out;
}

std::vector<double> take_out_spikes(Samples& s, double impossible) {
  constexpr std::size_t kHalf = 2;
  std::vector<double> times;
  constexpr double kSlowest_hz = 45.0;  // below it a sample is as long as what a car does
  const double slowest_hz = std::isfinite(impossible) ? 0.0 : kSlowest_hz;
  if (s.x.size() < 100 || static_cast<double>(s.t.size()) < slowest_hz * (s.t.back() - s.t.front()))
    return times;
  std::vector<double> apart(s.x.size(), 0.0);
  for (std::size_t i = kHalf; i + kHalf < s.x.size(); ++i) {
    std::array<double, 2 * kHalf + 1> near{};
    std::copy_n(s.x.begin() + static_cast<std::ptrdiff_t>(i - kHalf), near.size(), near.begin());
    std::nth_element(near.begin(), near.begin() + kHalf, near.end());
    apart[i] = std::abs(s.x[i] - near[kHalf]);
  }
  const auto part = [](std::vector<double> of, double share) {
    const auto at =
        of.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(of.size() - 1));
    std::nth_element(of.begin(), at, of.end());
    return *at;
  };
  const double limit =
      std::max(20 * part(apart, 0.7),
               std::isfinite(impossible) ? impossible : 0.5 * (part(s.x, 0.99) - part(s.x, 0.01)));
  Samples kept{{}, {}, s.column};
  for (std::size_t i = 0; i < s.x.size(); ++i)
    if (limit > 0 && apart[i] > limit)
      times.push_back(s.t[i]);
    else
      kept.t.push_back(s.t[i]), kept.x.push_back(s.x[i]);
  if (!times.empty()) s = std::move(kept);
  return times;
}

double rate_at(const std::vector<double>& x, std::size_t i) {
  if (i < 2 || i + 2 >= x.size()) return kNaN;
  return (8 * (x[i + 1] - x[i - 1]) - (x[i + 2] - x[i - 2])) / (12 * Signals::kStep_s);
}

void smooth(const Samples& s, double t0, std::size_t n, double half_s, std::vector<double>& x,
            std::vector<double>& dx) {
  x.assign(n, kNaN);
  dx.assign(n, kNaN);
  std::size_t first = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = t0 + Signals::kStep_s * static_cast<double>(i);
    while (first < s.t.size() && s.t[first] < t - half_s) ++first;
    std::array<double, 7> m{};
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    std::size_t count = 0;
    double earliest = 1, latest = -1;
    for (std::size_t k = first; k < s.t.size() && s.t[k] <= t + half_s; ++k) {
      const double d = (s.t[k] - t) / half_s, w = 1.0 - std::abs(d) * 0.9;
      double power = w;
      for (double& sum : m) sum += power, power *= d;
      power = w * s.x[k];
      for (double& sum : b) sum += power, power *= d;
      earliest = std::min(earliest, d);
      latest = std::max(latest, d);
      ++count;
    }
    if (count < 4 || earliest > -0.2 || latest < 0.2) continue;
    x[i] = value_of_cubic(m, b, earliest < -0.5 && latest > 0.5);
  }
  // The derivative of what was smoothed, not the slope of the fit: a rate that is logged itself and
  // is smoothed the same way must agree with it at every frequency.
  for (std::size_t i = 0; i < n; ++i) dx[i] = rate_at(x, i);
}

std::vector<double> noise_like(const Samples& s, double half_s, const std::vector<double>& x) {
  base::Random dice(20);
  Samples drawn{s.t, {}, s.column};
  for (std::size_t k = 0; k < s.t.size(); ++k) drawn.x.push_back(dice.normal());
  std::vector<double> out, rate;
  smooth(drawn, 0.0, x.size(), half_s, out, rate);
  const double scale = beside(s, x) / std::max(1e-12, beside(drawn, out));
  for (double& value : out) value *= scale;
  return out;
}

}  // namespace explain
