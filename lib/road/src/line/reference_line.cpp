#include "road/reference_line.h"

#include <fmt/format.h>

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/statistics.h"
#include "mesh/error.h"
#include "road/road_graph.h"

namespace road {

namespace {

using Eigen::Vector2d;

constexpr double kKnotSpacing_m = 2.0;
// Shape shorter than this along the line counts as noise of the mesh, not as a bend of the road.
constexpr double kSmoothingWavelength_m = 8.0;
constexpr double kClosingGap_m = 1e-3;  // what every OpenCRG reader accepts as closed

/// Uniform cubic B-spline in the plane, C2, over t in [0, spans * kKnotSpacing_m].
class PlaneSpline {
 public:
  PlaneSpline(std::vector<Vector2d> control, bool closed, double knot_m)
      : control_(std::move(control)), closed_(closed), knot_m_(knot_m) {}

  double length_t() const { return knot_m_ * static_cast<double>(spans()); }

  Vector2d at(double t) const {
    return combine(t, [](double s) -> Weights {
      const double r = 1.0 - s;
      return {r * r * r / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
              (-3 * s * s * s + 3 * s * s + 3 * s + 1) / 6, s * s * s / 6};
    });
  }
  Vector2d derivative(double t) const {
    return combine(t,
                   [](double s) -> Weights {
                     const double r = 1.0 - s;
                     return {-r * r / 2, (3 * s * s - 4 * s) / 2, (-3 * s * s + 2 * s + 1) / 2,
                             s * s / 2};
                   }) /
           knot_m_;
  }
  Vector2d second_derivative(double t) const {
    return combine(t,
                   [](double s) -> Weights {
                     return {1 - s, 3 * s - 2, 1 - 3 * s, s};
                   }) /
           (knot_m_ * knot_m_);
  }

  double curvature(double t) const {
    const Vector2d d = derivative(t), dd = second_derivative(t);
    return (d.x() * dd.y() - d.y() * dd.x()) / std::pow(std::max(d.norm(), 1e-9), 3);
  }

 private:
  using Weights = std::array<double, 4>;
  std::size_t spans() const { return closed_ ? control_.size() : control_.size() - 3; }

  template <typename Basis>
  Vector2d combine(double t, const Basis& basis) const {
    const auto n = static_cast<std::ptrdiff_t>(control_.size());
    double position = t / knot_m_;
    if (closed_) position -= std::floor(position / static_cast<double>(n)) * static_cast<double>(n);
    auto span = static_cast<std::ptrdiff_t>(std::floor(position));
    span = std::clamp<std::ptrdiff_t>(span, 0, static_cast<std::ptrdiff_t>(spans()) - 1);
    const Weights weights = basis(position - static_cast<double>(span));
    Vector2d sum = Vector2d::Zero();
    for (std::ptrdiff_t k = 0; k < 4; ++k) {
      sum +=
          weights[static_cast<std::size_t>(k)] * control_[static_cast<std::size_t>((span + k) % n)];
    }
    return sum;
  }

