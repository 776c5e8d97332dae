#include "car_motion.h"

#include <ceres/jet.h>

#include <cmath>

namespace identify {
namespace {

using vehicle::kWheels;
using Jet = ceres::Jet<double, kMovingPlaces>;
using P = vehicle::Parameter;

vehicle::Car<Jet> lifted(const vehicle::Car<double>& car) {
  vehicle::Parameters<Jet> p;
  for (std::size_t i = 0; i < vehicle::kParameterCount; ++i)
    p.value[i] = Jet(car.parameters.value[i]);
  vehicle::Amplitudes<Jet> terms;
  for (std::size_t i = 0; i < vehicle::kTermCount; ++i) terms.value[i] = Jet(car.terms.value[i]);
  vehicle::Car<Jet> out = vehicle::make_car(*car.files, p, terms, car.contact, car.strip);
  out.tyre_options = car.tyre_options;
  return out;
}

/// A point whose every place has the derivative 1 by itself.
struct JetPoint {
  vehicle::State<Jet> state;
  std::array<Jet, kMovingPlaces - kPlaceSteer> more;

  explicit JetPoint(const CarPoint& p) {
    for (std::size_t i = 0; i < vehicle::kStateSize; ++i) state[i] = Jet(p.state[i]);
    for (std::size_t i = 0; i < kPlaceSteer; ++i)
      state[kEstimatedStates[i]].v[static_cast<Eigen::Index>(i)] = 1.0;
    for (std::size_t i = kPlaceSteer; i < kMovingPlaces; ++i)
      at(i) = Jet(p.at(i), static_cast<int>(i));
  }
  Jet& at(std::size_t place) {
    return place < kPlaceSteer ? state[kEstimatedStates[place]] : more[place - kPlaceSteer];
  }
};

/// The car that differs from the vehicle file as the point says; `lifted` is the stated one.
template <class T, class Point>
vehicle::Car<T> car_at(const vehicle::Car<T>& lifted, Point& x) {
  vehicle::Parameters<T> p = lifted.parameters;
  for (std::size_t i = 0; i < kStated.size(); ++i)
    p[kStated[i].parameter] *= 1.0 + x.at(kPlaceStated + i);
  vehicle::Car<T> out = vehicle::make_car(*lifted.files, p, lifted.terms);
  out.contact = lifted.contact;
  out.strip = lifted.strip;
  out.cams = lifted.cams;
  out.tyre_options = lifted.tyre_options;
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    const P part = kParts[i].parameter;
    out.parameters[part] = lifted.parameters[part] * (1.0 + x.at(kPlaceParts + i));
  }
  return out;
}

template <class T, class Point>
vehicle::Inputs<T> inputs_of(Point& x, double later_s, const Driven& driven) {
  const auto foot = [&](std::size_t place) -> T {
    return x.at(place) + later_s * driven.feet_per_s[place - kPlaceThrottle];
  };
  vehicle::Inputs<T> in;
  in.steer_rad = x.at(kPlaceSteer) + later_s * x.at(kPlaceSteerRate);
  in.steer_rate_radps = x.at(kPlaceSteerRate);
  in.throttle = foot(kPlaceThrottle);
  if (in.throttle < T(0.0)) in.throttle = T(0.0);
  if (in.throttle > T(1.0)) in.throttle = T(1.0);
  for (std::size_t i = 0; i < kWheels; ++i) in.brake_pa[i] = foot(kPlaceBrake + i);
  in.gear = driven.gear;
  in.next_gear = driven.gear == 0 ? driven.next_gear : 0;
  return in;
}

/// What the accelerometer measures, in its own axes.
vehicle::Vec3<Jet> felt(const vehicle::State<Jet>& s, const vehicle::State<Jet>& rate,
                        const vehicle::Detail<Jet>& detail, const ImuPlace& imu) {
  const vehicle::Vec3<Jet> arm{Jet(imu.ahead_m), Jet(0.0), Jet(0.0)};
  const vehicle::Vec3<Jet> omega{s[vehicle::kRollRate], s[vehicle::kPitchRate],
                                 s[vehicle::kYawRate]};
  const vehicle::Vec3<Jet> turning{rate[vehicle::kRollRate], rate[vehicle::kPitchRate],
                                   rate[vehicle::kYawRate]};
  const vehicle::Vec3<Jet> f =
      detail.specific_force_mps2 + cross(turning, arm) + cross(omega, cross(omega, arm));
  const double c = std::cos(imu.yaw_rad), n = std::sin(imu.yaw_rad);
  return {c * f.x + n * f.y, c * f.y - n * f.x, f.z};
}

template <class T>
bool sane(const vehicle::State<T>& s) {
  using vehicle::value_of;
  for (std::size_t i = 0; i < vehicle::kStateSize; ++i)
    if (!std::isfinite(value_of(s[i]))) return false;
  return std::abs(value_of(s[vehicle::kVx])) < 200.0 &&
         std::abs(value_of(s[vehicle::kVy])) < 100.0 &&
         std::abs(value_of(s[vehicle::kRoll])) < 1.0 &&
         std::abs(value_of(s[vehicle::kPitch])) < 1.0;
}

/// The time between two rows, in equal steps of at most `most_step_s`.
struct Span {
  double dt_s, most_step_s;
  const Driven& driven;
};

/// Moves the states of the car on; false where it lost the road or ran away.
template <class T, class Point>
bool drive(const vehicle::Car<T>& car, const vehicle::Road& road, const Span& span, Point& x,
           vehicle::RoadCursors& cursors) {
  const int steps = std::max(1, static_cast<int>(std::ceil(span.dt_s / span.most_step_s - 1e-9)));
  vehicle::StepOptions step;
  step.step_s = span.dt_s / steps;
  vehicle::State<T> rate;
  vehicle::Detail<T> detail;
  for (int k = 0; k < steps; ++k) {
    const vehicle::Inputs<T> in = inputs_of<T>(x, (k + 0.5) * step.step_s, span.driven);
    vehicle::derivative(car, x.state, in, road, cursors, rate, detail);
    for (const auto& wheel : detail.wheel)
      if (!std::isfinite(wheel.road.z_m)) return false;
    vehicle::settle_frictions(car, step.step_s, rate, detail);
    if (car.files->turbo == vehicle::Turbo::kFull) vehicle::settle_air(step.step_s, rate, detail);
    vehicle::integrate(car, x.state, rate, detail, step);
    if (!sane(x.state)) return false;
  }
  return true;
}

/// What of a part is left of its difference from its rest after `dt_s`.
double kept_of_parts(double dt_s) { return std::exp(-dt_s / kForgetPart_s); }

/// What is not a state of the car, at the end of `dt_s`; `before` has what parts return to.
template <class T, class Point>
void move_rest(Point& x, double dt_s, const Driven& driven, const CarPoint& before) {
  x.at(kPlaceSteer) += dt_s * x.at(kPlaceSteerRate);
  x.at(kPlaceSteerRate) *= std::exp(-dt_s / kForgetSteer_s);
  for (std::size_t i = kPlaceThrottle; i < kPlaceParts; ++i)
    x.at(i) += dt_s * driven.feet_per_s[i - kPlaceThrottle];
  const double kept = kept_of_parts(dt_s);
  for (std::size_t i = kPlaceParts; i < kChangingPlaces; ++i)
    x.at(i) = kept * x.at(i) + T((1.0 - kept) * before.at(rest_of(i)));
}

}  // namespace

