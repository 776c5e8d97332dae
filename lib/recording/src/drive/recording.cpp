#include "recording/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "base/error.h"
#include "base/settings.h"
#include "base/utf8.h"
#include "recording/channels.h"
#include "recording/log_table.h"
#include "recording/place.h"

namespace recording {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kReset_s = 1.0;  ///< time running back by more is a new clock, by less a late row

constexpr double kHeldShare = 0.3;  ///< fewer repeats are quantisation or chance

/// Channels in which a car that moves cannot show the same number twice.
bool is_motion(const std::string& channel) {
  for (const char* name : {"x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "roll_rate_radps",
                           "pitch_rate_radps", "yaw_rate_radps", "ax_mps2", "ay_mps2", "az_mps2",
                           "engine_radps", "roll_rad", "pitch_rad", "z_m"})
    if (channel == name) return true;
  return channel.starts_with("wheel_") || channel.starts_with("fz_") ||
         channel.starts_with("suspension_");
}

/// The value at time t by the straight line between finite neighbours in [stretch).
double interpolate(const std::vector<double>& time, const std::vector<double>& values,
                   const Stretch& stretch, double t) {
  const auto begin = time.begin() + static_cast<std::ptrdiff_t>(stretch.begin);
  const auto end = time.begin() + static_cast<std::ptrdiff_t>(stretch.end);
  const auto upper = std::lower_bound(begin, end, t);
  if (upper == end) return kNaN;
  const auto j = static_cast<std::size_t>(upper - time.begin());
  if (time[j] == t) return values[j];
  if (upper == begin) return kNaN;
  return values[j - 1] + (t - time[j - 1]) / (time[j] - time[j - 1]) * (values[j] - values[j - 1]);
}

/// Angles without jumps of a turn.
void unwrap(std::vector<double>& angle_rad) {
  double last = kNaN, turns = 0.0;
  for (double& value : angle_rad) {
    if (!std::isfinite(value)) continue;
    if (std::isfinite(last))
      turns -=
          std::round((value + turns - last) / (2.0 * std::numbers::pi)) * 2.0 * std::numbers::pi;
    value += turns;
    last = value;
  }
}

/// Orders the rows by a clock that only goes forward: which rows stay, and their time.
std::vector<std::size_t> mend_clock(std::vector<double>& time, Recording& out) {
  std::vector<std::size_t> keep;
  double shift = 0.0, last = 0.0;
  const auto trouble = [&](double t) {
    if (out.rows_repeated + out.rows_backwards + out.clock_resets + out.rows_without_time == 1)
      out.first_trouble_s = t;
  };
  for (std::size_t i = 0; i < time.size(); ++i) {
    // Beyond 1e15 s a clock is none: a second more changes nothing.
    if (!(std::abs(time[i] + shift) < 1e15)) {
      ++out.rows_without_time;
      trouble(last);
      continue;
    }
    double t = time[i] + shift;
    if (!keep.empty() && t <= last) {
      if (t < last - kReset_s) {
        ++out.clock_resets;
        shift += last + kReset_s - t;
        t = last + kReset_s;
        trouble(t);
      } else {
        ++(t == last ? out.rows_repeated : out.rows_backwards);
        trouble(t);
        continue;
      }
    }
    time[i] = last = t;
    keep.push_back(i);
  }
  return keep;
}

void find_stretches(const std::vector<double>& time, Recording& out) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time.size(); ++i) steps.push_back(time[i] - time[i - 1]);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  out.step_s = steps[steps.size() / 2];
  out.stretches.push_back({0, 0});
  for (std::size_t i = 1; i < time.size(); ++i) {
    const double step = time[i] - time[i - 1];
    if (step <= 2.5 * out.step_s) continue;
    out.longest_gap_s = std::max(out.longest_gap_s, step);
    out.stretches.back().end = i;
    out.stretches.push_back({i, 0});
  }
  out.stretches.back().end = time.size();
}

/// Counts samples of motion that repeat the one before, and empties them where they are said to be.
void empty_held(const std::vector<ColumnMapping>& wanted, Recording& out) {
  const std::vector<double>* const speed = out.table.find("vx_mps");
  std::vector<char> moving(out.table.rows(), 1);
  if (speed != nullptr)
    for (std::size_t i = 0; i < moving.size(); ++i) moving[i] = std::abs((*speed)[i]) > 1.0;
  for (std::size_t c = 0; c < out.table.names.size(); ++c) {
    std::vector<double>& values = out.table.columns[c];
    if (out.table.names[c] == "time_s") continue;
    double low = kNaN, high = kNaN;
    std::size_t measured = 0;
    for (const double value : values)
      if (std::isfinite(value)) {
        low = measured == 0 ? value : std::min(low, value);
        high = measured == 0 ? value : std::max(high, value);
        ++measured;
      }
    if (measured > 1 && low == high) {
      out.constant.push_back(out.table.names[c]);
      continue;
    }
    if (!is_motion(out.table.names[c])) continue;
    double last = kNaN;
    std::size_t asked = 0;
    std::vector<std::size_t> repeats;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) continue;
      if (moving[i] != 0) {
        ++asked;
        if (values[i] == last) repeats.push_back(i);
      }
      last = values[i];
    }
    const double share =
        asked == 0 ? 0.0 : static_cast<double>(repeats.size()) / static_cast<double>(asked);
    if (share <= kHeldShare) continue;
    out.held.emplace_back(out.table.names[c], share);
    if (wanted[c].held)
      for (const std::size_t i : repeats) values[i] = kNaN;
  }
}

