#include "place_on_road.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <utility>

#include "not_known.h"
#include "shifted_path.h"
#include "signal_samples.h"
#include "vehicle/error.h"
#include "vehicle/road.h"

namespace explain {
namespace {

using vehicle::Error;

/// The rotation and shift that bring a driven lap onto the reference line, if one fits.
std::string offer_transform(const std::vector<double>& x, const std::vector<double>& y,
                            const crg::ReferenceLine& line) {
  constexpr std::size_t kPoints = 200;
  using Complex = std::complex<double>;
  const auto resample = [](const std::vector<Complex>& path) {
    std::vector<double> s(path.size(), 0.0);
    for (std::size_t i = 1; i < path.size(); ++i) s[i] = s[i - 1] + std::abs(path[i] - path[i - 1]);
    std::vector<Complex> out;
    std::size_t k = 0;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const double at = s.back() * static_cast<double>(i) / kPoints;
      while (k + 2 < path.size() && s[k + 1] < at) ++k;
      const double span = s[k + 1] - s[k];
      out.push_back(path[k] + (span > 0 ? (at - s[k]) / span : 0.0) * (path[k + 1] - path[k]));
    }
    return out;
  };
  std::vector<Complex> road, driven;
  double length = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    road.emplace_back(line.x_m[i], line.y_m[i]);
    if (i > 0) length += std::abs(road[i] - road[i - 1]);
  }
  double gone = 0;
  for (std::size_t i = 0; i < x.size() && gone < length; ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const Complex p(x[i], y[i]);
    if (!driven.empty()) gone += std::abs(p - driven.back());
    driven.push_back(p);
  }
  if (driven.size() < 50 || gone < 0.9 * length || road.size() < 3) return "";
  const auto a = resample(driven), b = resample(road);
  Complex mean_a = 0, mean_b = 0;
  for (std::size_t i = 0; i < kPoints; ++i)
    mean_a += a[i] / double(kPoints), mean_b += b[i] / double(kPoints);
  double best = std::numeric_limits<double>::infinity(), turn = 0, best_mirrored = best;
  for (std::size_t shift = 0; shift < kPoints; ++shift) {
    Complex product = 0, mirrored = 0;
    double size = 0;
    for (std::size_t i = 0; i < kPoints; ++i) {
      const Complex p = a[i] - mean_a, q = b[(i + shift) % kPoints] - mean_b;
      product += std::conj(p) * q;
      mirrored += p * q;
      size += std::norm(p) + std::norm(q);
    }
    const double rms2 = (size - 2 * std::abs(product)) / kPoints;
    if (rms2 < best) best = rms2, turn = std::arg(product);
    best_mirrored = std::min(best_mirrored, (size - 2 * std::abs(mirrored)) / kPoints);
  }
  if (best_mirrored < best && std::sqrt(std::max(0.0, best_mirrored)) < 15.0)
    return fmt::format(
        "; mirrored, the path has the road's shape within {:.1f} m: one of x and y has the other "
        "sign, or they are exchanged; correct it in the mapping",
        std::sqrt(std::max(0.0, best_mirrored)));
  if (!(std::sqrt(std::max(0.0, best)) < 15.0)) return "";
  const Complex move = mean_b - mean_a * std::polar(1.0, turn);
  return fmt::format(
      "; the same shape turned by {:.5f} rad about the origin and then shifted by ({:.2f}, {:.2f}) "
      "m "
      "fits within {:.1f} m: crgbuild transform can move the road (by the opposite)",
      turn, move.real(), move.imag(), std::sqrt(std::max(0.0, best)));
}

void count_laps(Signals& s) {
  s.lap.assign(s.n, 0);
  int lap = 0;
  double last = kNaN;
  std::vector<double> gone{0.0};
  for (std::size_t i = 0; i < s.n; ++i) {
    if (std::isfinite(s.u_m[i])) {
      if (std::isfinite(last)) {
        double step = s.u_m[i] - last;
        if (s.closed && step < -0.5 * s.length_m) {
          ++lap;
          gone.push_back(0.0);
          step += s.length_m;
        }
        if (std::abs(step) < 50) gone.back() += step;
      }
      last = s.u_m[i];
    }
    s.lap[i] = lap;
  }
  for (const double way : gone) {
    s.whole.push_back(way > 0.97 * s.length_m);
    if (s.closed) s.rounds += way / s.length_m;
  }
}

/// Grade, bank and vertical curvature over a car's length and track, not of single cells, under a
/// car that goes along (cx, cy) and is where the tracker says: on this leg of a road that crosses
/// itself.
std::array<double, 3> slopes_under(const crg::Surface& surface,
                                   const vehicle::RoadTracker::Place& under, double cx, double cy) {
  vehicle::RoadTracker beside(surface);
  const auto z = [&](double ahead, double left) {
    beside.go_on_from(under);
    const crg::UV at =
        beside.at(under.x_m + ahead * cx - left * cy, under.y_m + ahead * cy + left * cx);
    return surface.z_at_uv(at.u_m, at.v_m);
  };
  const double here = z(0, 0), front = z(2, 0), back = z(-2, 0);
  return {(front - back) / 4.0, (z(0, 0.8) - z(0, -0.8)) / 1.6, (front - 2 * here + back) / 4.0};
}

