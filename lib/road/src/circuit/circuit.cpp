#include "road/circuit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "road/error.h"

namespace road {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180.0;

// Legs whose heights differ by more than this do not limit each other: one is a bridge.
constexpr double kLayerHeightM = 4.0;
// Free strip on each side of the middle between two legs, and around the centre of a hairpin.
constexpr double kMiddleMarginM = 0.5;
constexpr double kMiddleStepM = 0.5;
// The tool leaves this gap between the last row of a closed CRG and the first: every reader closes
// it.
constexpr double kSeamGapM = 0.001;
// Beyond, tables of half a metre, splines and spirals take hours; no track is such.
constexpr double kLongestM = 1e5, kMostTurned = 8.0 * std::numbers::pi;
constexpr std::size_t kMostKnots = 1000;

// ---- plan view ---------------------------------------------------------------------------------

struct Pose {
  double x_m, y_m, heading_rad;
};

// 10-point Gauss-Legendre rule on [-1, 1] (Abramowitz & Stegun, table 25.4).
constexpr std::array<double, 5> kGaussNode = {0.1488743389816312, 0.4333953941292472,
                                              0.6794095682990244, 0.8650633666889845,
                                              0.9739065285171717};
constexpr std::array<double, 5> kGaussWeight = {0.2955242247147529, 0.2692667193099963,
                                                0.2190863625159820, 0.1494513491505806,
                                                0.0666713443086881};

/// Pose after `s` metres of a segment: x = integral of cos(heading), heading quadratic in s.
Pose advance(const Pose& start, const PlanSegment& segment, double s_m) {
  const double k0 = segment.curvature_begin_1pm;
  const double rate =
      segment.length_m > 0.0 ? (segment.curvature_end_1pm - k0) / segment.length_m : 0.0;
  const auto heading = [&](double s) { return start.heading_rad + s * (k0 + 0.5 * rate * s); };
  Pose end{start.x_m, start.y_m, heading(s_m)};
  if (rate == 0.0) {
    // sin(a)/a keeps full precision for straights and flat arcs: chord along the mean heading.
    const double half = 0.5 * k0 * s_m;
    const double chord = std::abs(half) < 1e-8 ? s_m : s_m * std::sin(half) / half;
    end.x_m += chord * std::cos(start.heading_rad + half);
    end.y_m += chord * std::sin(start.heading_rad + half);
    return end;
  }
  const double turned =
      s_m * std::max(std::abs(k0), std::abs(k0 + rate * s_m));  // bound on the heading change
  const int panels = 1 + static_cast<int>(turned / 0.5);
  const double panel = s_m / panels;
  for (int i = 0; i < panels; ++i) {
    const double middle = (i + 0.5) * panel;
    double dx = 0.0;
    double dy = 0.0;
    for (std::size_t k = 0; k < kGaussNode.size(); ++k) {
      for (const double sign : {-1.0, 1.0}) {
        const double angle = heading(middle + sign * 0.5 * panel * kGaussNode[k]);
        dx += kGaussWeight[k] * std::cos(angle);
        dy += kGaussWeight[k] * std::sin(angle);
      }
    }
    end.x_m += 0.5 * panel * dx;
    end.y_m += 0.5 * panel * dy;
  }
  return end;
}

double heading_change(const PlanSegment& segment) {
  return 0.5 * (segment.curvature_begin_1pm + segment.curvature_end_1pm) * segment.length_m;
}

Pose end_of_plan(const CircuitDesign& design) {
  Pose pose{design.start_x_m, design.start_y_m, design.start_heading_rad};
  for (const PlanSegment& segment : design.plan) pose = advance(pose, segment, segment.length_m);
  return pose;
}

void check_plan(const CircuitDesign& design) {
  if (design.plan.empty()) throw Error(design.name + ": plan is empty; give at least one segment");
  const std::size_t n = design.plan.size();
  for (std::size_t i = 0; i < n; ++i) {
    const PlanSegment& segment = design.plan[i];
    if (!std::isfinite(segment.length_m) || segment.length_m < 0.0 ||
        (segment.length_m == 0.0 && !segment.solve_length)) {
      throw Error(fmt::format("{}: plan segment {} is {} m long; give a positive length",
                              design.name, i, segment.length_m));
    }
    const double turned = segment.length_m * std::max(std::abs(segment.curvature_begin_1pm),
                                                      std::abs(segment.curvature_end_1pm));
    if (turned > kMostTurned) {
      throw Error(fmt::format("{}: plan segment {} turns up to {:.0f} deg; at most {:.0f} wanted",
                              design.name, i, turned / kDegree, kMostTurned / kDegree));
    }
    if (segment.solve_length &&
        (segment.curvature_begin_1pm != 0.0 || segment.curvature_end_1pm != 0.0)) {
      throw Error(fmt::format("{}: plan segment {} is curved; only straights can be solved for",
                              design.name, i));
    }
    if (i + 1 == n && !design.closed) break;
    const double jump = design.plan[(i + 1) % n].curvature_begin_1pm - segment.curvature_end_1pm;
    if (std::abs(jump) > 1e-9) {
      throw Error(fmt::format(
          "{}: curvature jumps by {:.4g} 1/m after plan segment {}; put a clothoid between",
          design.name, jump, i));
    }
  }
}

/// Heading must come round to a multiple of 360 degrees; two straights then close the position,
/// which is linear in their lengths.
void close_plan(CircuitDesign& design) {
  std::vector<std::size_t> unknown;
  double turned = 0.0;
  for (std::size_t i = 0; i < design.plan.size(); ++i) {
    if (design.plan[i].solve_length) unknown.push_back(i);
    turned += heading_change(design.plan[i]);
  }
  if (!design.closed) {
    if (!unknown.empty()) {
      throw Error(design.name + ": an open plan has nothing to solve for; give every length");
    }
    return;
  }
  const double full_turn = 2.0 * std::numbers::pi;
  const double excess = turned - full_turn * std::round(turned / full_turn);
  if (std::abs(excess) > 1e-9) {
    throw Error(
        fmt::format("{}: the plan turns {:.6f} deg, {:.6f} deg off a multiple of 360; change "
                    "the angle of a corner",
                    design.name, turned / kDegree, excess / kDegree));
  }
  if (!unknown.empty()) {
    if (unknown.size() != 2) {
      throw Error(fmt::format("{}: {} straights are to be solved; two are needed to close a plan",
                              design.name, unknown.size()));
    }
    std::array<double, 2> heading{};
    double angle = design.start_heading_rad;
    for (std::size_t i = 0, k = 0; i < design.plan.size(); ++i) {
      if (k < 2 && i == unknown[k]) heading[k++] = angle;
      angle += heading_change(design.plan[i]);
    }
    for (const std::size_t i : unknown) design.plan[i].length_m = 0.0;
    const Pose end = end_of_plan(design);
    Eigen::Matrix2d direction;
    direction << std::cos(heading[0]), std::cos(heading[1]), std::sin(heading[0]),
        std::sin(heading[1]);
    if (std::abs(direction.determinant()) < 0.02) {
      throw Error(design.name +
                  ": the two straights to be solved are nearly parallel; solve for two "
                  "that are not");
    }
    const Eigen::Vector2d length =
        direction.inverse() *
        Eigen::Vector2d(design.start_x_m - end.x_m, design.start_y_m - end.y_m);
    for (int k = 0; k < 2; ++k) {
      if (!(length[k] > 0.1)) {
        throw Error(
            fmt::format("{}: closing needs plan segment {} to be {:.3f} m long; lengthen the "
                        "straights that run against it",
                        design.name, unknown[static_cast<std::size_t>(k)], length[k]));
      }
      design.plan[unknown[static_cast<std::size_t>(k)]].length_m = length[k];
    }
  }
  const Pose end = end_of_plan(design);
  const double gap = std::hypot(end.x_m - design.start_x_m, end.y_m - design.start_y_m);
  if (gap > 1e-3) {
    throw Error(
        fmt::format("{}: the plan ends {:.3f} m from its start (at most 0.001 m); mark two "
                    "straights `length_m: solve`",
                    design.name, gap));
  }
}

// ---- splines over u ----------------------------------------------------------------------------

/// Cubic Hermite pieces over knots. With a period the last piece leads back to the first knot.
class Spline {
 public:
  Spline() = default;

