#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "identify/least_squares.h"
#include "reduce_fit.h"

namespace identify {
namespace {

constexpr std::size_t kMostRows = 2500;  // of a curve

/// One row of a curve.
struct CurveRow {
  CurveInput at;
  double fx_n = 0.0, fy_n = 0.0;
};

std::vector<CurveRow> wheel_rows(const ReducedCar& car, const std::vector<CarMoment>& moments,
                                 std::size_t axle) {
  std::vector<CurveRow> out;
  for (const CarMoment& m : moments)
    for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i) {
      const WheelMoment& w = m.wheel[i];
      if (std::abs(w.kappa) > kMostWheelSlip || w.fz_n < kLeastLoad_n) continue;
      CurveRow row{{w.fz_n, 0.0, w.kappa, 0.0, side_of(i)}, w.fx_n, w.fy_n};
      row.at.gamma_rad = side_of(i) * (car.camber[axle][0] + car.camber[axle][1] * w.fz_n) +
                         car.camber[axle][2] * m.ay_mps2;
      const std::array<double, 4> slip = wheel_slips(car, planar_state(m));
      row.at.tan_alpha = slip[i] + w.lag;
      out.push_back(row);
    }
  return out;
}

/// Moments that a car can be in for more than an instant: the yaw moment is small against what the
/// axles make of it. Load transfer belongs to the axle's force there, as the numbers take it to.
bool balanced(const ReducedCar& car, const CarMoment& m) {
  double forces = 0.0;
  for (const WheelMoment& w : m.wheel) forces += std::abs(w.fy_n);
  return std::abs(m.yaw_moment_nm) < 0.05 * car.wheelbase_m * forces + 100.0;
}

std::vector<CurveRow> axle_rows(const ReducedCar& car, const std::vector<CarMoment>& moments,
                                std::size_t axle) {
  std::vector<CurveRow> out;
  for (const CarMoment& m : moments) {
    if (!grips(m) || !balanced(car, m)) continue;
    const WheelMoment &l = m.wheel[2 * axle], &r = m.wheel[2 * axle + 1];
    CurveRow row;
    row.fx_n = l.fx_n + r.fx_n;
    row.fy_n = l.fy_n + r.fy_n;
    row.at.fz_n = l.fz_n + r.fz_n;
    row.at.kappa = (l.kappa * l.fz_n + r.kappa * r.fz_n) / std::max(1.0, row.at.fz_n);
    row.at.tan_alpha = axle_slips(car, planar_state(m))[axle] +
                       (l.lag * l.fz_n + r.lag * r.fz_n) / std::max(1.0, row.at.fz_n);
    out.push_back(row);
  }
  return out;
}

std::vector<CurveRow> thinned(const std::vector<CurveRow>& rows) {
  const std::size_t every = rows.size() / kMostRows + 1;
  std::vector<CurveRow> out;
  for (std::size_t i = 0; i < rows.size(); i += every) out.push_back(rows[i]);
  return out;
}

struct Slot {
  const char* name;
  double* value;
  double low, high, typical;
};

/// What of a curve is fitted; `whole` axles have no camber and no sides.
std::vector<Slot> slots(WheelCurve& c, bool whole) {
  std::vector<Slot> out{{"mu0", &c.mu[0], 0.1, 5.0, 1.0},
                        {"mu1", &c.mu[1], -2.0, 2.0, 0.1},
                        {"mu2", &c.mu[2], -1.0, 1.0, 0.1},
                        {"k0", &c.k[0], 1.0, 200.0, 20.0},
                        {"k1", &c.k[1], 0.3, 20.0, 2.0},
                        {"c", &c.c, 1.02, 2.2, 1.0},
                        {"e0", &c.e[0], -10.0, 1.0, 1.0},
                        {"e1", &c.e[1], -5.0, 5.0, 1.0},
                        {"mx0", &c.mx[0], 0.1, 5.0, 1.0},
                        {"mx1", &c.mx[1], -2.0, 2.0, 0.1},
                        {"kx0", &c.kx[0], 1.0, 200.0, 20.0},
                        {"kx1", &c.kx[1], -50.0, 50.0, 5.0},
                        {"cx", &c.cx, 1.02, 2.2, 1.0},
                        {"ex", &c.ex, -10.0, 0.99, 1.0},
                        {"wy0", &c.wy[0], 0.0, 60.0, 10.0},
                        {"wy1", &c.wy[1], 0.0, 60.0, 5.0},
                        {"wy2", &c.wy[2], 0.0, 1.8, 1.0},
                        {"wx0", &c.wx[0], 0.0, 60.0, 10.0},
                        {"wx1", &c.wx[1], 0.0, 60.0, 5.0},
                        {"wx2", &c.wx[2], 0.0, 1.8, 1.0},
                        {"shift_kappa", &c.shift_kappa, -0.05, 0.05, 0.01}};
  if (whole) return out;
  out.insert(out.end(), {{"mu_camber", &c.mu_camber, -20.0, 50.0, 1.0},
                         {"shift_camber", &c.shift_camber, -3.0, 3.0, 0.1},
                         {"shift_side", &c.shift_side, -0.05, 0.05, 0.01},
                         {"push_camber", &c.push_camber, -5.0, 5.0, 0.1},
                         {"push_side", &c.push_side, -0.5, 0.5, 0.01}});
  return out;
}

WheelCurve begin_curve(const vehicle::Car<double>& full, std::size_t axle, double wheels) {
  const auto& tyre = full.files->tyre[axle];
  const double load = full.static_load_n[axle];
  const auto at = vehicle::tyre_forces(
      tyre, vehicle::TyreInput<double>{load, 0.0, 0.0, 0.0, 30.0, 0.0}, {}, {.moments = false});
  const double k = 1.2 * std::abs(at.cornering_stiffness_npr) / load,
               kx = std::abs(at.slip_stiffness_n) / load;
  // Without camber, sides and shifts.
  return {wheels * load,
          {std::abs(at.mu_y), -0.1, 0.0},
          {10.0, 8.0, 1.0},
          {10.0, 8.0, 1.0},
          {k, 2.0},
          {-0.5, 0.0},
          {std::abs(at.mu_x), -0.1},
          {kx, 0.0},
          0.0,
          1.4,
          1.6,
          0.0,
          0.0,
          0.0,
          0.0,
          0.0,
          0.0};
}

WheelCurve fit_curve(WheelCurve curve, const std::vector<CurveRow>& rows, bool whole) {
  std::vector<Unknown> unknowns;
  for (const Slot& s : slots(curve, whole))
    unknowns.push_back({s.name, *s.value, s.low, s.high, s.typical});
  const double size = curve.load_n;
  const auto set = [&](const std::vector<double>& values) {
    const std::vector<Slot> to = slots(curve, whole);
    for (std::size_t k = 0; k < to.size(); ++k) *to[k].value = values[k];
  };
  least_squares(unknowns, [&](const std::vector<double>& values, std::vector<double>& left) {
    set(values);
    left.resize(2 * rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const CurveForces f = curve_forces(curve, rows[i].at);
      left[2 * i] = (f.fy_n - rows[i].fy_n) / size;
      left[2 * i + 1] = 0.3 * (f.fx_n - rows[i].fx_n) / size;  // lateral is what it is for
    }
  });
  std::vector<double> values;
  for (const Unknown& u : unknowns) values.push_back(u.value);
  set(values);
  return curve;
}

void judge_curve(const WheelCurve& curve, const std::vector<CurveRow>& rows,
                 const std::string& name, std::vector<PartError>& errors) {
  ErrorSum x, y;
  for (const CurveRow& row : rows) {
    const CurveForces f = curve_forces(curve, row.at);
    y.add(row.fy_n, f.fy_n);
    x.add(row.fx_n, f.fx_n);
  }
  errors.push_back(y.as(name + ", side force", "N"));
  errors.push_back(x.as(name + ", longitudinal force", "N"));
}

}  // namespace

