#include "whole_car_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "selection.h"

namespace explain {
namespace {

constexpr std::size_t kDraws = 4000;

/// Place of a quantile among kDraws sorted values.
std::size_t place_of(double quantile) {
  return static_cast<std::size_t>(quantile * static_cast<double>(kDraws));
}

std::string told(const HeldOut& h) {
  return fmt::format(
      "{} of the whole car after {:g} s on laps left out: {:.3g} {} before, {:.3g} after",
      h.channel, h.horizon_s, h.rmse_before, h.unit, h.rmse_after);
}

}  // namespace

void set_errors(const std::vector<SquaredErrors>& windows, unsigned long long seed, HeldOut& row) {
  const auto rms = [&](std::size_t which) {
    double sum = 0;
    for (const SquaredErrors& w : windows) sum += w[which];
    return std::sqrt(sum / static_cast<double>(windows.size()));
  };
  row.rmse_before = rms(0);
  row.rmse_after = rms(1);
  row.trivial_rmse = rms(2);
  row.trend_rmse = rms(3);
  base::Random dice(seed);
  std::vector<double> drops;
  for (std::size_t draw = 0; draw < kDraws; ++draw) {
    double before = 0, after = 0;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const SquaredErrors& w =
          windows[static_cast<std::size_t>(dice.uniform() * static_cast<double>(windows.size()))];
      before += w[0];
      after += w[1];
    }
    drops.push_back(before > 0 ? 1 - std::sqrt(after / before) : 0.0);
  }
  std::sort(drops.begin(), drops.end());
  const double each = 0.05, all = each / static_cast<double>(kWholeCarRows);
  row.drop_low = drops[place_of(each)];
  row.drop_high = drops[kDraws - 1 - place_of(each)];
  row.sure_low = drops[place_of(all)];
  row.sure_high = drops[kDraws - 1 - place_of(all)];
}

std::string why_not_used(const SimulationCheck& check, bool must_help) {
  if (check.before && !check.after)
    return "with it the whole car cannot be driven; as stated it can";
  if (std::isfinite(check.lap_before_s) && !std::isfinite(check.lap_after_s))
    return "with it the built-in driver does not finish a lap; as stated it does";
  if (check.held_out.empty()) return "";
  const auto& rows = check.held_out;
  const auto worst = std::min_element(
      rows.begin(), rows.end(),
      [](const HeldOut& a, const HeldOut& b) { return a.sure_high < b.sure_high; });
  if (worst->sure_high < -selection::kWorse)
    return fmt::format("{}, worse by {:.0f} to {:.0f} %", told(*worst), -100 * worst->sure_high,
                       -100 * worst->sure_low);
  const auto best =
      std::max_element(rows.begin(), rows.end(),
                       [](const HeldOut& a, const HeldOut& b) { return a.sure_low < b.sure_low; });
  if (must_help && best->sure_low <= 0)
    return fmt::format("nothing is better for sure; the best is {}, better by {:.1f} to {:.1f} %",
                       told(*best), 100 * best->sure_low, 100 * best->sure_high);
  return "";
}

}  // namespace explain
