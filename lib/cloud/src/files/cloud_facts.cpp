#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud/read_cloud.h"

namespace cloud {
namespace {

/// Smallest distance of different values; differences that rounding makes (1e-9 m) do not count.
double smallest_step(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[i] - values[i - 1] > 1e-8) step = std::min(step, values[i] - values[i - 1]);
  return std::isfinite(step) ? step : 0.0;
}

}  // namespace

CloudFacts describe(const std::string& path, const CloudReadOptions& options) {
  CloudFacts facts;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  facts.min_m.setConstant(kInf), facts.max_m.setConstant(-kInf);
  facts.time_begin_s = kInf, facts.time_end_s = -kInf;
  std::array<std::vector<double>, 3> sample;
  facts.read = read_chunks(path, options, [&](Cloud&& chunk) {
    const std::vector<double>* const axes[] = {&chunk.x_m, &chunk.y_m, &chunk.z_m};
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax_element(axes[k]->begin(), axes[k]->end());
      facts.min_m[k] = std::min(facts.min_m[k], *low + chunk.origin_m[k]);
      facts.max_m[k] = std::max(facts.max_m[k], *high + chunk.origin_m[k]);
      if (sample[static_cast<std::size_t>(k)].empty())
        sample[static_cast<std::size_t>(k)] = *axes[k];
    }
    for (const double t : chunk.time_s)
      facts.time_begin_s = std::min(facts.time_begin_s, t),
      facts.time_end_s = std::max(facts.time_end_s, t);
    facts.has_time |= !chunk.time_s.empty();
    facts.has_intensity |= !chunk.intensity.empty();
    for (const std::uint8_t c : chunk.classification) ++facts.points_of_class[c];
  });
  for (const std::string& remark : remarks_of(facts.read.marked, options.leave_out_marked))
    facts.read.remarks.push_back(remark);
  if (facts.has_time && !(facts.time_begin_s <= facts.time_end_s)) {
    facts.has_time = false;
    facts.read.remarks.push_back("the times of the points are not numbers");
  }
  if (!facts.has_time) facts.time_begin_s = facts.time_end_s = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    double& step = facts.resolution_m[k];
    const double of_float32 = facts.read.float32_step_m[k];
    step = std::max(smallest_step(std::move(sample[k])), of_float32);
    // The reader tells of steps that are those of float32.
    if (step > 0.015 && step > 1.5 * of_float32 && facts.read.points >= 100)
      facts.read.remarks.push_back(fmt::format("{} is quantised to {:g} m", "xyz"[k], step));
  }
  return facts;
}

}  // namespace cloud