/// The road under the car, read several times a step and smoothed like the signals that it is held
/// against. A fast car crosses a bump within a step: read once a step, a rough road would press
/// the car that is led as no road pressed the recorded one, and its tyres would be found weak.
class SlopesUnder {
 public:
  /// Where the tracker is at step i, and a little further along the velocity.
  void read(Signals& s, std::size_t i, const crg::Surface& surface, vehicle::RoadTracker& tracker) {
    constexpr int kPerStep = 4;
    const double vx = s.dx[kX][i], vy = s.dx[kY][i], speed = std::hypot(vx, vy);
    const double x = tracker.place().x_m, y = tracker.place().y_m;
    for (int k = 0; k < kPerStep; ++k) {
      const double later_s = Signals::kStep_s * k / kPerStep;
      if (k > 0) tracker.at(x + later_s * vx, y + later_s * vy);
      const auto slopes = slopes_under(surface, tracker.place(), vx / speed, vy / speed);
      for (std::size_t of = 0; of < slopes.size(); ++of) {
        if (k == 0) (s.*kOf[of])[i] = std::isfinite(slopes[of]) ? slopes[of] : 0.0;
        if (!std::isfinite(slopes[of])) continue;
        read_[of].t.push_back(Signals::kStep_s * static_cast<double>(i) + later_s);
        read_[of].x.push_back(slopes[of]);
      }
    }
  }

  /// At the ends of what was driven on the road it stays as it was read.
  void put(Signals& s) const {
    constexpr double kHalf_s = 0.15;
    std::vector<double> smoothed, rate;
    for (std::size_t of = 0; of < read_.size(); ++of) {
      smooth(read_[of], 0.0, s.n, kHalf_s, smoothed, rate);
      std::vector<double>& out = s.*kOf[of];
      for (std::size_t i = 0; i < s.n; ++i)
        if (std::isfinite(out[i]) && std::isfinite(smoothed[i])) out[i] = smoothed[i];
    }
    put_swing(s);
  }

 private:
  /// What the readings of the curvature press with beside the smoothed one, over a second.
  void put_swing(Signals& s) const {
    constexpr std::size_t kAround = 25;
    constexpr double kGravity_mps2 = 9.81;
    std::vector<double> sum(s.n + 1, 0.0), count(s.n + 1, 0.0);  // up to a step
    std::size_t next = 0;
    for (std::size_t i = 0; i < s.n; ++i) {
      sum[i + 1] = sum[i], count[i + 1] = count[i];
      const double square = s.dx[kX][i] * s.dx[kX][i] + s.dx[kY][i] * s.dx[kY][i];
      for (; next < read_[2].t.size() &&
             read_[2].t[next] < Signals::kStep_s * (static_cast<double>(i) + 0.9);
           ++next) {
        const double share = (read_[2].x[next] - s.curvature_v[i]) * square / kGravity_mps2;
        if (std::isfinite(share)) sum[i + 1] += share * share, count[i + 1] += 1;
      }
    }
    s.pressed_swing.assign(s.n, 0.0);
    for (std::size_t i = 0; i < s.n; ++i) {
      const std::size_t from = i > kAround ? i - kAround : 0, to = std::min(s.n, i + kAround + 1);
      if (count[to] > count[from])
        s.pressed_swing[i] = std::sqrt((sum[to] - sum[from]) / (count[to] - count[from]));
    }
  }

  static constexpr std::array<std::vector<double> Signals::*, 3> kOf{
      &Signals::grade, &Signals::bank, &Signals::curvature_v};
  std::array<Samples, 3> read_;
};

/// Steps in which the car moved, and of these the ones beside the road and against it.
struct Driven {
  std::size_t moving = 0, beside = 0, backwards = 0;
  std::vector<BetweenEdges> between;
};

/// The ends of the heights across the road there, v; none where it has none.
std::optional<std::pair<double, double>> edges_at(const crg::Grid& grid, double u_m) {
  const double row = std::round((u_m - grid.u_begin_m) / grid.u_step_m);
  if (!(row >= 0) || row >= static_cast<double>(grid.rows())) return std::nullopt;
  const auto has_height = [&](std::size_t j) {
    return std::isfinite(grid.at(static_cast<std::size_t>(row), j));
  };
  std::size_t right = 0, left = grid.columns();
  while (right < left && !has_height(right)) ++right;
  while (left > right && !has_height(left - 1)) --left;
  if (left <= right) return std::nullopt;
  return std::pair{grid.v_m[right], grid.v_m[left - 1]};
}

