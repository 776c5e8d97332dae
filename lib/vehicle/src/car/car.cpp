#include "vehicle/car.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/error.h"

namespace vehicle {

Cams make_cams(const StripShape& strip, double unloaded_radius_m, double patch_length_m) {
  if (strip.along < 3 || strip.across < 2 || strip.along > StripShape::kMostAlong ||
      strip.along * strip.across > StripShape::kMostSamples || !(strip.step_m > 0.0) ||
      !(strip.cam_order > 1.0) || !(strip.cam_shift > 0.0))
    throw Error(
        fmt::format("a strip of {} x {} samples, {} m apart, cam order {}, shift {}; wanted 3 x 2 "
                    "to {} samples, a positive distance, an order above 1, a positive shift",
                    strip.along, strip.across, strip.step_m, strip.cam_order, strip.cam_shift,
                    StripShape::kMostSamples));
  Cams out;
  // Cams stand over rows of samples, so that both see a plane alike.
  out.distance_m =
      2.0 * strip.step_m *
      std::max(1.0, std::round(strip.cam_shift * patch_length_m / (2.0 * strip.step_m)));
  const double half = 0.5 * static_cast<double>(strip.along - 1) * strip.step_m;
  const auto clearance = [&](double x) {
    const double share = std::abs(x) / unloaded_radius_m;
    if (share >= 1.0) return 1e9;
    return unloaded_radius_m *
           (1.0 - std::pow(1.0 - std::pow(share, strip.cam_order), 1.0 / strip.cam_order));
  };
  for (std::size_t i = 0; i < strip.along; ++i) {
    const double x = static_cast<double>(i) * strip.step_m - half;
    out.front[i] = static_cast<float>(clearance(x - 0.5 * out.distance_m));
    out.rear[i] = static_cast<float>(clearance(x + 0.5 * out.distance_m));
  }
  constexpr float kNear_m = 0.01f;  // an even road lifts no sample further than that
  const auto low = [&](const auto& cam) {
    return std::max(kNear_m, *std::min_element(cam.begin(), cam.begin() + strip.along));
  };
  const float front = low(out.front), rear = low(out.rear);
  const auto near = [&](std::size_t i) { return out.front[i] <= front || out.rear[i] <= rear; };
  out.near_end = strip.along;
  while (!near(out.near_begin)) ++out.near_begin;
  while (!near(out.near_end - 1)) --out.near_end;
  return out;
}

namespace {

/// The map of a rack can be gone back, has straight ahead within it, and is not scaled twice.
void check_rack(const Map1& rack, double ratio) {
  check_map(rack, "steering map");
  if (rack.empty()) return;
  if (rack.x.size() < 2) throw Error("steering map: one place, wanted at least two places");
  for (std::size_t i = 1; i < rack.y.size(); ++i)
    if (!(rack.y[i] > rack.y[i - 1]))
      throw Error(
          fmt::format("steering map: steer_rad must ascend; value {} is {}, the one before {}",
                      i + 1, rack.y[i], rack.y[i - 1]));
  if (!(rack.x.front() < 0.0 && rack.x.back() > 0.0 && rack.y.front() < 0.0 && rack.y.back() > 0.0))
    throw Error("steering map: wanted places left and right of straight ahead, 0 between them");
  if (!(ratio >= 0.5 && ratio <= 2.0))
    throw Error(fmt::format(
        "steering.ratio = {} beside a steering map, which has the ratio already; wanted 0.5 to 2 "
        "(1: as mapped)",
        ratio));
  for (const double end : {rack.y.front(), rack.y.back()})
    if (!(std::abs(end / ratio) < 1.5))
      throw Error(fmt::format(
          "steering map: steer_rad = {} over steering.ratio = {}, wanted less than a right angle",
          end, ratio));
}

/// Every map there is has axes and values that can be.
void check_maps(const CarFiles& files) {
  if (files.engine_torque_nm.empty()) throw Error("the car has no engine map");
  check_map(files.engine_torque_nm, "engine map");
  check_map(files.damper_n[0], "front damper map");
  check_map(files.damper_n[1], "rear damper map");
  check_map(files.drag_factor, "drag map");
  check_map(files.front_lift_factor, "front lift map");
  check_map(files.rear_lift_factor, "rear lift map");
  check_map(files.yaw_drag_factor, "drag over yaw map");
  check_map(files.yaw_lift_factor, "lift over yaw map");
  check_map(files.wake_drag_factor, "slipstream drag map");
  check_map(files.wake_lift_factor, "slipstream lift map");
  check_map(files.tyre_grip, "tyre grip map");
  check_map(files.pad_friction, "pad friction map");
  check_map(files.compressor_kgps, "compressor flow map");
  check_map(files.compressor_efficiency, "compressor efficiency map");
  check_map(files.compressor_surge_kgps, "compressor surge line");
  check_map(files.turbine_flow, "turbine flow map");
  check_map(files.turbine_efficiency, "turbine efficiency map");
  const auto within = [](const std::vector<double>& values, double low, double high,
                         const char* what) {
    for (const double value : values)
      if (!(value >= low && value <= high))
        throw Error(fmt::format("{}: {}, wanted {:g} to {:g}", what, value, low, high));
  };
  within(files.tyre_grip.y, 0.0, 2.0, "tyre grip map");
  within(files.compressor_efficiency.z, 0.05, 1.0, "compressor efficiency map");
  within(files.turbine_efficiency.z, 0.0, 1.0, "turbine efficiency map");
  // 0.5: a nozzle of 4 mm; a map in kg sqrt(K)/(s kPa) lies below it.
  within(files.turbine_flow.z, 0.0, 500.0, "turbine flow map");
  if (const auto& flow = files.turbine_flow.z;
      !flow.empty() && !(*std::max_element(flow.begin(), flow.end()) > 0.5))
    throw Error(fmt::format(
        "turbine flow map: at most {}, wanted above 0.5; its unit is kg sqrt(K)/(s MPa)",
        *std::max_element(flow.begin(), flow.end())));
}

}  // namespace

void check_car(const CarFiles& files, const Parameters<double>& p,
               const Amplitudes<double>& terms) {
  using P = Parameter;
  const auto list = parameter_list();
  for (std::size_t i = 0; i < kParameterCount; ++i)
    if (!(p.value[i] >= list[i].low && p.value[i] <= list[i].high))
      throw Error(fmt::format("{} = {} {}, wanted {} to {}", list[i].name, p.value[i], list[i].unit,
                              list[i].low, list[i].high));
  for (std::size_t i = 0; i < kTermCount; ++i)
    if (!(terms.value[i] >= 0.0 && terms.value[i] <= 1.0))
      throw Error(
          fmt::format("amplitude of {} = {}, wanted 0 to 1", term_list()[i].name, terms.value[i]));

  const double front = p[P::chassis_cog_behind_front_m];
  const double rear = p[P::chassis_wheelbase_m] - front;
  if (!(rear > 0.0))
    throw Error(fmt::format("chassis.cog_behind_front_m = {} m lies behind the rear axle ({} m)",
                            front, p[P::chassis_wheelbase_m]));
  const double wheels = 2.0 * (p[P::front_unsprung_mass_kg] + p[P::rear_unsprung_mass_kg]);
  if (!(p[P::chassis_mass_kg] > 1.2 * wheels))
    throw Error(fmt::format("chassis.mass_kg = {} kg leaves too little beside the wheels' {} kg",
                            p[P::chassis_mass_kg], wheels));
  if (!(p[P::clutch_full_radps] > p[P::clutch_begin_radps]))
    throw Error(fmt::format("clutch.full_radps = {} is not above clutch.begin_radps = {}",
                            p[P::clutch_full_radps], p[P::clutch_begin_radps]));
  if (!(p[P::tyre_window_end_k] >= p[P::tyre_window_begin_k]))
    throw Error(fmt::format("tyre.window_end_k = {} lies below tyre.window_begin_k = {}",
                            p[P::tyre_window_end_k], p[P::tyre_window_begin_k]));

  if (terms[Term::brake_vanes] > 0.0)
    for (std::size_t a = 0; a < 2; ++a)
      if (!(p.axle(a, P::front_disc_inner_m) < 0.95 * p.axle(a, P::front_disc_diameter_m)))
        throw Error(fmt::format("{}.disc_inner_m = {} m, wanted below 0.95 of the disc's {} m",
                                a == 0 ? "front" : "rear", p.axle(a, P::front_disc_inner_m),
                                p.axle(a, P::front_disc_diameter_m)));

  // The wheels alone must not have more inertia than the whole car.
  double ix = 0.0, iy = 0.0, iz = 0.0;
  for (std::size_t a = 0; a < 2; ++a) {
    const TyreCoefficients& tyre = files.tyre[a];
    if (!(tyre.unloaded_radius_m > 0.0))
      throw Error(fmt::format("the {} tyre has no coefficients; read a tyre file first",
                              a == 0 ? "front" : "rear"));
    const double m = 2.0 * p.axle(a, P::front_unsprung_mass_kg);
    const double half = p.axle(a, P::front_track_m) / 2.0;
    const double along = a == 0 ? front : rear;
    const double up = tyre.unloaded_radius_m - p[P::chassis_cog_height_m];
    ix += m * (half * half + up * up);
    iy += m * (along * along + up * up);
    iz += m * (along * along + half * half);
  }
  const auto inertia = [&](P which, double carried) {
    if (!(p[which] > carried))
      throw Error(fmt::format("{} = {} kg m2, but the wheels alone have {:.4g}; wanted more",
                              list[static_cast<std::size_t>(which)].name, p[which], carried));
  };
  inertia(P::chassis_roll_inertia_kgm2, ix);
  inertia(P::chassis_pitch_inertia_kgm2, iy);
  inertia(P::chassis_yaw_inertia_kgm2, iz);

  check_maps(files);
  check_rack(files.steering, p[P::steering_ratio]);
}

}  // namespace vehicle
