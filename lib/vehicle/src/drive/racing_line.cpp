#include "vehicle/racing_line.h"

#include <fmt/format.h>

#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "vehicle/error.h"

namespace vehicle {
namespace {

/// Range of v at u that is road without a hole, around the middle of the grid.
struct Width {
  double low, high;
};

Width width_at(const crg::Surface& road, double u_m) {
  const auto& v_m = road.grid().v_m;
  const double middle = 0.5 * (v_m.front() + v_m.back());
  const double step = (v_m.back() - v_m.front()) / (4.0 * static_cast<double>(v_m.size() - 1));
  // Start from the valid place nearest to the middle.
  double start = middle;
  for (std::size_t i = 0; i <= 4 * v_m.size(); ++i) {
    const double offset = (i % 2 == 0 ? 0.5 : -0.5) * static_cast<double>(i + i % 2) * step;
    start = std::clamp(middle + offset, v_m.front(), v_m.back());
    if (std::isfinite(road.z_at_uv(u_m, start))) break;
  }
  Width out{start, start};
  while (out.low - step >= v_m.front() && std::isfinite(road.z_at_uv(u_m, out.low - step)))
    out.low -= step;
  while (out.high + step <= v_m.back() && std::isfinite(road.z_at_uv(u_m, out.high + step)))
    out.high += step;
  return out;
}

/// Neighbour of i at distance k, round the lap or stopped at the ends.
std::size_t neighbour(std::size_t i, std::ptrdiff_t k, std::size_t n, bool closed) {
  const auto size = static_cast<std::ptrdiff_t>(n);
  std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
  if (closed) j = (j % size + size) % size;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(j, 0, size - 1));
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// Stations across which a line may shift: place = base + v normal, low <= v <= high.
struct Stations {
  const std::vector<crg::Point2>&base, &normal;
  const std::vector<double>&low, &high;
  bool closed;
};

/// Turn at the middle one of three points over the square root of its share of the length: squared,
/// what the integral of the squared curvature gets from it.
double bend(const crg::Point2& a, const crg::Point2& b, const crg::Point2& c) {
  const double x1 = b.x_m - a.x_m, y1 = b.y_m - a.y_m, x2 = c.x_m - b.x_m, y2 = c.y_m - b.y_m;
  const double turn = std::atan2(x1 * y2 - y1 * x2, x1 * x2 + y1 * y2);
  return turn / std::sqrt(0.5 * (std::hypot(x1, y1) + std::hypot(x2, y2)));
}

/// Offsets that press against a bound: their rows and columns leave the system.
std::vector<bool> resting(const std::vector<double>& v_m, const Stations& stations,
                          const Eigen::VectorXd& gradient) {
  const std::size_t n = v_m.size();
  std::vector<bool> rests(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double g = gradient(static_cast<Eigen::Index>(i));
    rests[i] = (v_m[i] <= stations.low[i] + 1e-9 && g > 0.0) ||
               (v_m[i] >= stations.high[i] - 1e-9 && g < 0.0);
  }
  return rests;
}

/// Least integral of the squared curvature within the bounds: projected Gauss-Newton (D. P.
/// Bertsekas, Projected Newton methods, 1982). Offsets that press against a bound rest; the others
/// take a step that backtracks until the sum falls. Every round costs one banded solution.
void bend_least(std::vector<double>& v_m, const Stations& stations, int rounds) {
  using Matrix = Eigen::SparseMatrix<double>;
  const std::size_t n = v_m.size();
  const auto at = [&](const std::vector<double>& v, std::size_t i) {
    return crg::Point2{stations.base[i].x_m + v[i] * stations.normal[i].x_m,
                       stations.base[i].y_m + v[i] * stations.normal[i].y_m};
  };
  const std::size_t first = stations.closed ? 0 : 1, last = stations.closed ? n : n - 1;
  const auto around = [&](std::size_t i) {
    return std::array<std::size_t, 3>{(i + n - 1) % n, i, (i + 1) % n};
  };
  const auto bend_at = [&](const std::vector<double>& v, std::size_t i) {
    const auto k = around(i);
    return bend(at(v, k[0]), at(v, k[1]), at(v, k[2]));
  };
  const auto sum = [&](const std::vector<double>& v) {
    double total = 0.0;
    for (std::size_t i = first; i < last; ++i) total += std::pow(bend_at(v, i), 2);
    return total;
  };
  double now = sum(v_m);
  std::vector<Eigen::Triplet<double>> entries;
  for (int round = 0; round < rounds; ++round) {
    // Slopes of the bends by central differences; a bend knows three offsets.
    Eigen::VectorXd bends = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
    entries.clear();
    for (std::size_t i = first; i < last; ++i) {
      bends(static_cast<Eigen::Index>(i)) = bend_at(v_m, i);
      for (const std::size_t k : around(i)) {
        constexpr double kDifference_m = 1e-4;
        const double v = v_m[k];
        v_m[k] = v + kDifference_m;
        const double up = bend_at(v_m, i);
        v_m[k] = v - kDifference_m;
        const double down = bend_at(v_m, i);
        v_m[k] = v;
        entries.emplace_back(static_cast<int>(i), static_cast<int>(k),
                             (up - down) / (2.0 * kDifference_m));
      }
    }
    Matrix slopes(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    slopes.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd gradient = slopes.transpose() * bends;
    const std::vector<bool> rests = resting(v_m, stations, gradient);
    Eigen::VectorXd wanted = -gradient;
    for (std::size_t i = 0; i < n; ++i)
      if (rests[i]) wanted(static_cast<Eigen::Index>(i)) = 0.0;
    slopes.prune([&](Eigen::Index, Eigen::Index column, double) {
      return !rests[static_cast<std::size_t>(column)];
    });
    Matrix normal = slopes.transpose() * slopes;
    const double scale = std::max(1e-12, normal.diagonal().maxCoeff());
    for (Eigen::Index i = 0; i < normal.rows(); ++i)
      normal.coeffRef(i, i) += rests[static_cast<std::size_t>(i)] ? scale : 1e-7 * scale;
    const Eigen::VectorXd step = Eigen::SimplicialLDLT<Matrix>(normal).solve(wanted);
    bool better = false;
    double largest = 0.0;
    for (double share = 1.0; share > 1e-4 && !better; share *= 0.5) {
      std::vector<double> next = v_m;
      largest = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        next[i] = std::clamp(v_m[i] + share * step(static_cast<Eigen::Index>(i)), stations.low[i],
                             stations.high[i]);
        largest = std::max(largest, std::abs(next[i] - v_m[i]));
      }
      const double then = sum(next);
      if (then < now) {
        better = true;
        now = then;
        v_m = next;
      }
    }
    if (!better || largest < 1e-4) break;
  }
}

/// Where a wheel of a car on the line may roll near a station. Beside the road it is 1.
double least_friction(const crg::Surface& road, const RacingLine& line, std::size_t i,
                      crg::Cursor& cursor) {
  constexpr double kBeside_m = 1.0;
  double least = std::numeric_limits<double>::infinity();
  for (const double along : {-0.5, -0.25, 0.0, 0.25, 0.5})
    for (const double beside_m : {-kBeside_m, 0.0, kBeside_m}) {
      const double u_m = line.u_begin_m + line.u_step_m * (static_cast<double>(i) + along);
      const crg::Point2 p = road.xy_of_uv(u_m, line.v_m[i] + beside_m);
      const crg::Sample sample = road.at_xy(p.x_m, p.y_m, cursor);
      if (sample.valid) least = std::min(least, sample.friction);
    }
  return std::isfinite(least) ? least : 1.0;
}

/// Positions and lengths of the stations from their offsets.
void place_stations(const std::vector<crg::Point2>& base, const std::vector<crg::Point2>& normal,
                    RacingLine& line) {
  const std::size_t n = line.v_m.size();
  line.x_m.resize(n);
  line.y_m.resize(n);
  line.s_m.assign(n, 0.0);
  line.heading_rad.resize(n);
  line.curvature_1pm.resize(n);
  line.bank.resize(n);
  line.grade.resize(n);
  line.vertical_curvature_1pm.resize(n);
  line.speed_mps.assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const crg::Point2 p{base[i].x_m + line.v_m[i] * normal[i].x_m,
                        base[i].y_m + line.v_m[i] * normal[i].y_m};
    line.x_m[i] = p.x_m;
    line.y_m[i] = p.y_m;
    if (i > 0)
      line.s_m[i] = line.s_m[i - 1] + std::hypot(p.x_m - line.x_m[i - 1], p.y_m - line.y_m[i - 1]);
  }
  line.length_m = line.s_m.back();
  if (line.closed)
    line.length_m +=
        std::hypot(line.x_m.front() - line.x_m.back(), line.y_m.front() - line.y_m.back());
}

/// Headings, curvatures, bank and grade along the line.
void measure_stations(const crg::Surface& road, RacingLine& line) {
  const std::size_t n = line.v_m.size();
  const double u_begin = line.u_begin_m;
  std::vector<double> z(n);
  for (std::size_t i = 0; i < n; ++i)
    z[i] = road.z_at_uv(u_begin + line.u_step_m * static_cast<double>(i), line.v_m[i]);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t a = neighbour(i, -1, n, line.closed), b = neighbour(i, 1, n, line.closed);
    line.heading_rad[i] = std::atan2(line.y_m[b] - line.y_m[a], line.x_m[b] - line.x_m[a]);
    if (i > 0)
      line.heading_rad[i] =
          line.heading_rad[i - 1] + wrapped(line.heading_rad[i] - line.heading_rad[i - 1]);
    const double before = std::hypot(line.x_m[i] - line.x_m[a], line.y_m[i] - line.y_m[a]);
    const double after = std::hypot(line.x_m[b] - line.x_m[i], line.y_m[b] - line.y_m[i]);
    if (before > 0.0 && after > 0.0) {
      const double turn = wrapped(std::atan2(line.y_m[b] - line.y_m[i], line.x_m[b] - line.x_m[i]) -
                                  std::atan2(line.y_m[i] - line.y_m[a], line.x_m[i] - line.x_m[a]));
      line.curvature_1pm[i] = 2.0 * turn / (before + after);
      line.grade[i] = (z[b] - z[a]) / (before + after);
      line.vertical_curvature_1pm[i] =
          2.0 * ((z[b] - z[i]) / after - (z[i] - z[a]) / before) / (before + after);
    }
    const double u = u_begin + line.u_step_m * static_cast<double>(i);
    const double left = road.z_at_uv(u, line.v_m[i] + 0.5),
                 right = road.z_at_uv(u, line.v_m[i] - 0.5);
    line.bank[i] = std::isfinite(left) && std::isfinite(right) ? left - right : 0.0;
  }
  line.friction.resize(n);
  crg::Cursor cursor;  // one for all: at crossings it stays on its leg
  for (std::size_t i = 0; i < n; ++i) line.friction[i] = least_friction(road, line, i, cursor);
  // A kink of the grid must not count as a crest: smooth the vertical curvature over three
  // stations.
  std::vector<double> smooth = line.vertical_curvature_1pm;
  for (std::size_t i = 0; i < n; ++i)
    smooth[i] = (line.vertical_curvature_1pm[neighbour(i, -1, n, line.closed)] +
                 line.vertical_curvature_1pm[i] +
                 line.vertical_curvature_1pm[neighbour(i, 1, n, line.closed)]) /
                3.0;
  line.vertical_curvature_1pm = smooth;
}

