#include "numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/json_text.h"
#include "crg/surface.h"

namespace view {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");

constexpr std::size_t kMostRows = 3000, kMostColumns = 41;
constexpr std::size_t kMostDifferenceRows = 1000, kMostDifferenceColumns = 201;
constexpr double kFarBeside_m = 50.0, kCrossing_m = 100.0;
constexpr double kFinestProfile_m = 0.02, kMostProfile = 20'000.0;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string dump(const ordered_json& json) { return base::dump_json(json); }

class Packed {
 public:
  explicit Packed(ordered_json head) : head_(std::move(head)) {
    head_["arrays"] = ordered_json::array();
  }
  template <class Value>
  void add(const std::string& name, const std::vector<Value>& values) {
    head_["arrays"].push_back(
        {{"name", name}, {"type", sizeof(Value) == 4 ? "f32" : "f64"}, {"count", values.size()}});
    arrays_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    arrays_.resize((arrays_.size() + 7) / 8 * 8);
  }
  std::string bytes() const {
    std::string head = dump(head_);
    head.resize((4 + head.size() + 7) / 8 * 8 - 4, ' ');
    const auto length = static_cast<std::uint32_t>(head.size());
    std::string out(reinterpret_cast<const char*>(&length), 4);
    return out + head + arrays_;
  }

