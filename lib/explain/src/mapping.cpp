#include "explain/mapping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "column_words.h"
#include "vehicle/error.h"
#include "vehicle/place.h"

namespace explain {
namespace {

using vehicle::Error;
using vehicle::Table;
constexpr double kDegree = std::numbers::pi / 180.0;

double share_repeated(const std::vector<double>& values) {
  std::size_t same = 0, seen = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (std::isnan(values[i]) || std::isnan(values[i - 1])) continue;
    ++seen;
    same += values[i] == values[i - 1] ? 1 : 0;
  }
  return seen == 0 ? 0.0 : static_cast<double>(same) / static_cast<double>(seen);
}

/// Slope of y over x through zero, and the correlation.
struct Fit {
  double slope = 0.0, correlation = 0.0;
};
Fit through_zero(const std::vector<double>& x, const std::vector<double>& y) {
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) {
      xx += x[i] * x[i];
      xy += x[i] * y[i];
      yy += y[i] * y[i];
    }
  if (xx <= 0 || yy <= 0) return {};
  return {xy / xx, xy / std::sqrt(xx * yy)};
}

double wrap(double a) { return std::remainder(a, 2 * std::numbers::pi); }

/// What the path says: course, its rate, speed. Central differences over `half` samples.
struct Path {
  std::vector<double> course, rate, speed, acceleration;
};
Path path_of(const std::vector<double>& t, const std::vector<double>& x,
             const std::vector<double>& y) {
  const std::size_t n = t.size();
  std::size_t half = 1;
  while (half * 2 < n / 4 && t[std::min(n - 1, half)] - t[0] < 0.2) ++half;
  Path p;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  p.course.assign(n, nan);
  p.rate = p.speed = p.acceleration = p.course;
  for (std::size_t i = half; i + half < n; ++i) {
    const double dt = t[i + half] - t[i - half];
    const double dx = x[i + half] - x[i - half], dy = y[i + half] - y[i - half];
    if (!(dt > 0)) continue;
    p.speed[i] = std::hypot(dx, dy) / dt;
    if (p.speed[i] > 4.0) p.course[i] = std::atan2(dy, dx);
  }
  for (std::size_t i = half; i + half < n; ++i) {
    const double dt = t[i + half] - t[i - half];
    if (!(dt > 0)) continue;
    p.rate[i] = wrap(p.course[i + half] - p.course[i - half]) / dt;
    p.acceleration[i] = (p.speed[i + half] - p.speed[i - half]) / dt;
  }
  return p;
}

/// How many samples `late` lags behind `reference`, by the largest correlation; NaN if unclear.
double lag_s(const std::vector<double>& t, const std::vector<double>& reference,
             const std::vector<double>& late) {
  const double dt = (t.back() - t.front()) / static_cast<double>(t.size() - 1);
  if (!(dt > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  // Half a second, as far as that is a part of the log; 4 kHz is the fastest logger.
  const int most = static_cast<int>(std::min({0.5 / dt, static_cast<double>(t.size()) / 4.0, 2000.0}));
  std::vector<double> r(2 * static_cast<std::size_t>(most) + 1);
  std::size_t best = 0;
  for (int k = -most; k <= most; ++k) {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = static_cast<std::size_t>(most); i + static_cast<std::size_t>(most) < t.size(); ++i) {
      const double a = reference[i], b = late[static_cast<std::size_t>(static_cast<int>(i) + k)];
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      ab += a * b;
      aa += a * a;
      bb += b * b;
    }
    const auto at = static_cast<std::size_t>(k + most);
    r[at] = aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
    if (r[at] > r[best]) best = at;
  }
  if (r[best] < 0.8 || best == 0 || best + 1 == r.size())
    return std::numeric_limits<double>::quiet_NaN();
  const double a = r[best - 1], b = r[best], c = r[best + 1];
  const double vertex = (a - c) / (2 * (a - 2 * b + c));
  return (static_cast<double>(best) - most + vertex) * dt;
}

/// Every channel the analysis reads.
const std::vector<std::string>& analysed_channels() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out{"time_s", "x_m", "y_m", "z_m", "yaw_rad", "vx_mps", "vy_mps",
                                 "roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps",
                                 "ax_mps2", "ay_mps2", "az_mps2", "steer_rad",
                                 "steer_command_rad", "throttle", "throttle_command", "brake_pa",
                                 "brake_command_pa", "gear", "engine_radps", "fuel_kg"};
    for (const char* w : {"fl", "fr", "rl", "rr"})
      for (const char* form : {"wheel_{}_radps", "wheel_{}_mps", "brake_{}_pa",
                               "brake_{}_command_pa", "fz_{}_n", "suspension_{}_m", "brake_disc_{}_k"})
        out.push_back(fmt::format(fmt::runtime(form), w));
    return out;
  }();
  return names;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double x : values)
    if (std::isfinite(x)) most = std::max(most, std::abs(x));
  return most;
}