/// Stations of a line, not yet laid.
RacingLine stations_of(const crg::ReferenceLine& reference, double station_m) {
  const double u_length_m = reference.u_step_m * static_cast<double>(reference.size() - 1);
  RacingLine line;
  line.closed = reference.closed;
  const auto n = static_cast<std::size_t>(std::max(8.0, std::round(u_length_m / station_m)));
  line.u_begin_m = reference.u_begin_m;
  line.u_step_m = u_length_m / static_cast<double>(line.closed ? n : n - 1);
  line.v_m.resize(n);
  return line;
}

/// The narrowest of a few cuts around the station, so that holes between stations count.
Width width_around(const crg::Surface& road, const RacingLine& line, std::size_t station) {
  const crg::ReferenceLine& reference = road.reference_line();
  const double u = line.u_begin_m + line.u_step_m * static_cast<double>(station),
               u_end =
                   line.u_begin_m + reference.u_step_m * static_cast<double>(reference.size() - 1);
  Width w = width_at(road, u);
  for (const double shift : {-0.5, -0.25, 0.25, 0.5}) {
    const Width other =
        width_at(road, std::clamp(u + shift * line.u_step_m, line.u_begin_m, u_end));
    w.low = std::max(w.low, other.low);
    w.high = std::min(w.high, other.high);
  }
  return w;
}

}  // namespace