  std::vector<Vector2d> control_;
  bool closed_;
  double knot_m_;
};

/// How much smaller than life the road of a model is: 1 for what is as wide as a road.
double model_scale_of(const Centreline& centreline) {
  if (centreline.half_width_m.empty()) return 1.0;
  const double width_m = 2.0 * base::median(centreline.half_width_m);
  return width_m > 0.0 && width_m < kModelWidth_m ? width_m / kUsualWidth_m : 1.0;
}

/// Where the way through the points turns most.
std::size_t sharpest_turn(const std::vector<Vector2d>& points, bool closed) {
  const std::size_t n = points.size();
  std::size_t sharpest = 0;
  double least_cosine = 2.0;
  for (std::size_t i = closed ? 0 : 1; i < (closed ? n : n - 1); ++i) {
    const Vector2d in = points[i] - points[(i + n - 1) % n], out = points[(i + 1) % n] - points[i];
    const double cosine = in.dot(out) / std::max(in.norm() * out.norm(), 1e-12);
    if (cosine < least_cosine) least_cosine = cosine, sharpest = i;
  }
  return sharpest;
}

/// Penalised least squares (P-spline): sum |p_i - S(t_i)|^2 + lambda * integral |S'''|^2 dt.
base::Answer<PlaneSpline> fit_spline(const std::vector<Vector2d>& points,
                                     const std::vector<double>& t, double length_t, bool closed,
                                     double model_scale) {
  const auto spans = static_cast<Eigen::Index>(
      std::max(closed ? 6.0 : 3.0, std::round(length_t / (model_scale * kKnotSpacing_m))));
  const double knot_m = length_t / static_cast<double>(spans);
  const Eigen::Index unknowns = closed ? spans : spans + 3;
  const double density = static_cast<double>(points.size()) / length_t;
  const double cutoff_radpm = 2.0 * std::numbers::pi / (model_scale * kSmoothingWavelength_m);
  const double lambda = density / std::pow(cutoff_radpm, 6);
  const double penalty = lambda / std::pow(knot_m, 5);

  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX2d rhs = Eigen::MatrixX2d::Zero(unknowns, 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double position = t[i] / knot_m;
    const auto span =
        std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::floor(position)), 0, spans - 1);
    const double s = position - static_cast<double>(span), r = 1.0 - s;
    const std::array<double, 4> w{r * r * r / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
                                  (-3 * s * s * s + 3 * s * s + 3 * s + 1) / 6, s * s * s / 6};
    for (Eigen::Index a = 0; a < 4; ++a) {
      const Eigen::Index row = (span + a) % unknowns;
      rhs.row(row) += w[static_cast<std::size_t>(a)] * points[i].transpose();
      for (Eigen::Index b = 0; b < 4; ++b) {
        entries.emplace_back(row, (span + b) % unknowns,
                             w[static_cast<std::size_t>(a)] * w[static_cast<std::size_t>(b)]);
      }
    }
  }
  constexpr std::array<double, 4> kThirdDifference{-1, 3, -3, 1};
  for (Eigen::Index i = 0; i < (closed ? unknowns : unknowns - 3); ++i) {
    for (Eigen::Index a = 0; a < 4; ++a) {
      for (Eigen::Index b = 0; b < 4; ++b) {
        entries.emplace_back((i + a) % unknowns, (i + b) % unknowns,
                             penalty * kThirdDifference[static_cast<std::size_t>(a)] *
                                 kThirdDifference[static_cast<std::size_t>(b)]);
      }
    }
  }
  Eigen::SparseMatrix<double> normal(unknowns, unknowns);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  const Eigen::MatrixX2d control = solver.solve(rhs);
  if (solver.info() != Eigen::Success || !control.allFinite()) {
    return base::Refusal(
        "the centreline does not fit a smooth curve: fewer than 3 distinct stations or stations at "
        "infinity");
  }
  std::vector<Vector2d> result;
  for (Eigen::Index i = 0; i < unknowns; ++i) result.emplace_back(control.row(i).transpose());
  return PlaneSpline{std::move(result), closed, knot_m};
}

/// The t > from_t where the curve is `step_m` away from `from`, straight line.
double chord_step(const PlaneSpline& spline, const Vector2d& from, double from_t, double step_m) {
  double t = from_t + step_m / std::max(spline.derivative(from_t).norm(), 1e-6);
  for (int i = 0; i < 8; ++i) {
    const Vector2d d = spline.at(t) - from;
    const double distance = d.norm();
    const double slope = d.dot(spline.derivative(t)) / std::max(distance, 1e-12);
    const double change = (step_m - distance) / std::max(slope, 1e-3);
    t += change;
    if (std::abs(change) < 1e-13 * (1.0 + t)) break;
  }
  return t;
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

double spline_length_m(const PlaneSpline& spline, double length_t, double model_scale) {
  double length_m = 0.0;
  const auto pieces = static_cast<std::size_t>(std::ceil(length_t / (model_scale * 0.1)));
  Vector2d last = spline.at(0.0);
  for (std::size_t i = 1; i <= pieces; ++i) {
    const Vector2d next =
        spline.at(length_t * static_cast<double>(i) / static_cast<double>(pieces));
    length_m += (next - last).norm();
    last = next;
  }
  return length_m;
}

/// Of the segment that ends at each node; `start` is the direction at the first.
void set_headings(const Vector2d& start, crg::ReferenceLine& line) {
  line.heading_rad.resize(line.size());
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double heading = std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]);
    // Unwrapped, so that consumers may interpolate it.
    line.heading_rad[i] =
        i == 1 ? heading : line.heading_rad[i - 1] + wrapped(heading - line.heading_rad[i - 1]);
  }
  line.heading_rad[0] =
      line.heading_rad[1] + wrapped(std::atan2(start.y(), start.x()) - line.heading_rad[1]);
}

void report_fit(const PlaneSpline& spline, const std::vector<Vector2d>& points,
                const std::vector<double>& t, double length_t, double model_scale,
                const crg::ReferenceLine& line, ReferenceLineReport& report) {
  report.length_m = line.u_step_m * static_cast<double>(line.size() - 1);
  report.closed = line.closed;
  if (line.closed) {
    const Vector2d gap = spline.at(0.0) - Vector2d(line.x_m.back(), line.y_m.back());
    report.closing_gap_m = gap.norm();
    report.length_m += report.closing_gap_m;
    // Between the headings of the last segment and the first lies half a step of curvature each.
    const double bend = 0.5 * line.u_step_m * (spline.curvature(0.0) + spline.curvature(length_t));
    report.heading_step_at_seam_rad =
        std::abs(wrapped(line.heading_rad[1] - line.heading_rad.back() - bend));
  }
  std::vector<double> residual;
  for (std::size_t i = 0; i < points.size(); ++i)
    residual.push_back((spline.at(t[i]) - points[i]).norm());
  std::sort(residual.begin(), residual.end());
  report.fit_residual_max_m = residual.back();
  report.fit_residual_p99_m =
      residual[static_cast<std::size_t>(0.99 * static_cast<double>(points.size() - 1))];
  double largest_curvature = 0.0;
  for (double at = 0.0; at < length_t; at += 0.25 * model_scale * kKnotSpacing_m) {
    largest_curvature = std::max(largest_curvature, std::abs(spline.curvature(at)));
  }
  report.min_radius_m =
      largest_curvature > 0.0 ? 1.0 / largest_curvature : std::numeric_limits<double>::infinity();
}

}  // namespace