void fit_curves(ReducedCar& car, const std::vector<CarMoment>& moments,
                const std::vector<CarMoment>& trimmed, const vehicle::Car<double>& full,
                unsigned threads, std::vector<PartError>& errors) {
  std::array<std::vector<CurveRow>, 4> rows;  // wheels front, rear; axles front, rear
  for (std::size_t a = 0; a < 2; ++a) {
    rows[a] = wheel_rows(car, moments, a);
    rows[2 + a] = axle_rows(car, trimmed, a);
  }
  for (const auto& part : rows)
    if (part.size() < 100)
      throw base::Error(
          fmt::format("only {} moments of the full car on the rig have wheels that neither slide "
                      "nor hang in the air, wanted at least 100: is this a car that can corner?",
                      part.size()));
  std::array<WheelCurve, 4> found{};
  base::parallel_for(4, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      found[k] = fit_curve(begin_curve(full, k % 2, k < 2 ? 1.0 : 2.0), thinned(rows[k]), k >= 2);
  });
  for (std::size_t a = 0; a < 2; ++a) {
    car.wheel[a] = found[a];
    car.axle[a] = found[2 + a];
    judge_curve(car.wheel[a], rows[a], fmt::format("{} wheel", recording::kAxleNames[a]), errors);
    judge_curve(car.axle[a], rows[2 + a],
                fmt::format("{} axle, effective", recording::kAxleNames[a]), errors);
  }
}

}  // namespace identify