bool has_word(const Table& table, std::initializer_list<const char*> words) {
  return std::any_of(table.names.begin(), table.names.end(), [&](const std::string& name) {
    const std::string own = plain(split_unit(name).first);
    return std::any_of(words.begin(), words.end(), [&](const char* word) { return own == word; });
  });
}
bool placed_by_satellites(const Table& table) { return has_word(table, {"sats", "satellites", "nsat", "gpsnsat"}); }
bool north_yaw(const Table& table) { return has_word(table, {"yawnorth"}); }

/// The origin of a plane for latitudes and longitudes: the same for all logs of one place, nearly always.
void choose_origin(const std::vector<double>& latitude_rad, const std::vector<double>& longitude_rad, Mapping& mapping) {
  const auto middle = [](std::vector<double> values) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    if (values.empty()) return std::nan("");
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return std::round(*at / kDegree * 100.0) / 100.0;
  };
  mapping.origin_latitude_deg = middle(latitude_rad);
  mapping.origin_longitude_deg = middle(longitude_rad);
  mapping.has_origin = std::abs(mapping.origin_latitude_deg) <= 90 && std::abs(mapping.origin_longitude_deg) <= 360;
}

}  // namespace

Mapping identity_mapping(const Table& table) {
  Mapping mapping;
  const auto& known = analysed_channels();
  for (const std::string& name : table.names)
    if (std::find(known.begin(), known.end(), name) != known.end()) {
      mapping.columns.push_back({.column = name, .channel = name});
      // Samples of motion that repeat the one before exactly are no measurements.
      const bool motion = name.ends_with("mps") || name.ends_with("radps") || name.ends_with("mps2");  // a place may stay on a straight along an axis
      std::size_t repeats = 0, finite = 0;
      double last = std::nan("");
      for (const double value : *table.find(name)) {
        if (!std::isfinite(value)) continue;
        repeats += value == last ? 1 : 0;
        ++finite;
        last = value;
      }
      if (motion && repeats * 10 > finite * 3 && repeats + 20 < finite) {
        mapping.columns.back().held = true;
        mapping.notes.push_back(fmt::format("'{}': {:.0f} % of the samples repeat the one before: taken for missing", name, 100.0 * static_cast<double>(repeats) / static_cast<double>(finite)));
      }
    }
  return mapping;
}

