#include "numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "crg/surface.h"

namespace view {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");

constexpr std::size_t kMostRows = 3000, kMostColumns = 41;
constexpr double kFarBeside_m = 50.0, kCrossing_m = 100.0;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string dump(const ordered_json& json) {
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

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

}  // namespace

std::string packed_road(const std::string& path) {
  const crg::Surface surface(crg::read(path));
  const crg::Grid& grid = surface.file().grid;
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
                 {"closed", surface.reference_line().closed}});
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
                          const std::string& y_name, const std::string& road_path) {
  const std::vector<double>&x = channel_of(log, x_name).values, &y = channel_of(log, y_name).values;
  const crg::Surface surface(crg::read(road_path));
  const double length_m =
      surface.file().grid.u_step_m *
      static_cast<double>(std::max<std::size_t>(surface.file().grid.rows(), 1) - 1);
  const bool closed = surface.reference_line().closed;
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