struct CarMotion::Inside {
  const vehicle::Car<double>& stated;
  const vehicle::Road& road;
  double most_step_s;
  ImuPlace imu;
  vehicle::Car<Jet> car;
};

CarMotion::CarMotion(const vehicle::Car<double>& car, const vehicle::Road& road, double most_step_s,
                     const ImuPlace& imu)
    : in_(std::make_unique<Inside>(Inside{car, road, most_step_s, imu, lifted(car)})) {}

CarMotion::~CarMotion() = default;

bool CarMotion::move(CarPoint& point, double dt_s, const Driven& driven,
                     vehicle::RoadCursors& cursors, StepMatrix& by) const {
  JetPoint x(point);
  const vehicle::Car<Jet> slow = car_at(in_->car, x);
  if (!drive(slow, in_->road, {dt_s, in_->most_step_s, driven}, x, cursors)) return false;
  move_rest<Jet>(x, dt_s, driven, point);
  by.setZero();
  for (std::size_t i = 0; i < kChangingPlaces; ++i)
    by.row(static_cast<Eigen::Index>(i)).head<kMovingPlaces>() = x.at(i).v.transpose();
  constexpr auto kCount = static_cast<Eigen::Index>(kChangingPlaces - kPlaceParts);
  by.block<kCount, kCount>(kPlaceParts, kPlaceRest)
      .diagonal()
      .setConstant(1.0 - kept_of_parts(dt_s));

  const vehicle::Car<double> car = car_at(in_->stated, point);
  const double fine_s = std::min(in_->most_step_s, kFineStep_s);
  if (!drive(car, in_->road, {dt_s, fine_s, driven}, point, cursors)) return false;
  move_rest<double>(point, dt_s, driven, point);
  return by.allFinite();
}

Seen CarMotion::look(const CarPoint& point, int gear, vehicle::RoadCursors& cursors) const {
  using std::atan;
  JetPoint x(point);
  const vehicle::Car<Jet> car = car_at(in_->car, x);
  vehicle::State<Jet> rate;
  vehicle::Detail<Jet> d;
  vehicle::derivative(car, x.state, inputs_of<Jet>(x, 0.0, {gear, 0, {}}), in_->road, cursors, rate,
                      d);
  Seen out;
  const auto put = [&](std::size_t place, const Jet& value) {
    out.value[place] = value.a;
    out.by.row(static_cast<Eigen::Index>(place)) = value.v.transpose();
  };
  const vehicle::Vec3<Jet> f = felt(x.state, rate, d, in_->imu);
  put(kSeenAx, f.x);
  put(kSeenAy, f.y);
  put(kSeenAz, f.z);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const vehicle::WheelDetail<Jet>& w = d.wheel[i];
    put(seen_of(i, kSeenFx), w.fx_n);
    put(seen_of(i, kSeenFy), w.fy_n);
    put(seen_of(i, kSeenFz), w.fz_n);
    put(seen_of(i, kSeenKappa), w.kappa);
    put(seen_of(i, kSeenAlpha), atan(w.tan_alpha));
    put(seen_of(i, kSeenCamber), w.camber_rad);
    // By the slips that the tyre feels: what its tread stores and gives back is no loss.
    put(seen_of(i, kSeenPower), abs(w.vx_mps) * (w.fx_n * w.kappa - w.fy_n * w.tan_alpha));
    out.wheel_vx_mps[i] = w.vx_mps.a;
    out.rolling_radius_m[i] = w.rolling_radius_m.a;
    out.on_road = out.on_road && w.road.on_road;
  }
  return out;
}

CarPoint CarMotion::begin(const vehicle::StartOptions& options,
                          vehicle::RoadCursors& cursors) const {
  vehicle::Simulation<double> sim = vehicle::start(in_->stated, in_->road, options);
  cursors = sim.cursors;
  CarPoint out;
  out.state = sim.state;
  return out;
}

}  // namespace identify
