#include "replay_errors.h"

#include <algorithm>
#include <cmath>

#include "recording/channels.h"
#include "vehicle/trend.h"

namespace vehicle {

void ErrorSums::add(double car, double hold, double trended) {
  ++samples;
  const std::array<double, 3> errors{car, hold, trended};
  for (std::size_t k = 0; k < 3; ++k) {
    max[k] = std::max(max[k], std::abs(errors[k]));
    squares[k] += errors[k] * errors[k];
  }
}

ChannelError ErrorSums::finish(const std::string& channel) const {
  const auto rmse = [&](std::size_t k) {
    return std::sqrt(squares[k] / static_cast<double>(std::max<std::size_t>(1, samples)));
  };
  return {channel, samples, max[0], rmse(0), max[1], rmse(1), max[2], rmse(2)};
}

ReplayErrors::ReplayErrors(const Source& source) : source_(source) {
  const auto& names = recording::telemetry_channels();
  for (std::size_t c = 0; c < names.size(); ++c) {
    const std::string& name = names[c];
    if (name == "time_s" || name == "gear" || name == "u_m" || name == "v_m" ||
        name.find("command") != std::string::npos)
      continue;
    Channel filled = source.channel(name);
    if (filled.empty()) continue;
    if (name == "x_m") x_ = channels_.size();
    if (name == "y_m") y_ = channels_.size();
    if (name == "yaw_rad") yaw_ = channels_.size();
    channels_.push_back({c, source.recording.table.find(name), std::move(filled), {}, {}});
  }
}

void ReplayErrors::begin(const Window& window) {
  first_ = window.first;
  for (One& one : channels_)
    one.trend = trend(source_.time, one.filled, window.first, window.stretch_begin);
}

void ReplayErrors::add(std::size_t row, const std::vector<double>& values) {
  if (row == first_) return;  // put there
  const double ahead_s = source_.time[row] - source_.time[first_];
  const auto held = [&](const One& one) { return one.filled[first_]; };
  const auto trended = [&](const One& one) { return one.trend.first + ahead_s * one.trend.second; };
  for (One& one : channels_) {
    const double truth = (*one.raw)[row];
    if (std::isfinite(truth))
      one.sums.add(values[one.column] - truth, held(one) - truth, trended(one) - truth);
  }
  const One &x = channels_[x_], &y = channels_[y_], &yaw = channels_[yaw_];
  const double cy = std::cos(yaw.filled[row]), sy = std::sin(yaw.filled[row]);
  const auto along = [&](double px, double py) {
    return cy * (px - x.filled[row]) + sy * (py - y.filled[row]);
  };
  const auto lateral = [&](double px, double py) {
    return -sy * (px - x.filled[row]) + cy * (py - y.filled[row]);
  };
  const double px = values[x.column], py = values[y.column];
  place_[0].add(along(px, py), along(held(x), held(y)), along(trended(x), trended(y)));
  place_[1].add(lateral(px, py), lateral(held(x), held(y)), lateral(trended(x), trended(y)));
}

std::vector<ChannelError> ReplayErrors::finish() const {
  std::vector<ChannelError> out{place_[0].finish("along_m"), place_[1].finish("lateral_m")};
  for (const One& one : channels_)
    out.push_back(one.sums.finish(recording::telemetry_channels()[one.column]));
  return out;
}

}  // namespace vehicle