/// Accelerations from where and how the accelerometer sits to the centre of mass, body axes.
void move_imu(const Mapping& mapping, const std::vector<double>& time, Recording& out) {
  const auto column = [&](const char* name) -> std::vector<double>* {
    for (std::size_t c = 0; c < out.table.names.size(); ++c)
      if (out.table.names[c] == name) return &out.table.columns[c];
    return nullptr;
  };
  std::vector<double>* const ax = column("ax_mps2");
  std::vector<double>* const ay = column("ay_mps2");
  const double c = std::cos(mapping.imu_yaw_rad), s = std::sin(mapping.imu_yaw_rad);
  if (s != 0.0 && ax != nullptr && ay != nullptr)
    for (std::size_t i = 0; i < ax->size(); ++i) {
      const double x = (*ax)[i], y = (*ay)[i];
      (*ax)[i] = c * x - s * y;
      (*ay)[i] = s * x + c * y;
    }
  const std::vector<double>* const turning = column("yaw_rate_radps");
  if (mapping.imu_ahead_m == 0.0 || turning == nullptr) return;
  for (const Stretch& stretch : out.stretches)
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      const std::size_t a = std::max(stretch.begin + 1, i) - 1,
                        b = std::min(stretch.end - 1, i + 1);
      const double rate = (*turning)[i];
      if (ax != nullptr) (*ax)[i] += mapping.imu_ahead_m * rate * rate;
      if (ay != nullptr && b > a)
        (*ay)[i] -= mapping.imu_ahead_m * ((*turning)[b] - (*turning)[a]) / (time[b] - time[a]);
    }
}

/// One channel, or a list of those that a column gives.
std::vector<std::string> channels_of(const base::Section& entry, const std::string& where) {
  const base::Setting* const channel = entry.find("channel");
  if (channel == nullptr || channel->kind != base::Setting::Kind::kList)
    return {entry.text("channel")};
  std::vector<std::string> out = entry.words("channel");
  if (out.empty())
    throw base::Error(
        fmt::format("{}: an empty list of channels; name one, or take the column out", where));
  return out;
}

}  // namespace

Mapping read_mapping(const std::string& path) {
  const base::Setting root = base::read_settings(path);
  const base::Section top(root, path, "a mapping");
  top.allow({"version", "columns", "imu_yaw_rad", "imu_ahead_m", "origin_latitude_deg",
             "origin_longitude_deg", "place_turn_rad", "place_x_m", "place_y_m"});
  (void)top.number("version", 1.0, 1.0, 1.0);
  Mapping out;
  out.path = path;
  out.imu_yaw_rad = top.number("imu_yaw_rad", 0.0, -2.0 * std::numbers::pi, 2.0 * std::numbers::pi);
  out.imu_ahead_m = top.number("imu_ahead_m", 0.0, -20.0, 20.0);
  constexpr double kNone = 1e6;
  out.origin_latitude_deg = top.number("origin_latitude_deg", kNone, -90.0, 90.0);
  out.origin_longitude_deg = top.number("origin_longitude_deg", kNone, -360.0, 360.0);
  out.has_origin = out.origin_latitude_deg != kNone && out.origin_longitude_deg != kNone;
  out.place_turn_rad =
      top.number("place_turn_rad", 0.0, -2.0 * std::numbers::pi, 2.0 * std::numbers::pi);
  out.place_x_m = top.number("place_x_m", 0.0, -1e8, 1e8);
  out.place_y_m = top.number("place_y_m", 0.0, -1e8, 1e8);
  const auto& known = canonical_channels();
  top.section("columns").for_each([&](const std::string& column, const base::Setting& value,
                                      const std::string& where) {
    const base::Section entry(value, path, column);
    entry.allow({"channel", "scale", "offset", "delay_s", "low_pass_s", "held"});
    ColumnMapping map;
    map.column = base::in_utf8(column);  // mappings once had the bytes of the log
    map.scale = entry.number("scale", 1.0, -1e12, 1e12);
    map.offset = entry.number("offset", 0.0, -1e12, 1e12);
    map.delay_s = entry.number("delay_s", 0.0, -10.0, 10.0);
    map.low_pass_s = entry.number("low_pass_s", 0.0, 0.0, 10.0);
    map.held = entry.flag("held", false);
    for (const std::string& channel : channels_of(entry, where)) {
      map.channel = channel;
      if (std::find(known.begin(), known.end(), channel) == known.end())
        throw base::Error(fmt::format("{}: there is no channel '{}'; docs/recordings.md lists them",
                                      where, channel.substr(0, 60)));
      for (const ColumnMapping& other : out.columns)
        if (other.channel == channel)
          throw base::Error(fmt::format("{}: channel {} twice", where, channel));
      if (map.scale == 0.0) throw base::Error(fmt::format("{}: scale of {} is 0", where, channel));
      out.columns.push_back(map);
    }
  });
  return out;
}