  /// C2: natural at the ends, or periodic.
  static Spline smooth(const Knots& knots, double period_m) {
    Spline spline(knots, period_m);
    const auto n = static_cast<Eigen::Index>(knots.u_m.size());
    if (n < 2) return spline;
    const bool periodic = period_m > 0.0;
    Eigen::MatrixXd equation = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const bool first = i == 0 && !periodic;
      const bool last = i == n - 1 && !periodic;
      const std::size_t previous = (k + spline.u_.size() - 1) % spline.u_.size();
      const double h0 = first ? 0.0 : spline.step(previous);
      const double h1 = last ? 0.0 : spline.step(k);
      const double d0 = first ? 0.0 : spline.secant(previous);
      const double d1 = last ? 0.0 : spline.secant(k);
      const auto before = static_cast<Eigen::Index>(previous);
      const Eigen::Index after = (i + 1) % n;
      if (first) {  // second derivative 0
        equation(i, i) = 2.0, equation(i, after) = 1.0, right(i) = 3.0 * d1;
      } else if (last) {
        equation(i, i) = 2.0, equation(i, before) = 1.0, right(i) = 3.0 * d0;
      } else {  // equal second derivatives on both sides
        equation(i, before) += h1;
        equation(i, i) += 2.0 * (h0 + h1);
        equation(i, after) += h0;
        right(i) = 3.0 * (h1 * d0 + h0 * d1);
      }
    }
    const Eigen::VectorXd slope = equation.partialPivLu().solve(right);
    spline.slope_.assign(slope.data(), slope.data() + n);
    return spline;
  }

