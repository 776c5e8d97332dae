#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "confirm_mapping.h"

namespace explain {
namespace {

/// How many times `vx_mps` a wheel's numbers are, where the car drives; 0: that is not known.
double ratio_to(const std::vector<double>& vx_mps, const std::vector<double>& wheel) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < wheel.size(); ++i)
    if (std::isfinite(wheel[i]) && vx_mps[i] > 4.0) ratios.push_back(wheel[i] / vx_mps[i]);
  return ratios.size() < 20 ? 0.0 : base::median(std::move(ratios));
}

}  // namespace

void confirm_wheels(const recording::Table& table, Mapping& mapping) {
  if (find_channel(mapping, "vx_mps") == nullptr) return;
  const std::vector<double> vx_mps = mapped_values(mapping, table, "vx_mps");
  for (const char* const wheel : {"fl", "fr", "rl", "rr"}) {
    const std::string channel = fmt::format("wheel_{}_mps", wheel);
    ColumnMapping* const m = find_channel(mapping, channel);
    if (m == nullptr || !mapping.guessed.contains(channel)) continue;
    const double ratio = ratio_to(vx_mps, *table.find(m->column));
    if (ratio == 0.0) continue;
    // What a car's bus says is a few per cent off; km/h must be told from small wheels in rad/s.
    bool known = false;
    for (const auto& [unit, within] : {std::pair{1.0, 0.12}, {1 / 3.6, 0.03}, {0.44704, 0.05}})
      if (!known && std::abs(ratio * unit - 1.0) < within) {
        m->scale = unit;
        known = true;
      }
    constexpr double kLeastRadius_m = 0.12, kGreatestRadius_m = 0.42;
    if (!known && ratio > 1.0 / kGreatestRadius_m && ratio < 1.0 / kLeastRadius_m) {
      m->channel = fmt::format("wheel_{}_radps", wheel);
      m->scale = 1.0;
      known = true;
    }
    mapping.notes.push_back(
        known
            ? fmt::format("{} from '{}': factor {:g}, as its numbers are {:.3f} times vx_mps",
                          m->channel, m->column, m->scale, ratio)
            : fmt::format("column '{}' is not used: its numbers are {:.3f} times vx_mps, which is "
                          "no unit of a wheel's speed that is known",
                          m->column, ratio));
    if (!known)
      std::erase_if(mapping.columns, [&](const ColumnMapping& c) { return c.channel == channel; });
  }
}

}  // namespace explain