double largest_margin_m(const crg::Surface& road, const RacingLineOptions& options) {
  const RacingLine line = stations_of(road.reference_line(), options.station_m);
  double least_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < line.v_m.size(); ++i) {
    const Width w = width_around(road, line, i);
    least_m = std::min(least_m, w.high - w.low);
  }
  return 0.5 * least_m;
}

RacingLine plan_line(const crg::Surface& road, const RacingLineOptions& options) {
  RacingLine line = stations_of(road.reference_line(), options.station_m);
  const std::size_t n = line.v_m.size();
  std::vector<double> low(n), high(n);
  std::vector<crg::Point2> base(n), normal(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double u = line.u_begin_m + line.u_step_m * static_cast<double>(i);
    const Width w = width_around(road, line, i);
    low[i] = w.low + options.margin_m;
    high[i] = w.high - options.margin_m;
    if (low[i] > high[i])
      throw Error(
          fmt::format("the road at u = {:.1f} m is {:.2f} m wide; a line with {:.2f} m to both "
                      "edges needs more",
                      u, w.high - w.low, options.margin_m));
    base[i] = road.xy_of_uv(u, 0.0);
    const crg::Point2 left = road.xy_of_uv(u, 1.0);
    normal[i] = {left.x_m - base[i].x_m, left.y_m - base[i].y_m};
    line.v_m[i] = 0.5 * (low[i] + high[i]);
  }

  bend_least(line.v_m, {base, normal, low, high, line.closed}, options.rounds);
  place_stations(base, normal, line);
  measure_stations(road, line);
  return line;
}

}  // namespace vehicle