  /// C1 and monotone between knots (Fritsch & Butland 1984): no overshoot.
  static Spline monotone(const Knots& knots, double period_m) {
    Spline spline(knots, period_m);
    const std::size_t n = spline.u_.size();
    if (n < 2) return spline;
    for (std::size_t i = 0; i < n; ++i) {
      if (period_m <= 0.0 && (i == 0 || i == n - 1)) continue;  // level at open ends
      const std::size_t previous = (i + n - 1) % n;
      const double d0 = spline.secant(previous);
      const double d1 = spline.secant(i);
      if (d0 * d1 <= 0.0) continue;
      const double w0 = 2.0 * spline.step(i) + spline.step(previous);
      const double w1 = spline.step(i) + 2.0 * spline.step(previous);
      spline.slope_[i] = (w0 + w1) / (w0 / d0 + w1 / d1);
    }
    return spline;
  }

  double at(double u_m) const {
    const std::size_t n = u_.size();
    if (n == 1) return value_[0];
    const bool periodic = period_m_ > 0.0;
    if (!periodic) u_m = std::clamp(u_m, u_.front(), u_.back());
    const auto above = std::upper_bound(u_.begin(), u_.end(), u_m);
    auto i = static_cast<std::size_t>(above - u_.begin());
    i = i == 0 ? (periodic ? n - 1 : 0) : i - 1;
    if (!periodic && i == n - 1) return value_[i];
    double offset = u_m - u_[i];
    if (offset < 0.0) offset += period_m_;
    const std::size_t next = (i + 1) % n;
    const double h = step(i);
    const double t = offset / h;
    const double s = 1.0 - t;
    return s * s * ((1.0 + 2.0 * t) * value_[i] + t * h * slope_[i]) +
           t * t * ((3.0 - 2.0 * t) * value_[next] - s * h * slope_[next]);
  }

  double largest() const { return *std::max_element(value_.begin(), value_.end()); }

 private:
  Spline(const Knots& knots, double period_m)
      : u_(knots.u_m), value_(knots.value), slope_(u_.size(), 0.0), period_m_(period_m) {}

  double step(std::size_t i) const {
    return i + 1 < u_.size() ? u_[i + 1] - u_[i] : u_[0] + period_m_ - u_[i];
  }
  double secant(std::size_t i) const { return (value_[(i + 1) % u_.size()] - value_[i]) / step(i); }

  std::vector<double> u_, value_, slope_;
  double period_m_ = 0.0;  // 0: open
};

void check_knots(const CircuitDesign& design, const char* what, const Knots& knots, double length_m,
                 double lowest, double highest) {
  if (knots.u_m.empty() || knots.u_m.size() != knots.value.size()) {
    throw Error(fmt::format("{}: {} has {} positions and {} values; give at least one pair",
                            design.name, what, knots.u_m.size(), knots.value.size()));
  }
  if (knots.u_m.size() > kMostKnots) {
    throw Error(fmt::format("{}: {} has {} knots; at most {} wanted", design.name, what,
                            knots.u_m.size(), kMostKnots));
  }
  for (std::size_t i = 0; i < knots.u_m.size(); ++i) {
    const double u = knots.u_m[i];
    if (!(u >= 0.0) || !(u <= length_m) || (design.closed && u >= length_m)) {
      throw Error(fmt::format("{}: {} has a knot at u = {} m; the circuit is {:.3f} m long",
                              design.name, what, u, length_m));
    }
    if (i > 0 && !(u > knots.u_m[i - 1])) {
      throw Error(
          fmt::format("{}: {} has knots at u = {} m and then {} m; give them in ascending order",
                      design.name, what, knots.u_m[i - 1], u));
    }
    if (!(knots.value[i] >= lowest) || !(knots.value[i] <= highest)) {
      throw Error(fmt::format("{}: {} is {} at u = {} m; give {} to {}", design.name, what,
                              knots.value[i], u, lowest, highest));
    }
  }
}

void check_range(const CircuitDesign& design, const char* what, double begin_m, double end_m,
                 double length_m) {
  if (!(begin_m >= 0.0) || !(end_m > begin_m) || !(end_m <= length_m)) {
    throw Error(
        fmt::format("{}: {} from u = {} m to {} m; give 0 <= begin < end <= {:.3f} m (split it "
                    "at the start line)",
                    design.name, what, begin_m, end_m, length_m));
  }
}

}  // namespace

