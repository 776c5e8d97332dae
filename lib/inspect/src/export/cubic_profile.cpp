#include "cubic_profile.h"

#include <algorithm>
#include <cmath>

namespace road {
namespace {

Cubic straight(double from, double to, double length) { return {from, (to - from) / length}; }

}  // namespace

std::vector<std::size_t> pieces(std::size_t nodes, std::size_t most,
                                const std::function<bool(std::size_t, std::size_t)>& fits) {
  std::vector<std::size_t> ends{0};
  while (ends.back() + 1 < nodes) {
    const std::size_t begin = ends.back(), last = std::min(nodes - 1, begin + most);
    std::size_t good = begin + 1, step = 1;
    while (good + step <= last && fits(begin, good + step)) good += step, step *= 2;
    for (; step > 0; step /= 2)
      if (good + step <= last && fits(begin, good + step)) good += step;
    ends.push_back(good);
  }
  return ends;
}

Cubic hermite(double from, double slope_from, double to, double slope_to, double length) {
  const double mean = (to - from) / length;
  return {from, slope_from, (3.0 * mean - 2.0 * slope_from - slope_to) / length,
          (slope_from + slope_to - 2.0 * mean) / (length * length)};
}

Profile fit_profile(const std::vector<double>& value, double step_m, double within) {
  const std::size_t n = value.size();
  const auto slope = [&](std::size_t i) {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, n - 1);
    return (value[b] - value[a]) / (static_cast<double>(b - a) * step_m);
  };
  const auto cubic = [&](std::size_t begin, std::size_t end) {
    const double length_m = static_cast<double>(end - begin) * step_m;
    return end == begin + 1 ? straight(value[begin], value[end], length_m)
                            : hermite(value[begin], slope(begin), value[end], slope(end), length_m);
  };
  const auto off = [&](std::size_t begin, std::size_t end) {
    const Cubic c = cubic(begin, end);
    double worst = 0.0;
    for (std::size_t i = begin + 1; i < end; ++i)
      worst = std::max(worst, std::abs(c(static_cast<double>(i - begin) * step_m) - value[i]));
    return worst;
  };
  Profile out;
  out.step_m = step_m;
  out.ends = pieces(n, static_cast<std::size_t>(std::max(1.0, kLongest_m / step_m)),
                    [&](std::size_t begin, std::size_t end) { return off(begin, end) <= within; });
  for (std::size_t k = 0; k + 1 < out.ends.size(); ++k) {
    out.cubics.push_back(cubic(out.ends[k], out.ends[k + 1]));
    out.worst = std::max(out.worst, off(out.ends[k], out.ends[k + 1]));
  }
  return out;
}

}  // namespace road