 private:
  ordered_json head_;
  std::string arrays_;
};

/// At most `most` of 0 ... count - 1, evenly, with the first and the last.
std::vector<std::size_t> some_of(std::size_t count, std::size_t most) {
  std::vector<std::size_t> out;
  const std::size_t n = std::min(count, most);
  for (std::size_t k = 0; k < n; ++k) out.push_back(n < 2 ? 0 : k * (count - 1) / (n - 1));
  return out;
}

const recording::Channel& channel_of(const recording::Log& log, const std::string& name) {
  for (const recording::Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw base::Error(fmt::format("the log has no channel '{}'", name));
}

/// Places of one road on another, row after row: where a road crosses itself the nearest leg may be
/// the wrong one, the leg of the row before is not.
class Follower {
 public:
  explicit Follower(const crg::Surface& other) : other_(other) {}

  /// u of the other road where this place of the first one's line is; NaN where it has none.
  double row(double u_m, const crg::Point2& on_line) {
    std::optional<crg::UV> found;
    const crg::Point2 same = other_.xy_of_uv(u_m, 0.0);
    if (std::hypot(on_line.x_m - same.x_m, on_line.y_m - same.y_m) <= kNear_m)
      found = crg::UV{u_m, 0.0};  // the same line
    if (!found && !std::isnan(last_m_))
      found = near(on_line, {last_m_ + (u_m - last_of_first_m_), 0.0});
    if (!found) found = near(on_line, {u_m, 0.0});
    if (!found) found = near(on_line, other_.uv_of_xy(on_line.x_m, on_line.y_m, cursor_));
    last_m_ = found ? found->u_m : kNaN;
    last_of_first_m_ = u_m;
    return last_m_;
  }

  /// (u, v) of the other road at this place of the map, near a first guess; nothing where none is.
  std::optional<crg::UV> near(const crg::Point2& place, crg::UV guess) const {
    if (std::isnan(guess.u_m) || std::isnan(guess.v_m)) return std::nullopt;
    constexpr double kAlong_m = 0.5, kStill_m = 0.02;
    constexpr int kMostSteps = 8;
    double away_m = 0.0;
    for (int step = 0; step < kMostSteps; ++step) {
      const crg::Point2 here = other_.xy_of_uv(guess.u_m, guess.v_m);
      const double dx = place.x_m - here.x_m, dy = place.y_m - here.y_m;
      away_m = std::hypot(dx, dy);
      if (away_m <= kNear_m) return guess;
      if (away_m > kFarBeside_m) return std::nullopt;
      const crg::Point2 a = other_.xy_of_uv(guess.u_m - kAlong_m, 0.0),
                        b = other_.xy_of_uv(guess.u_m + kAlong_m, 0.0);
      const double length = std::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
      if (!(length > 0.0)) return std::nullopt;
      const double tx = (b.x_m - a.x_m) / length, ty = (b.y_m - a.y_m) / length;
      guess.u_m += dx * tx + dy * ty;
      guess.v_m += dy * tx - dx * ty;
    }
    if (away_m <= kStill_m) return guess;
    return std::nullopt;
  }

 private:
  static constexpr double kNear_m = 1e-6;
  const crg::Surface& other_;
  crg::Cursor cursor_;
  double last_m_ = kNaN, last_of_first_m_ = 0.0;
};

}  // namespace

std::string packed_road(const crg::Surface& surface) {
  const crg::Grid& grid = surface.grid();
  const std::vector<std::size_t> rows = some_of(grid.rows(), kMostRows),
                                 columns = some_of(grid.columns(), kMostColumns);
  std::vector<double> u, x, y, left_x, left_y, right_x, right_y, v;
  std::vector<float> z;
  for (const std::size_t j : columns) v.push_back(grid.v_m[j]);
  for (const std::size_t i : rows) {
    u.push_back(grid.u_of(i));
    const crg::Point2 on_line = surface.xy_of_uv(u.back(), 0.0);
    x.push_back(on_line.x_m);
    y.push_back(on_line.y_m);
    for (const std::size_t j : columns)
      z.push_back(static_cast<float>(surface.z_at_uv(u.back(), grid.v_m[j])));
    double low = kNaN, high = kNaN;  // v of the outermost nodes with a height
    for (std::size_t j = 0; j < grid.columns(); ++j) {
      if (std::isnan(grid.at(i, j))) continue;
      if (std::isnan(low)) low = grid.v_m[j];
      high = grid.v_m[j];
    }
    const auto edge = [&](double at, std::vector<double>& ex, std::vector<double>& ey) {
      const crg::Point2 p =
          std::isnan(at) ? crg::Point2{kNaN, kNaN} : surface.xy_of_uv(u.back(), at);
      ex.push_back(p.x_m);
      ey.push_back(p.y_m);
    };
    edge(high, left_x, left_y);
    edge(low, right_x, right_y);
  }
  Packed packed({{"rows", rows.size()},
                 {"columns", columns.size()},
                 {"rows_in_file", grid.rows()},
                 {"columns_in_file", grid.columns()},
                 {"length_m", u.empty() ? 0.0 : u.back() - u.front()},
                 {"u_begin_m", u.empty() ? 0.0 : u.front()},
                 {"closed", surface.closed()}});
  packed.add("u_m", u);
  packed.add("x_m", x);
  packed.add("y_m", y);
  packed.add("left_x_m", left_x);
  packed.add("left_y_m", left_y);
  packed.add("right_x_m", right_x);
  packed.add("right_y_m", right_y);
  packed.add("v_m", v);
  packed.add("z_m", z);
  return packed.bytes();
}

std::string place_json(const crg::Surface& surface, double x_m, double y_m) {
  crg::Cursor cursor;
  const crg::UV at = surface.uv_of_xy(x_m, y_m, cursor);
  if (!(std::abs(at.v_m) <= kFarBeside_m)) return R"({"u_m":null,"v_m":null})";
  return dump({{"u_m", at.u_m}, {"v_m", at.v_m}});
}

std::string packed_difference(const crg::Surface& surface, const crg::Surface& other,
                              double u_begin_m, double u_end_m) {
  const crg::Grid& grid = surface.grid();
  std::vector<std::size_t> inside, before_start;
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    const double u = grid.u_of(i);
    if (u_begin_m <= u_end_m ? u >= u_begin_m && u <= u_end_m : u >= u_begin_m) inside.push_back(i);
    if (u_begin_m > u_end_m && u <= u_end_m) before_start.push_back(i);
  }
  inside.insert(inside.end(), before_start.begin(), before_start.end());
  if (inside.empty())
    throw base::Error(
        fmt::format("no row of the road lies between u = {} m and {} m", u_begin_m, u_end_m));
  std::vector<double> u, v;
  std::vector<float> z, z_of_other;
  const std::vector<std::size_t> rows = some_of(inside.size(), kMostDifferenceRows),
                                 columns = some_of(grid.columns(), kMostDifferenceColumns);
  for (const std::size_t j : columns) v.push_back(grid.v_m[j]);
  Follower follower(other);
  for (const std::size_t k : rows) {
    u.push_back(grid.u_of(inside[k]));
    const double there_m = follower.row(u.back(), surface.xy_of_uv(u.back(), 0.0));
    for (const double at : v) {
      z.push_back(static_cast<float>(surface.z_at_uv(u.back(), at)));
      const auto same = follower.near(surface.xy_of_uv(u.back(), at), {there_m, at});
      z_of_other.push_back(same ? static_cast<float>(other.z_at_uv(same->u_m, same->v_m))
                                : std::nanf(""));
    }
  }
  Packed packed({{"rows", rows.size()}, {"columns", columns.size()}});
  packed.add("u_m", u);
  packed.add("v_m", v);
  packed.add("z_m", z);
  packed.add("against_m", z_of_other);
  return packed.bytes();
}