struct Circuit::Data {
  CircuitDesign design;
  std::vector<double> segment_u_m;  // begin of each segment, then the length
  std::vector<Pose> segment_pose;   // at each begin
  double length_m = 0.0;
  double closing_error_m = 0.0;
  Spline width_left, width_right, elevation, banking;
  Spline runoff_left, runoff_right, slope_left, slope_right;
  Roughness roughness;
  // Distance to the middle to the nearest other part of the curve, at u = i * middle_step_m.
  double middle_step_m = 0.0;
  std::vector<double> middle_left_m, middle_right_m;
  // Curve points at u = i * middle_step_m, for the inverse.
  std::vector<crg::Point2> curve;
  double reach_m = 0.0;  // no surface further than this from the curve
};

namespace {

double wrapped(const Circuit::Data& data, double u_m) {
  if (!data.design.closed) return std::clamp(u_m, 0.0, data.length_m);
  const double u = std::fmod(u_m, data.length_m);
  return u < 0.0 ? u + data.length_m : u;
}

ReferencePoint reference(const Circuit::Data& data, double u_m) {
  const double u = wrapped(data, u_m);
  const auto above = std::upper_bound(data.segment_u_m.begin() + 1, data.segment_u_m.end() - 1, u);
  const auto i = static_cast<std::size_t>(above - data.segment_u_m.begin()) - 1;
  const PlanSegment& segment = data.design.plan[i];
  const double s = u - data.segment_u_m[i];
  const Pose pose = advance(data.segment_pose[i], segment, s);
  const double rate = (segment.curvature_end_1pm - segment.curvature_begin_1pm) / segment.length_m;
  return {pose.x_m, pose.y_m, pose.heading_rad, segment.curvature_begin_1pm + rate * s};
}

double middle(const Circuit::Data& data, const std::vector<double>& limit_m, double u_m) {
  const double position = u_m / data.middle_step_m;
  const auto i = std::min(static_cast<std::size_t>(position), limit_m.size() - 1);
  const std::size_t next =
      data.design.closed ? (i + 1) % limit_m.size() : std::min(i + 1, limit_m.size() - 1);
  const double t = position - static_cast<double>(i);
  return (1.0 - t) * limit_m[i] + t * limit_m[next];
}

CrossSection section(const Circuit::Data& data, double u_m) {
  const double u = wrapped(data, u_m);
  CrossSection cross{};
  cross.z_m = data.elevation.at(u);
  cross.banking = data.banking.at(u);
  cross.road_left_m = data.width_left.at(u);
  cross.road_right_m = -data.width_right.at(u);
  cross.outer_left_m = cross.road_left_m + data.runoff_left.at(u);
  cross.outer_right_m = cross.road_right_m - data.runoff_right.at(u);
  const double left = middle(data, data.middle_left_m, u) - kMiddleMarginM;
  const double right = -(middle(data, data.middle_right_m, u) - kMiddleMarginM);
  cross.cut_left = left < cross.outer_left_m;
  cross.cut_right = right > cross.outer_right_m;
  if (cross.cut_left) cross.outer_left_m = left;
  if (cross.cut_right) cross.outer_right_m = right;
  return cross;
}

double kerb_profile(const KerbProfile& profile, double t) {
  const auto above = std::upper_bound(profile.t.begin(), profile.t.end(), t);
  if (above == profile.t.end()) return profile.height.back();
  const auto i = static_cast<std::size_t>(above - profile.t.begin());
  const double share = (t - profile.t[i - 1]) / (profile.t[i] - profile.t[i - 1]);
  return profile.height[i - 1] + share * (profile.height[i] - profile.height[i - 1]);
}

/// 1 in the middle, 0 at distance 1 and beyond.
double bump_window(BumpDesign::Shape shape, double distance) {
  distance = std::abs(distance);
  if (distance >= 1.0) return 0.0;
  if (shape == BumpDesign::Shape::plateau) {
    if (distance <= 0.5) return 1.0;
    distance = 2.0 * (distance - 0.5);
  }
  return 0.5 * (1.0 + std::cos(std::numbers::pi * distance));
}

/// Everything of the surface that depends on u only, so that a row of nodes shares it.
struct Row {
  CrossSection cross;
  double slope_left, slope_right;
  const KerbDesign* kerb_left = nullptr;
  const KerbDesign* kerb_right = nullptr;
  double kerb_left_height_m = 0.0, kerb_right_height_m = 0.0;  // tapered
  std::vector<std::pair<const BumpDesign*, double>> bumps;     // height at this u
};

Row row_at(const Circuit::Data& data, double u_m) {
  const double u = wrapped(data, u_m);
  Row row{};
  row.cross = section(data, u);
  row.slope_left = data.slope_left.at(u);
  row.slope_right = data.slope_right.at(u);
  for (const KerbDesign& kerb : data.design.kerbs) {
    if (u < kerb.u_begin_m || u > kerb.u_end_m) continue;
    const double inside = std::min(u - kerb.u_begin_m, kerb.u_end_m - u);
    const double taper = kerb.taper_m > 0.0 ? std::min(1.0, inside / kerb.taper_m) : 1.0;
    (kerb.side == Side::left ? row.kerb_left : row.kerb_right) = &kerb;
    (kerb.side == Side::left ? row.kerb_left_height_m : row.kerb_right_height_m) =
        taper * kerb.height_m;
  }
  for (const BumpDesign& bump : data.design.bumps) {
    double distance = u - bump.u_m;
    if (data.design.closed) distance = std::remainder(distance, data.length_m);
    const double share = bump_window(bump.shape, distance / (0.5 * bump.length_m));
    if (share > 0.0) row.bumps.emplace_back(&bump, share * bump.height_m);
  }
  return row;
}

double outside(double edge_distance_m, double slope, const KerbDesign* kerb, double kerb_height_m) {
  double height = slope * edge_distance_m;
  if (kerb && edge_distance_m < kerb->width_m) {
    height += kerb_height_m * kerb_profile(kerb->profile, edge_distance_m / kerb->width_m);
  }
  return height;
}

/// All but the roughness. v on the border counts as inside.
double smooth_height(const Row& row, double v) {
  constexpr double kBorderM = 1e-9;
  const CrossSection& cross = row.cross;
  if (!(v >= cross.outer_right_m - kBorderM) || !(v <= cross.outer_left_m + kBorderM)) return kNaN;
  double z = cross.z_m + cross.banking * v;
  if (v > cross.road_left_m) {
    z += outside(v - cross.road_left_m, row.slope_left, row.kerb_left, row.kerb_left_height_m);
  } else if (v < cross.road_right_m) {
    z += outside(cross.road_right_m - v, row.slope_right, row.kerb_right, row.kerb_right_height_m);
  }
  for (const auto& [bump, height] : row.bumps) {
    z += bump->width_m > 0.0
             ? height * bump_window(bump->shape, (v - bump->v_m) / (0.5 * bump->width_m))
             : height;
  }
  return z;
}

/// Radius of the circle that touches the curve at `at` on the given side and passes through
/// `other`: its centre is the middle between the two.
double middle_radius(const crg::Point2& at, double normal_x, double normal_y,
                     const crg::Point2& other) {
  const double dx = other.x_m - at.x_m;
  const double dy = other.y_m - at.y_m;
  const double towards = dx * normal_x + dy * normal_y;
  return towards > 0.0 ? (dx * dx + dy * dy) / (2.0 * towards)
                       : std::numeric_limits<double>::infinity();
}

void find_middles(Circuit::Data& data) {
  const auto count = static_cast<std::size_t>(std::ceil(data.length_m / kMiddleStepM)) +
                     (data.design.closed ? 0 : 1);
  const std::size_t intervals = data.design.closed ? count : count - 1;
  data.middle_step_m = data.length_m / static_cast<double>(intervals);
  data.reach_m = std::max(data.width_left.largest() + data.runoff_left.largest(),
                          data.width_right.largest() + data.runoff_right.largest());
  std::vector<ReferencePoint> points(count);
  std::vector<double> z(count);
  data.curve.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double u = static_cast<double>(i) * data.middle_step_m;
    points[i] = reference(data, u);
    z[i] = data.elevation.at(u);
    data.curve[i] = {points[i].x_m, points[i].y_m};
  }
  const double far = 2.0 * (data.reach_m + kMiddleMarginM);
  data.middle_left_m.assign(count, far);
  data.middle_right_m.assign(count, far);
  for (std::size_t i = 0; i < count; ++i) {
    const double nx = -std::sin(points[i].heading_rad);
    const double ny = std::cos(points[i].heading_rad);
    const double bend = points[i].curvature_1pm;
    double& left = data.middle_left_m[i];
    double& right = data.middle_right_m[i];
    if (bend > 0.0) left = std::min(left, 1.0 / bend);
    if (bend < 0.0) right = std::min(right, -1.0 / bend);
    for (std::size_t j = 0; j < count;) {
      const double dx = data.curve[j].x_m - data.curve[i].x_m;
      const double dy = data.curve[j].y_m - data.curve[i].y_m;
      const double distance = std::hypot(dx, dy);
      if (distance > far) {  // the curve cannot come back within `far` sooner
        j += std::max<std::size_t>(1,
                                   static_cast<std::size_t>((distance - far) / data.middle_step_m));
        continue;
      }
      if (j != i && std::abs(z[j] - z[i]) < kLayerHeightM) {
        left = std::min(left, middle_radius(data.curve[i], nx, ny, data.curve[j]));
        right = std::min(right, middle_radius(data.curve[i], -nx, -ny, data.curve[j]));
      }
      ++j;
    }
    const double u = static_cast<double>(i) * data.middle_step_m;
    for (const auto& [limit, edge, side] : {std::tuple{left, data.width_left.at(u), "left"},
                                            std::tuple{right, data.width_right.at(u), "right"}}) {
      if (edge + kMiddleMarginM >= limit) {
        throw Error(
            fmt::format("{}: at u = {:.1f} m the road is {:.2f} m wide on the {} but meets "
                        "another part of itself after {:.2f} m; widen the bend or move the legs "
                        "apart (a bridge needs {} m of height)",
                        data.design.name, u, edge, side, limit, kLayerHeightM));
      }
    }
  }
}