Mapping propose_mapping(const Table& table, const std::string& name) {
  Mapping mapping;
  const auto& known = analysed_channels();
  std::set<std::string> taken;
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    const std::string& column = table.names[c];
    const auto [stem, unit] = split_unit(column);
    ColumnMapping m{column, ""};
    std::string quantity, word;
    const std::string field = stem.starts_with('/') ? stem.substr(stem.rfind('.') + 1) : column;
    if (std::find(known.begin(), known.end(), field) != known.end()) m.channel = field;
    for (const std::string& candidate : words_of(stem)) {
      if (!m.channel.empty()) break;
      word = candidate;
      for (const Alias& alias : aliases())
        for (const char* other : alias.names)
          if (word == other) {
            m.channel = alias.channel;
            quantity = alias.quantity;
          }
      for (const char* w : {"fl", "fr", "rl", "rr"})
        if (word == std::string("wheel") + w || word == std::string("wheelspeed") + w ||
            word == std::string("ws") + w || (w[1] == 'l' && word == std::string("l") + w[0] + "speed") ||
            (w[1] == 'r' && word == std::string("r") + w[0] + "speed")) {
          const bool turning = unit_scale("turn", unit).has_value();
          m.channel = fmt::format("wheel_{}_{}", w, turning ? "radps" : "mps");
          quantity = turning ? "turn" : "speed";
        }
    }
    // A receiver's heading is its course, and the car's would have its slip angle in it.
    const bool course = word == "heading" && placed_by_satellites(table);
    if (word == "yaw" && north_yaw(table)) m.channel.clear();
    if (course) mapping.notes.push_back(fmt::format("column '{}' is not used: the receiver's course, no heading of the car", column));
    if (course) continue;
    const bool other_quantity = is_unit(unit) && !unit_scale(quantity, unit);
    if (!m.channel.empty() && !quantity.empty() && quantity != "none" && other_quantity) {
      mapping.notes.push_back(fmt::format("column '{}' is not used: {} is no unit of {}", column, unit, m.channel));
      continue;
    }
    if (m.channel.empty()) {
      mapping.notes.push_back(fmt::format("column '{}' is not used: its name says nothing known", column));
      continue;
    }
    if (!taken.insert(m.channel).second) {
      mapping.notes.push_back(fmt::format("column '{}' is not used: {} comes from another", column, m.channel));
      continue;
    }
    if (!quantity.empty() && quantity != "none") {
      if (const auto scale = unit_scale(quantity, unit)) {
        m.scale = *scale;
        if (quantity == "share" && m.scale == 0.01 && largest(table.columns[c]) <= 1.2) m.scale = 1.0;  // says per cent, writes shares
        mapping.notes.push_back(fmt::format("{} from '{}': unit {} in the name, factor {:g}", m.channel, column, unit, m.scale));
      } else {
        // Without a unit: from the size of the values where that decides.
        const double most = largest(table.columns[c]);
        if (quantity == "share" && most > 1.5) m.scale = 0.01;
        if (quantity == "acceleration" && most < 4.0 && most > 0.2) m.scale = 9.80665;
        if ((quantity == "angle" || quantity == "rate") && most > 7.0) m.scale = kDegree;
        if (quantity == "pressure" && most < 500.0) m.scale = 1e5;
        if (quantity == "turn" && most > 2500.0) m.scale = std::numbers::pi / 30;
        mapping.notes.push_back(fmt::format("{} from '{}': no unit known ('{}'); largest value {:g}, factor {:g} guessed: check", m.channel, column, unit, most, m.scale));
      }
    }
    const double repeated = share_repeated(table.columns[c]);
    const bool position = m.channel == "x_m" || m.channel == "y_m" || m.channel == "latitude_rad" || m.channel == "longitude_rad" || m.channel == "yaw_rad" ||
                          m.channel == "vx_mps" || m.channel == "yaw_rate_radps" ||
                          m.channel.starts_with("a") || m.channel.starts_with("wheel");
    if (position && repeated > 0.3 && repeated < 0.99) {
      m.held = true;
      mapping.notes.push_back(fmt::format("{}: {:.0f} % of the samples repeat the one before; they count as missing", m.channel, 100 * repeated));
    }
    mapping.columns.push_back(m);
  }
  const auto find = [&](const char* channel) -> ColumnMapping* {
    for (ColumnMapping& m : mapping.columns)
      if (m.channel == channel) return &m;
    return nullptr;
  };
  const auto values = [&](const char* channel) {
    const ColumnMapping* m = find(channel);
    std::vector<double> out;
    if (m == nullptr) return out;
    out = *table.find(m->column);
    for (double& x : out) x = x * m->scale + m->offset;
    return out;
  };
  const bool by_satellites = find("latitude_rad") != nullptr && find("longitude_rad") != nullptr && find("x_m") == nullptr && find("y_m") == nullptr;
  const bool placed = by_satellites || (find("x_m") != nullptr && find("y_m") != nullptr);
  // What has a speed only can still be driven by; the tools that want a place say so.
  for (const char* needed : {"time_s", "x_m", "y_m"})
    if (find(needed) == nullptr && !(needed[0] != 't' && (placed || find("vx_mps") != nullptr)))
      throw Error(fmt::format("{}: no column for {} among {} columns ('{}', ...); a mapping file can name it",
                              name, needed, table.names.size(), table.names.empty() ? "" : table.names[0].substr(0, 40)));
  std::vector<double> t = values("time_s");
  if (t.size() < 50) throw Error(fmt::format("{}: {} rows; a log of at least 50 is wanted", name, t.size()));
  if (!by_satellites) std::erase_if(mapping.columns, [](const ColumnMapping& m) { return m.channel == "latitude_rad" || m.channel == "longitude_rad"; });
  std::vector<double> x = values("x_m"), y = values("y_m");
  if (by_satellites) {
    choose_origin(values("latitude_rad"), values("longitude_rad"), mapping);
    if (!mapping.has_origin) throw Error(name + ": no latitude and longitude within their bounds");
    Table with = table;
    vehicle::Mapping plane = mapping;
    vehicle::put_on_plane(with, plane, name);
    x = with.columns[with.columns.size() - 2];
    y = with.columns.back();
    mapping.notes.push_back(fmt::format("x_m, y_m: from latitude and longitude, east and north of {:.2f}, {:.2f} degrees; place_turn_rad, place_x_m and place_y_m bring them to a road's frame", mapping.origin_latitude_deg, mapping.origin_longitude_deg));
  }
  if (!placed) {
    mapping.notes.push_back("no place in this log: signs are not confirmed, and steering, whose ratio is not known, is not used; crgexplain run and crgdrive replay want a place");
    std::erase_if(mapping.columns, [](const ColumnMapping& m) { return m.channel.starts_with("steer"); });
    return mapping;
  }
  const Path path = path_of(t, vehicle::fill_gaps(t, x), vehicle::fill_gaps(t, y));

  // Heading: which way it turns and where its zero lies, against the course of the path.
  if (ColumnMapping* m = find("yaw_rad")) {
    const std::vector<double> raw = values("yaw_rad");
    double best = -1, offset = 0, sign = 1;
    for (const double s : {1.0, -1.0}) {
      double sin_sum = 0, cos_sum = 0, count = 0;
      for (std::size_t i = 0; i < t.size(); ++i)
        if (std::isfinite(path.course[i]) && std::isfinite(raw[i])) {
          sin_sum += std::sin(path.course[i] - s * raw[i]);
          cos_sum += std::cos(path.course[i] - s * raw[i]);
          count += 1;
        }
      const double strength = count > 0 ? std::hypot(sin_sum, cos_sum) / count : 0.0;
      if (strength > best) best = strength, sign = s, offset = std::atan2(sin_sum, cos_sum);
    }
    if (by_satellites && best < 0.5) {
      mapping.notes.push_back(fmt::format("column '{}' is not used: the path confirms neither its sign nor its zero (agreement {:.2f})", m->column, std::max(0.0, best)));
      std::erase_if(mapping.columns, [](const ColumnMapping& other) { return other.channel == "yaw_rad"; });
      best = -1;
    }
    // Only quarter turns are a convention; the rest is the sensor's and stays in the data.
    const double quarter = std::round(offset / (std::numbers::pi / 2)) * (std::numbers::pi / 2);
    m = find("yaw_rad");
    if (m != nullptr) m->scale *= sign, m->offset = quarter;
    if (m != nullptr) mapping.notes.push_back(fmt::format("yaw_rad: against the path's course sign {:+.0f}, zero {:.0f} degrees, mean difference {:.2f} degrees, agreement {:.3f} (1 is perfect)", sign, quarter / kDegree, (offset - quarter) / kDegree, best));
  }
  const auto against = [&](const char* channel, const std::vector<double>& reference, const char* what) {
    ColumnMapping* m = find(channel);
    if (m == nullptr) return;
    const Fit fit = through_zero(reference, values(channel));
    if (std::abs(fit.correlation) < 0.5) {
      mapping.notes.push_back(fmt::format("{}: correlation {:.2f} with {}: sign and unit not confirmed", channel, fit.correlation, what));
      return;
    }
    if (fit.slope < 0) m->scale = -m->scale;
    mapping.notes.push_back(fmt::format("{}: {:.3f} times {}, correlation {:.3f}{}", channel, std::abs(fit.slope), what, std::abs(fit.correlation), fit.slope < 0 ? "; sign turned" : ""));
    if (std::abs(std::abs(fit.slope) - 1.0) > 0.3)
      mapping.notes.push_back(fmt::format("{}: a factor of {:.3g} remains: wrong unit?", channel, std::abs(fit.slope)));
    const double late = lag_s(t, reference, values(channel));
    if (std::isfinite(late))
      mapping.notes.push_back(fmt::format("{}: {} {} by {:.3f} s (not corrected: set delay_s if the logger is known to do so)", channel, late >= 0 ? "lags" : "leads", what, std::abs(late)));
  };
  against("yaw_rate_radps", path.rate, "the turning of the path");
  against("vx_mps", path.speed, "the speed of the path");
  against("ax_mps2", path.acceleration, "the path's acceleration");
  std::vector<double> lateral(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) lateral[i] = path.speed[i] * path.rate[i];
  against("ay_mps2", lateral, "speed times turning of the path");
  std::vector<double> curvature(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) curvature[i] = path.rate[i] / path.speed[i] * 3.0;
  for (const char* channel : {"steer_rad", "steer_command_rad"})
    if (ColumnMapping* m = find(channel)) {
      const Fit fit = through_zero(curvature, values(channel));
      if (by_satellites && std::abs(fit.correlation) <= 0.5) {
        mapping.notes.push_back(fmt::format("column '{}' is not used: the path does not confirm it (correlation {:.2f}), and it may be the steering wheel's", m->column, fit.correlation));
        std::erase_if(mapping.columns, [&](const ColumnMapping& other) { return other.channel == channel; });
        continue;
      }
      // Front wheels turn about as far as the curvature asks; understeer is less than this.
      if (std::abs(fit.correlation) > 0.5 && std::abs(fit.slope) > 5.0) {
        mapping.notes.push_back(fmt::format("column '{}' is not used: it turns {:.1f} times as far as the curvature asks of the front wheels of a car of 3 m wheelbase, as a steering wheel does; map it to {} with scale {}{:.6g} over the steering's ratio", m->column, std::abs(fit.slope), channel, fit.slope < 0 ? "-" : "", m->scale));
        std::erase_if(mapping.columns, [&](const ColumnMapping& other) { return other.channel == channel; });
        continue;
      }
      if (fit.correlation < -0.5) m->scale = -m->scale;
      mapping.notes.push_back(fmt::format("{}: correlation {:.2f} with the path's curvature{}", channel, std::abs(fit.correlation), fit.correlation < -0.5 ? "; sign turned" : ""));
    }
  return mapping;
}

}  // namespace explain