std::string packed_profile(const crg::Surface& road, const crg::Point2& from,
                           const crg::Point2& to) {
  const double length_m = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
  if (!(length_m > 0.0))
    throw base::Error("a line from one place to another wanted, one place seen");
  const auto steps = static_cast<std::size_t>(
      std::clamp(std::ceil(length_m / kFinestProfile_m), 1.0, kMostProfile - 1.0));
  const crg::Grid& grid = road.grid();
  const double u_end_m = grid.u_of(grid.rows() - 1);
  std::vector<double> s, u, v, z;
  crg::Cursor cursor;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(steps);
    const crg::UV at = road.uv_of_xy(from.x_m + share * (to.x_m - from.x_m),
                                     from.y_m + share * (to.y_m - from.y_m), cursor);
    const bool is_on = at.u_m >= grid.u_of(0) && at.u_m <= u_end_m && at.v_m >= grid.v_m.front() &&
                       at.v_m <= grid.v_m.back();
    s.push_back(share * length_m);
    u.push_back(is_on ? at.u_m : kNaN);
    v.push_back(is_on ? at.v_m : kNaN);
    z.push_back(is_on ? road.z_at_uv(at.u_m, at.v_m) : kNaN);
  }
  Packed packed(ordered_json::object({{"length_m", length_m}}));
  packed.add("s_m", s);
  packed.add("u_m", u);
  packed.add("v_m", v);
  packed.add("z_m", z);
  return packed.bytes();
}

std::string channels_json(const recording::Log& log) {
  ordered_json channels = ordered_json::array();
  for (const recording::Channel& channel : log.channels) {
    double low = kNaN, high = kNaN;
    std::size_t count = 0;
    for (const double value : channel.values) {
      if (std::isnan(value)) continue;
      ++count;
      low = count == 1 ? value : std::min(low, value);
      high = count == 1 ? value : std::max(high, value);
    }
    channels.push_back({{"name", channel.name},
                        {"unit", channel.unit},
                        {"rate_hz", channel.rate_hz},
                        {"values", count},
                        {"min", low},
                        {"max", high}});
  }
  return dump({{"format", log.format},
               {"rows", log.channels.empty() ? 0 : log.channels.front().values.size()},
               {"channels", channels}});
}

std::string packed_channels(const recording::Log& log, const std::vector<std::string>& names) {
  Packed packed(ordered_json::object());
  for (const std::string& name : names) packed.add(name, channel_of(log, name).values);
  return packed.bytes();
}

std::string packed_places(const recording::Log& log, const std::string& x_name,
                          const std::string& y_name, const crg::Surface& surface) {
  const std::vector<double>&x = channel_of(log, x_name).values, &y = channel_of(log, y_name).values;
  const double length_m = surface.grid().u_step_m *
                          static_cast<double>(std::max<std::size_t>(surface.grid().rows(), 1) - 1);
  const bool closed = surface.closed();
  crg::Cursor cursor;
  std::vector<double> u(x.size(), kNaN), v(x.size(), kNaN);
  double driven_m = 0.0;  // since the last place that was believed
  std::size_t last = x.size(), believed = x.size();
  for (std::size_t k = 0; k < std::min(x.size(), y.size()); ++k) {
    if (!std::isfinite(x[k]) || !std::isfinite(y[k])) continue;
    if (last < x.size()) driven_m += std::hypot(x[k] - x[last], y[k] - y[last]);
    last = k;
    const crg::UV at = surface.uv_of_xy(x[k], y[k], cursor);
    if (!(std::abs(at.v_m) <= kFarBeside_m)) continue;
    // Where the road crosses itself the nearest leg may be the other one: nobody drives there so
    // fast.
    if (believed < x.size() && driven_m < kCrossing_m) {
      double moved_m = std::abs(at.u_m - u[believed]);
      if (closed) moved_m = std::min(moved_m, std::abs(length_m - moved_m));
      if (moved_m > 3.0 * driven_m + 5.0) continue;
    }
    u[k] = at.u_m;
    v[k] = at.v_m;
    believed = k;
    driven_m = 0.0;
  }
  Packed packed({{"length_m", length_m}, {"closed", closed}});
  packed.add("u_m", u);
  packed.add("v_m", v);
  return packed.bytes();
}

}  // namespace view
