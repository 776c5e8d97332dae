#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "actuator_parts.h"
#include "base/error.h"

namespace identify {
namespace {

constexpr std::size_t kFewest = 50, kMost = 200000;

/// The block of each row: the command moves as much in each, so that each has its say; a tenth of
/// the measure is time. -1: not judged.
void cut_into_blocks(Record& record) {
  const std::size_t rows = record.command.size();
  const auto skipped = std::min(rows / 10, static_cast<std::size_t>(1.0 / record.step_s));
  const double count = std::clamp(static_cast<double>(rows - skipped) / 10.0, 4.0, 60.0);
  double moved = 0.0, whole = 0.0;
  const auto step = [&](std::size_t i) {
    return std::abs(record.command[i] - record.command[i - 1]);
  };
  for (std::size_t i = std::max<std::size_t>(1, skipped); i < rows; ++i) whole += step(i);
  for (std::size_t i = 0; i < rows; ++i) {
    if (i > 0 && i >= skipped && whole > 0.0) moved += step(i) / whole;
    const double time =
        static_cast<double>(i - std::min(i, skipped)) / static_cast<double>(rows - skipped);
    const double share = whole > 0.0 ? 0.9 * moved + 0.1 * time : time;
    record.block.push_back(
        i < skipped ? -1 : static_cast<int>(std::min(count - 1.0, std::floor(count * share))));
  }
  record.blocks = static_cast<int>(count);
}

}  // namespace

Record record_of(const std::vector<double>& time_s, const std::vector<double>& command,
                 const std::vector<double>& movement) {
  if (time_s.size() < kFewest || command.size() != time_s.size() ||
      movement.size() != time_s.size())
    throw base::Error(fmt::format("{} rows, wanted at least {}", time_s.size(), kFewest));
  for (const auto* values : {&time_s, &command, &movement})
    for (const double value : *values)
      if (!std::isfinite(value)) throw base::Error("a value is not finite; fill or leave out gaps");
  const auto range = [](const std::vector<double>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *high - *low;
  };
  const double command_range = range(command);
  if (!(command_range > 1e-9))
    throw base::Error(fmt::format("the command stays at {}; it has to move", command.front()));
  if (!(range(movement) > 1e-12))
    throw base::Error(fmt::format("the movement stays at {}; it has to move", movement.front()));
  const std::size_t rows = std::min(kMost, time_s.size());
  Record out;
  out.command_range = command_range;
  out.step_s = (time_s[rows - 1] - time_s[0]) / static_cast<double>(rows - 1);
  if (!(out.step_s > 0.0)) throw base::Error("time does not ascend");
  bool even = true;
  for (std::size_t i = 0; i < rows; ++i)
    if (std::abs(time_s[i] - time_s[0] - static_cast<double>(i) * out.step_s) > 0.1 * out.step_s)
      even = false;
  if (even) {
    out.command.assign(command.begin(), command.begin() + static_cast<std::ptrdiff_t>(rows));
    out.movement.assign(movement.begin(), movement.begin() + static_cast<std::ptrdiff_t>(rows));
  } else {
    std::size_t at = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      const double t = time_s[0] + static_cast<double>(i) * out.step_s;
      while (at + 2 < rows && time_s[at + 1] < t) ++at;
      const double share = std::clamp((t - time_s[at]) / (time_s[at + 1] - time_s[at]), 0.0, 1.0);
      out.command.push_back(command[at] + share * (command[at + 1] - command[at]));
      out.movement.push_back(movement[at] + share * (movement[at + 1] - movement[at]));
    }
  }
  cut_into_blocks(out);
  const auto judged =
      std::find_if(out.block.begin(), out.block.end(), [](int b) { return b >= 0; });
  if (!(range({out.command.begin() + (judged - out.block.begin()), out.command.end()}) > 1e-9))
    throw base::Error(
        "the command moves in the first second or tenth of the record only, which is not judged");
  return out;
}

bool in_steps(const std::vector<double>& command) {
  double first = 0.0, second = 0.0;
  for (std::size_t i = 2; i < command.size(); ++i) {
    first += std::pow(command[i] - command[i - 1], 2);
    second += std::pow(command[i] - 2.0 * command[i - 1] + command[i - 2], 2);
  }
  return second > 1.2 * first;
}

}  // namespace identify