std::vector<double> fill_gaps(const std::vector<double>& time_s,
                              const std::vector<double>& values) {
  std::vector<double> out = values;
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const std::size_t from = last ? *last + 1 : 0;
    for (std::size_t k = from; k < i; ++k)
      out[k] = last ? values[*last] + (time_s[k] - time_s[*last]) / (time_s[i] - time_s[*last]) *
                                          (values[i] - values[*last])
                    : values[i];
    last = i;
  }
  if (last)
    for (std::size_t k = *last + 1; k < values.size(); ++k) out[k] = values[*last];
  return out;
}

Recording make_recording(const Table& log, const std::string& name, const Mapping& mapping) {
  for (const ColumnMapping& map : mapping.columns)
    if (map.channel == "latitude_rad") {
      Table placed = log;
      Mapping plane = mapping;
      put_on_plane(placed, plane, name);
      const bool done = std::none_of(plane.columns.begin(), plane.columns.end(),
                                     [](const auto& m) { return m.channel == "latitude_rad"; });
      if (done) return make_recording(placed, name, plane);
      break;
    }
  Recording out;
  out.rows_read = log.rows();
  std::vector<ColumnMapping> wanted = mapping.columns;
  if (mapping.path.empty() && wanted.empty())
    for (const std::string& channel : canonical_channels())
      if (log.find(channel) != nullptr)
        wanted.push_back({channel, channel, 1.0, 0.0, 0.0, 0.0, true});
  Table table;
  for (const ColumnMapping& map : wanted) {
    const std::vector<double>* const column = log.find(map.column);
    if (column == nullptr)
      throw base::Error(
          fmt::format("{}: no column '{}', which {} takes for {}", name, map.column.substr(0, 60),
                      mapping.path.empty() ? "the mapping" : mapping.path, map.channel));
    std::vector<double> values = *column;
    for (double& value : values) value = map.scale * value + map.offset;
    table.add(map.channel, std::move(values));
  }
  const std::vector<double>* const clock = table.find("time_s");
  if (clock == nullptr)
    throw base::Error(fmt::format("{}: no channel time_s; name its column in a mapping", name));

  std::vector<double> time = *clock;
  const std::vector<std::size_t> keep = mend_clock(time, out);
  if (keep.size() < 10)
    throw base::Error(
        fmt::format("{}: {} rows with ascending time, wanted at least 10", name, keep.size()));
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    const bool is_clock = table.names[c] == "time_s";
    std::vector<double> values;
    values.reserve(keep.size());
    for (const std::size_t row : keep)
      values.push_back(is_clock ? time[row] : table.columns[c][row]);
    if (table.names[c] == "yaw_rad") unwrap(values);
    out.table.add(table.names[c], std::move(values));
  }
  const std::vector<double> mended = *out.table.find("time_s");
  find_stretches(mended, out);
  empty_held(wanted, out);

  for (std::size_t c = 0; c < wanted.size(); ++c) {
    std::vector<double>& values = out.table.columns[c];
    if (wanted[c].low_pass_s > 0.0) {  // x + T dx/dt of a first-order filter is what went in
      const std::vector<double> slow = values;
      for (const Stretch& stretch : out.stretches)
        for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
          const std::size_t a = std::max(stretch.begin + 1, i) - 1,
                            b = std::min(stretch.end - 1, i + 1);
          if (b > a)
            values[i] += wanted[c].low_pass_s * (slow[b] - slow[a]) / (mended[b] - mended[a]);
        }
    }
    // Channels that the log stamps late describe an earlier moment.
    if (wanted[c].delay_s != 0.0 && wanted[c].channel != "time_s") {
      const std::vector<double> late = values;
      for (const Stretch& stretch : out.stretches)
        for (std::size_t i = stretch.begin; i < stretch.end; ++i)
          values[i] = interpolate(mended, late, stretch, mended[i] + wanted[c].delay_s);
    }
  }
  move_imu(mapping, mended, out);
  return out;
}

Recording read_recording(const std::string& path, const Mapping& mapping) {
  std::vector<std::size_t> words;
  const Table log = read_log_table(path, &words);
  Recording out = make_recording(log, path, mapping);
  for (std::size_t i = 0; i < log.names.size(); ++i) {
    bool used = mapping.columns.empty();
    for (const ColumnMapping& map : mapping.columns) used = used || map.column == log.names[i];
    if (used) out.cells_not_numbers += words[i];
  }
  return out;
}

}  // namespace recording