Driven put_road(Signals& s, const crg::Surface& surface) {
  const crg::Crg& file = surface.file();
  const crg::ReferenceLine& line = surface.reference_line();
  s.length_m = line.u_step_m * static_cast<double>(line.size() - 1);
  s.closed = line.closed;
  for (auto* v :
       {&s.u_m, &s.v_m, &s.grade, &s.bank, &s.curvature_v, &s.heading_rad, &s.line_curvature_1pm})
    v->assign(s.n, kNaN);
  s.grip.assign(s.n, 1.0);
  vehicle::RoadTracker tracker(surface);
  Driven driven;
  SlopesUnder slopes;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double x = s.x[kX][i], y = s.x[kY][i];
    const double speed = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    if (!std::isfinite(x) || !std::isfinite(y) || !(speed > 3)) continue;
    ++driven.moving;
    const crg::UV place = tracker.at(x, y);
    const crg::Sample at = surface.at_uv(place.u_m, place.v_m);
    const double margin = 3.0, far = 20.0;
    const auto edges = edges_at(file.grid, place.u_m);
    if (edges && place.v_m > edges->first - far && place.v_m < edges->second + far &&
        std::isfinite(at.heading_rad))
      driven.between.push_back({edges->second - place.v_m, place.v_m - edges->first,
                                -std::sin(at.heading_rad), std::cos(at.heading_rad)});
    if (!std::isfinite(at.u_m) || at.v_m < file.grid.v_m.front() - margin ||
        at.v_m > file.grid.v_m.back() + margin || at.u_m < line.u_begin_m - 1.0 ||
        at.u_m > line.u_begin_m + s.length_m + 1.0) {
      ++driven.beside;
      continue;
    }
    const double cx = s.dx[kX][i] / speed, cy = s.dx[kY][i] / speed;
    if (cx * std::cos(at.heading_rad) + cy * std::sin(at.heading_rad) < 0) ++driven.backwards;
    s.u_m[i] = at.u_m - line.u_begin_m;
    s.v_m[i] = at.v_m;
    if (std::isfinite(at.friction)) s.grip[i] = at.friction;
    s.heading_rad[i] = at.heading_rad;
    s.line_curvature_1pm[i] = std::isfinite(at.curvature_1pm) ? at.curvature_1pm : 0.0;
    slopes.read(s, i, surface, tracker);
  }
  slopes.put(s);
  return driven;
}

/// A place that is shifted by metres reads slopes that are not under the car.
void doubt_shifted_path(Signals& s, const std::vector<BetweenEdges>& between) {
  const std::optional<PathShift> shift = s.closed ? shift_onto_road(between) : std::nullopt;
  if (!shift) return;
  s.broken = true;
  s.remarks.push_back(fmt::format(
      "{}: '{}', '{}' come {} an edge of the road, and all round the lap no nearer than {:.1f} m "
      "once shifted by ({:.1f}, {:.1f}) m: their origin is not the road's; add the shift to their "
      "offsets in the mapping",
      s.name, s.column[kX], s.column[kY],
      shift->least_before_m < 0 ? fmt::format("{:.1f} m beyond", -shift->least_before_m)
                                : fmt::format("within {:.1f} m of", shift->least_before_m),
      shift->least_after_m, shift->x_m, shift->y_m));
}

bool moves_against_its_heading(const Signals& s) {
  double along = 0, count = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double d = std::atan2(s.dx[kY][i], s.dx[kX][i]) - s.x[kYaw][i];
    if (std::isfinite(d) && std::isfinite(s.u_m[i])) along += std::cos(d), count += 1;
  }
  return s.present[kYaw] && along < -0.9 * count;
}

}  // namespace

void place_on_road(Signals& s, const crg::Surface& surface) {
  const Driven driven = put_road(s, surface);
  if (driven.moving < 100)
    throw Error(fmt::format("{}: the car hardly moves ({:.1f} s above 3 m/s)", s.name,
                            static_cast<double>(driven.moving) * Signals::kStep_s));
  if (driven.beside * 5 > driven.moving)
    throw Error(fmt::format(
        "{}: {:.0f} % of the path lies beside this road: another track, or another frame{}", s.name,
        100.0 * static_cast<double>(driven.beside) / static_cast<double>(driven.moving),
        offer_transform(s.x[kX], s.x[kY], surface.reference_line())));
  if (driven.beside > 0)
    s.remarks.push_back(fmt::format("{}: {:.1f} s of the path lie beside the road and are left out",
                                    s.name, static_cast<double>(driven.beside) * Signals::kStep_s));
  if (driven.backwards * 2 > driven.moving && moves_against_its_heading(s))
    throw Error(fmt::format(
        "{}: the car drives against u and against its own heading '{}': the rows run backwards in "
        "time; sort them",
        s.name, s.column[kYaw]));
  if (driven.backwards * 2 > driven.moving)
    throw Error(
        fmt::format("{}: the car drives against u; crgbuild reverse turns the road round", s.name));
  doubt_shifted_path(s, driven.between);
  count_laps(s);
}

}  // namespace explain
