#include "corrected_channels.h"

#include <algorithm>
#include <cmath>

#include "not_known.h"
#include "signal_samples.h"

namespace explain {
namespace {

/// A series read earlier or later by `shift` steps, cubic between steps.
double at(const std::vector<double>& x, const std::vector<double>& dx, double place) {
  if (!(place >= 0) || place > static_cast<double>(x.size() - 1)) return kNaN;
  auto k = static_cast<std::size_t>(place);
  if (k + 1 >= x.size()) k = x.size() - 2;
  const double f = place - static_cast<double>(k);
  if (f == 0.0) return x[k];
  const double a = x[k], b = x[k + 1], da = dx[k] * Signals::kStep_s,
               db = dx[k + 1] * Signals::kStep_s;
  return a + f * (da + f * (3 * (b - a) - 2 * da - db + f * (2 * (a - b) + da + db)));
}

/// What the sensor would have said without its error.
void correct(const Signals& s, const Setting& set, Channel c, std::vector<double>& x,
             std::vector<double>& dx) {
  x = s.x[c];
  dx = s.dx[c];
  Setting::Sensor e = set.sensor[c];
  // y(k) = a y(k-1) + (1 - a) x(k) is a filter half a sample ahead of the one with that constant.
  if (e.low_pass_s != 0) e.delay_s -= set.filter_lead_s;
  if (!s.present[c] || (e.bias == 0 && e.gain == 0 && e.delay_s == 0 && e.low_pass_s == 0)) return;
  const double gain = 1.0 / (1.0 + e.gain);
  std::vector<double> ddx(s.n, kNaN);
  for (std::size_t i = 1; i + 1 < s.n; ++i)
    ddx[i] = (s.dx[c][i + 1] - s.dx[c][i - 1]) / (2 * Signals::kStep_s);
  for (std::size_t i = 0; i < s.n; ++i) {
    const double place = static_cast<double>(i) + e.delay_s / Signals::kStep_s;
    double value = at(s.x[c], s.dx[c], place), rate = s.dx[c][i];
    if (e.delay_s != 0) rate = at(s.dx[c], ddx, place);
    // Beside a gap there is nothing to interpolate with; a value lost there would move the mask.
    if (std::isnan(value)) value = s.x[c][i] + e.delay_s * s.dx[c][i];
    if (std::isnan(rate)) rate = s.dx[c][i];
    if (e.low_pass_s != 0) {
      value += e.low_pass_s * rate;
      rate += e.low_pass_s * (i > 0 && i + 1 < s.n ? ddx[i] : kNaN);
    }
    x[i] = gain * (value - e.bias);
    dx[i] = gain * rate;
  }
  if (e.delay_s == 0 && e.low_pass_s == 0) return;
  // The rate of what stands here now: noise of a value and of its own rate are no relatives, so
  // that none is taken for what goes with the rate, like the place of a sensor.
  for (std::size_t i = 0; i < s.n; ++i)
    if (const double rate = rate_at(x, i); std::isfinite(rate)) dx[i] = rate;
}

}  // namespace

CorrectedChannels corrected_channels(const Signals& s, const Setting& set) {
  CorrectedChannels out;
  for (std::size_t c = 0; c < kChannelCount; ++c)
    correct(s, set, static_cast<Channel>(c), out.x[c], out.dx[c]);
  return out;
}

std::vector<double> delayed(const std::vector<double>& x, double time_s) {
  if (time_s == 0) return x;
  std::vector<double> slope(x.size(), 0.0), out(x.size());
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    slope[i] = (x[i + 1] - x[i - 1]) / (2 * Signals::kStep_s);
  for (std::size_t i = 0; i < x.size(); ++i)
    out[i] = at(x, slope, std::max(0.0, static_cast<double>(i) - time_s / Signals::kStep_s));
  return out;
}

}  // namespace explain