void check_features(const CircuitDesign& design, double length_m) {
  for (std::size_t i = 0; i < design.kerbs.size(); ++i) {
    const KerbDesign& kerb = design.kerbs[i];
    const std::string what = fmt::format("kerb {}", i);
    check_range(design, what.c_str(), kerb.u_begin_m, kerb.u_end_m, length_m);
    const KerbProfile& profile = kerb.profile;
    if (profile.t.size() < 2 || profile.t.size() != profile.height.size() ||
        profile.t.front() != 0.0 || profile.t.back() != 1.0 || profile.height.front() != 0.0 ||
        profile.height.back() != 0.0 ||
        std::adjacent_find(profile.t.begin(), profile.t.end(), std::greater_equal<>()) !=
            profile.t.end()) {
      throw Error(
          fmt::format("{}: {} needs a profile with t ascending from 0 to 1 and height 0 at both "
                      "ends",
                      design.name, what));
    }
    if (!(kerb.width_m > 0.0) || !(kerb.taper_m >= 0.0) ||
        2.0 * kerb.taper_m > kerb.u_end_m - kerb.u_begin_m) {
      throw Error(fmt::format(
          "{}: {} has width {} m and tapers of {} m on {} m; give a positive width and "
          "tapers that fit",
          design.name, what, kerb.width_m, kerb.taper_m, kerb.u_end_m - kerb.u_begin_m));
    }
    for (std::size_t j = 0; j < i; ++j) {
      const KerbDesign& other = design.kerbs[j];
      if (other.side == kerb.side && kerb.u_begin_m < other.u_end_m + 0.5 &&
          other.u_begin_m < kerb.u_end_m + 0.5) {
        throw Error(
            fmt::format("{}: kerbs {} and {} on the same side overlap or are closer than 0.5 m",
                        design.name, j, i));
      }
    }
  }
  for (const BumpDesign& bump : design.bumps) {
    if (!(bump.length_m > 0.0) || !(bump.width_m >= 0.0) || !(bump.u_m >= 0.0) ||
        !(bump.u_m <= length_m)) {
      throw Error(
          fmt::format("{}: bump at u = {} m, {} m long and {} m wide; give 0 <= u <= {:.3f} and a "
                      "positive length",
                      design.name, bump.u_m, bump.length_m, bump.width_m, length_m));
    }
  }
  for (const BarrierDesign& item : design.barriers) {
    check_range(design, "barrier", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const TreeRow& item : design.trees) {
    check_range(design, "tree row", item.u_begin_m, item.u_end_m, length_m);
    if (!(item.spacing_m > 0.5)) {
      throw Error(
          fmt::format("{}: trees every {} m; give more than 0.5 m", design.name, item.spacing_m));
    }
  }
  for (const Grandstand& item : design.grandstands) {
    check_range(design, "grandstand", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const BridgeDesign& item : design.bridges) {
    check_range(design, "bridge", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const StartStrip& item : design.start_strips) {
    check_range(design, "start strip", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const Gantry& item : design.gantries) {
    check_range(design, "gantry", item.u_m, item.u_m + item.length_m, length_m);
  }
}

}  // namespace

Circuit::Circuit(CircuitDesign design) {
  auto data = std::make_shared<Data>();
  check_plan(design);
  close_plan(design);
  Pose pose{design.start_x_m, design.start_y_m, design.start_heading_rad};
  double u = 0.0;
  for (const PlanSegment& segment : design.plan) {
    data->segment_u_m.push_back(u);
    data->segment_pose.push_back(pose);
    pose = advance(pose, segment, segment.length_m);
    u += segment.length_m;
  }
  data->segment_u_m.push_back(u);
  data->length_m = u;
  if (u > kLongestM) {
    throw Error(fmt::format("{}: the plan is {:.0f} m long; at most {:.0f} m wanted", design.name,
                            u, kLongestM));
  }
  if (design.closed) {
    data->closing_error_m = std::hypot(pose.x_m - design.start_x_m, pose.y_m - design.start_y_m);
  }

  const double period = design.closed ? u : 0.0;
  check_knots(design, "width_left", design.width_left_m, u, 1.0, 30.0);
  check_knots(design, "width_right", design.width_right_m, u, 1.0, 30.0);
  check_knots(design, "elevation", design.elevation_m, u, -9000.0, 9000.0);
  check_knots(design, "banking", design.banking, u, -1.0, 1.0);
  check_knots(design, "runoff_left", design.runoff_left_m, u, 0.0, 100.0);
  check_knots(design, "runoff_right", design.runoff_right_m, u, 0.0, 100.0);
  check_knots(design, "runoff_slope_left", design.runoff_slope_left, u, -1.0, 1.0);
  check_knots(design, "runoff_slope_right", design.runoff_slope_right, u, -1.0, 1.0);
  check_features(design, u);
  data->width_left = Spline::monotone(design.width_left_m, period);
  data->width_right = Spline::monotone(design.width_right_m, period);
  data->elevation = Spline::smooth(design.elevation_m, period);
  data->banking = Spline::monotone(design.banking, period);
  data->runoff_left = Spline::monotone(design.runoff_left_m, period);
  data->runoff_right = Spline::monotone(design.runoff_right_m, period);
  data->slope_left = Spline::monotone(design.runoff_slope_left, period);
  data->slope_right = Spline::monotone(design.runoff_slope_right, period);
  if (design.roughness) data->roughness = Roughness(*design.roughness, u);
  data->design = std::move(design);
  find_middles(*data);

  for (std::size_t i = 0; i < data->design.kerbs.size(); ++i) {
    const KerbDesign& kerb = data->design.kerbs[i];
    const auto checks = static_cast<int>((kerb.u_end_m - kerb.u_begin_m) / kMiddleStepM);
    for (int k = 0; k <= checks; ++k) {
      const double at = kerb.u_begin_m + k * kMiddleStepM;
      const CrossSection cross = section(*data, at);
      const double room = kerb.side == Side::left ? cross.outer_left_m - cross.road_left_m
                                                  : cross.road_right_m - cross.outer_right_m;
      if (kerb.width_m > room - 0.05) {
        throw Error(
            fmt::format("{}: kerb {} is {} m wide but the run-off at u = {:.1f} m only {:.2f} m; "
                        "leave 0.05 m",
                        data->design.name, i, kerb.width_m, at, room));
      }
    }
  }
  data_ = std::move(data);
}

const CircuitDesign& Circuit::design() const noexcept { return data_->design; }
double Circuit::length_m() const noexcept { return data_->length_m; }
double Circuit::closing_error_m() const noexcept { return data_->closing_error_m; }

ReferencePoint reference_at(const Circuit& circuit, double u_m) {
  return reference(circuit.data(), u_m);
}

CrossSection section_at(const Circuit& circuit, double u_m) { return section(circuit.data(), u_m); }

crg::Point2 position_at(const Circuit& circuit, double u_m, double v_m) {
  const ReferencePoint point = reference(circuit.data(), u_m);
  return {point.x_m - v_m * std::sin(point.heading_rad),
          point.y_m + v_m * std::cos(point.heading_rad)};
}

double true_height(const Circuit& circuit, double u_m, double v_m) {
  const Circuit::Data& data = circuit.data();
  const double u = wrapped(data, u_m);
  const double smooth = smooth_height(row_at(data, u), v_m);
  return std::isnan(smooth) ? smooth : smooth + data.roughness.height_m(u, v_m);
}

std::optional<SurfaceClass> true_class(const Circuit& circuit, double u_m, double v_m) {
  const Row row = row_at(circuit.data(), u_m);
  const CrossSection& cross = row.cross;
  if (!(v_m >= cross.outer_right_m) || !(v_m <= cross.outer_left_m)) return std::nullopt;
  if (v_m <= cross.road_left_m && v_m >= cross.road_right_m) return SurfaceClass::road;
  const bool left = v_m > 0.0;
  const KerbDesign* kerb = left ? row.kerb_left : row.kerb_right;
  const double distance = left ? v_m - cross.road_left_m : cross.road_right_m - v_m;
  return kerb && distance <= kerb->width_m ? SurfaceClass::kerb : SurfaceClass::runoff;
}

std::vector<CircuitUV> uv_of_position(const Circuit& circuit, double x_m, double y_m) {
  const Circuit::Data& data = circuit.data();
  const bool closed = data.design.closed;
  const std::size_t count = data.curve.size();
  const double near = data.reach_m + data.middle_step_m;
  // The foot points are the zeros of (point - curve) . tangent that fall with u.
  const auto along = [&](double u) {
    const ReferencePoint point = reference(data, u);
    return (x_m - point.x_m) * std::cos(point.heading_rad) +
           (y_m - point.y_m) * std::sin(point.heading_rad);
  };
  std::vector<CircuitUV> found;
  for (std::size_t i = 0; i < (closed ? count : count - 1);) {
    const double distance = std::hypot(x_m - data.curve[i].x_m, y_m - data.curve[i].y_m);
    if (distance > near) {
      i += std::max<std::size_t>(1,
                                 static_cast<std::size_t>((distance - near) / data.middle_step_m));
      continue;
    }
    double low = static_cast<double>(i) * data.middle_step_m;
    double high = std::min(static_cast<double>(i + 1) * data.middle_step_m, data.length_m);
    ++i;
    double at_low = along(low);
    double at_high = along(high);
    if (!(at_low >= 0.0) || !(at_high < 0.0 || (at_high == 0.0 && !closed && i + 1 == count)))
      continue;
    double u = low;
    for (int step = 0; step < 100 && high - low > 1e-12 * (1.0 + data.length_m); ++step) {
      // Regula falsi (Illinois) with bisection every third step.
      u = step % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
      const double at = along(u);
      if (at == 0.0) break;
      if (at > 0.0) {
        low = u, at_low = at;
      } else {
        high = u, at_high = at;
      }
    }
    const ReferencePoint foot = reference(data, u);
    const double v = -(x_m - foot.x_m) * std::sin(foot.heading_rad) +
                     (y_m - foot.y_m) * std::cos(foot.heading_rad);
    const CrossSection cross = section(data, u);
    if (v >= cross.outer_right_m - 1e-9 && v <= cross.outer_left_m + 1e-9) found.push_back({u, v});
  }
  return found;
}

crg::Crg truth_crg(const Circuit& circuit, double step_m) {
  const Circuit::Data& data = circuit.data();
  if (!(step_m >= 0.01) || !(step_m <= data.length_m / 2)) {
    throw Error(
        fmt::format("truth step is {} m; give 0.01 to {:.1f} m", step_m, data.length_m / 2));
  }
  const double length = data.length_m - (data.design.closed ? kSeamGapM : 0.0);
  const auto rows = static_cast<std::size_t>(std::ceil(length / step_m - 1e-9)) + 1;
  crg::ReferenceLine line;
  line.u_step_m = length / static_cast<double>(rows - 1);
  line.closed = data.design.closed;
  std::vector<double> u(rows);
  double right = 0.0;
  double left = 0.0;
  for (std::size_t i = 0; i < rows; ++i) {
    u[i] = static_cast<double>(i) * line.u_step_m;
    const ReferencePoint point = reference(data, u[i]);
    line.x_m.push_back(point.x_m);
    line.y_m.push_back(point.y_m);
    line.heading_rad.push_back(
        i == 0 ? point.heading_rad
               : std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]));
    const CrossSection cross = section(data, u[i]);
    right = std::min(right, cross.outer_right_m);
    left = std::max(left, cross.outer_left_m);
  }
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  const auto first = static_cast<int>(std::ceil(right / step_m));
  const auto last = static_cast<int>(std::floor(left / step_m));
  for (int k = first; k <= last; ++k) grid.v_m.push_back(k * step_m);
  const std::size_t columns = grid.v_m.size();
  grid.z_m.resize(rows * columns);
  constexpr std::size_t kBlock = 256;  // bounds the memory for roughness in double
  std::vector<double> z;
  for (std::size_t begin = 0; begin < rows; begin += kBlock) {
    const std::size_t end = std::min(rows, begin + kBlock);
    z.assign((end - begin) * columns, 0.0);
    for (std::size_t i = begin; i < end; ++i) {
      const Row row = row_at(data, u[i]);
      for (std::size_t j = 0; j < columns; ++j) {
        z[(i - begin) * columns + j] = smooth_height(row, grid.v_m[j]);
      }
    }
    data.roughness.add_grid(std::span(u).subspan(begin, end - begin), grid.v_m, z);
    for (std::size_t k = 0; k < z.size(); ++k) {
      grid.z_m[begin * columns + k] = static_cast<float>(z[k]);
    }
  }
  if (data.design.closed) {
    std::copy_n(grid.z_m.begin(), columns, grid.z_m.end() - static_cast<std::ptrdiff_t>(columns));
  }
  return crg::make_crg(line, std::move(grid),
                       {"Exact heights of the circuit '" + data.design.name + "'"});
}

}  // namespace road