double automatic_step_m(const Centreline& centreline) {
  constexpr double kUsual_m = 0.1, kStepsAcross = 40.0;
  if (centreline.half_width_m.empty()) return kUsual_m;
  const double wanted_m = 2.0 * base::median(centreline.half_width_m) / kStepsAcross;
  if (!(wanted_m > 0.0) || wanted_m >= kUsual_m) return kUsual_m;
  const double decade_m = std::pow(10.0, std::floor(std::log10(wanted_m)));
  for (const double nice : {5.0, 2.0})
    if (nice * decade_m <= wanted_m) return nice * decade_m;
  return decade_m;
}

base::Answer<crg::ReferenceLine> try_fit_reference_line(const Centreline& centreline,
                                                        const ReferenceLineOptions& options,
                                                        ReferenceLineReport* report) {
  const std::size_t n = centreline.points_m.size();
  if (n < 4)
    return base::Refusal(
        fmt::format("{} centreline stations; a reference line needs at least 4", n));
  const double u_step_m = options.u_step_m.value_or(automatic_step_m(centreline));
  if (!(u_step_m > 0.0)) throw Error(fmt::format("u_step_m is {}; wanted > 0", u_step_m));

  // Work near zero: squares of UTM coordinates would cost the fit its last millimetres.
  const Vector2d origin = centreline.points_m[0].head<2>();
  std::vector<Vector2d> points;
  std::vector<double> t{0.0};
  for (const auto& p : centreline.points_m) points.emplace_back(p.head<2>() - origin);
  for (std::size_t i = 1; i < n; ++i) t.push_back(t.back() + (points[i] - points[i - 1]).norm());
  const double length_t = t.back() + (centreline.closed ? (points[0] - points[n - 1]).norm() : 0.0);
  if (length_t < 10.0 * u_step_m) {
    return base::Refusal(fmt::format(
        "the centreline is {:.2f} m long; wanted at least ten steps of {} m", length_t, u_step_m));
  }
  const double model_scale = model_scale_of(centreline);
  const auto fitted = fit_spline(points, t, length_t, centreline.closed, model_scale);
  if (!fitted) return fitted.refusal();
  const PlaneSpline& spline = *fitted;

  const double length_m = spline_length_m(spline, length_t, model_scale);
  crg::ReferenceLine line;
  line.closed = centreline.closed;
  const auto steps = static_cast<std::size_t>(line.closed ? std::round(length_m / u_step_m)
                                                          : std::floor(length_m / u_step_m));
  line.u_step_m = line.closed ? (length_m - kClosingGap_m) / static_cast<double>(steps) : u_step_m;
  // Equal chords all round, the last node kClosingGap_m short of the first.
  for (int round = 0; round < 5; ++round) {
    line.x_m.assign(1, spline.at(0.0).x());
    line.y_m.assign(1, spline.at(0.0).y());
    double at_t = 0.0;
    Vector2d here = spline.at(0.0);
    for (std::size_t i = 0; i < steps; ++i) {
      at_t = chord_step(spline, here, at_t, line.u_step_m);
      here = spline.at(at_t);
      line.x_m.push_back(here.x());
      line.y_m.push_back(here.y());
    }
    if (!(at_t > 0.9 * length_t && at_t < 1.1 * length_t)) {
      const Eigen::Vector3d& place = centreline.points_m[sharpest_turn(points, line.closed)];
      return base::Refusal(fmt::format(
          "the centreline turns back on itself, most sharply at ({:.1f}, {:.1f}): a line with "
          "equal "
          "steps cannot follow it; look there at the edges, or at what counts as road (crgbuild "
          "clean writes it)",
          place.x(), place.y()));
    }
    if (!line.closed) break;
    const double rest_m = (length_t - at_t) * spline.derivative(0.0).norm() - kClosingGap_m;
    line.u_step_m += rest_m / static_cast<double>(steps);
    if (std::abs(rest_m) < 1e-9) break;
  }

  set_headings(spline.derivative(0.0), line);
  if (report != nullptr) report_fit(spline, points, t, length_t, model_scale, line, *report);
  for (double& x : line.x_m) x += origin.x();
  for (double& y : line.y_m) y += origin.y();
  return line;
}

crg::ReferenceLine fit_reference_line(const Centreline& centreline,
                                      const ReferenceLineOptions& options,
                                      ReferenceLineReport* report) {
  return try_fit_reference_line(centreline, options, report).or_throw();
}

}  // namespace road
