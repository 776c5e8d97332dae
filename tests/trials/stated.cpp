#include "stated.h"

#include <crg/file.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace trials {
namespace {

/// Torque over speed and throttle.
std::string engine_map(const StatedCar& car) {
  std::string out = "engine_radps:throttle,0,0.25,0.5,0.75,1\n";
  const int last = car.engine.electric ? 2000 : 850;
  for (int omega = 100; omega <= last; omega += 50) {
    out += std::to_string(omega);
    for (const double throttle : {0.0, 0.25, 0.5, 0.75, 1.0})
      out +=
          "," + std::to_string(car.engine.engine_nm(omega, throttle) * torque_factor(car, omega));
    out += "\n";
  }
  return out;
}

/// Springs without bars whose axles carry these shares of the load transfer, in series with tyres
/// of 240 kN/m.
std::string springs(const StatedCar& car) {
  constexpr double kTyre_npm = 240e3, kRear_npm = 130e3;
  const double tracks = car.rear_track_m / car.front_track_m;
  const double rear = kRear_npm * kTyre_npm / (kRear_npm + kTyre_npm);
  const double front = rear * tracks * tracks * car.front_roll_share / (1 - car.front_roll_share);
  return "  front.anti_roll_npm: 0\n  rear.anti_roll_npm: 0\n  rear.spring_npm: 130000\n"
         "  front.spring_npm: " +
         std::to_string(front * kTyre_npm / (kTyre_npm - front)) + "\n";
}

/// What the truth does without, stated as such.
const std::string kWithout =
    "  steering.ackermann: 0\n  front.roll_centre_m: 0\n"
    "  rear.roll_centre_m: 0\n  front.anti_slope: 0\n  rear.anti_slope: 0\n"
    "  front.toe_gain_radpm: 0\n  rear.toe_gain_radpm: 0\n";

std::string vehicle(const StatedCar& car) {
  char text[2000];
  std::snprintf(
      text, sizeof text,
      "  chassis.mass_kg: %.2f\n  chassis.wheelbase_m: %.3f\n  chassis.cog_behind_front_m: %.4f\n  "
      "chassis.cog_height_m: %.4f\n  chassis.yaw_inertia_kgm2: %.1f\n"
      "  front.track_m: %.3f\n  rear.track_m: %.3f\n  aero.drag_area_m2: %.4f\n  "
      "front.lift_area_m2: %.4f\n  rear.lift_area_m2: %.4f\n"
      "  aero.drag_height_m: %.4f\n  engine.inertia_kgm2: %.4f\n%s"
      "  front.brake_area_m2: 0.004\n  front.brake_radius_m: 0.125\n  front.brake_friction: %.4f\n "
      " rear.brake_area_m2: 0.003\n  rear.brake_radius_m: 0.115\n  rear.brake_friction: %.4f\n"
      "  front.camber_rad: %.4f\n  rear.camber_rad: %.4f\n  front.camber_gain_radpm: 0\n  "
      "rear.camber_gain_radpm: 0\n  front.toe_rad: 0\n  rear.toe_rad: 0\n",
      car.mass_kg, car.wheelbase_m, car.cog_behind_front_m, car.cog_height_m, car.yaw_inertia_kgm2,
      car.front_track_m, car.rear_track_m, car.drag_area_m2, car.front_lift_area_m2,
      car.rear_lift_area_m2, car.drag_height_m, car.engine_inertia_kgm2, car.drivetrain.c_str(),
      car.front_brake_friction, car.rear_brake_friction, car.camber_rad, car.camber_rad);
  return "name: stated\ntyres: {front: front.tir, rear: rear.tir, alpha: tan, fx_arm: "
         "rolling_radius}\nmaps: "
         "{engine_torque_nm: engine.csv}\ncontact: single_point\nparameters:\n" +
         kWithout + (car.first_parameters.empty() ? springs(car) : car.first_parameters) + text +
         car.last_parameters + "terms: {" + car.terms + "}\n";
}

}  // namespace

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out.flush()) std::fprintf(stderr, "cannot write %s\n", path.c_str()), std::exit(1);
}

void write_road(const Track& line_of, const Track& heights_of, const TruthCar& car,
                const std::filesystem::path& path) {
  // Waves and teeth want a finer grid than hills.
  const std::size_t per_node = line_of.feature.empty() ? 1 : 10;
  const double v_step = line_of.feature.empty() ? 0.5 : 0.25;
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = line_of.step_m / static_cast<double>(per_node);
  line.closed = true;
  const int half = static_cast<int>(10 / v_step);
  for (int j = -half; j <= half; ++j) grid.v_m.push_back(v_step * j);
  const std::size_t n = line_of.x.size();
  for (std::size_t i = 0; i <= n * per_node; ++i) {
    const double s = static_cast<double>(i % (n * per_node)) * line.u_step_m;
    if (per_node == 1) {
      line.x_m.push_back(line_of.x[i % n]);
      line.y_m.push_back(line_of.y[i % n]);
      const std::size_t before = (i + n - 1) % n;
      line.heading_rad.push_back(
          std::atan2(line_of.y[i % n] - line_of.y[before], line_of.x[i % n] - line_of.x[before]));
    } else {
      const Track::Point p = line_of.at(s);
      line.x_m.push_back(p.x);
      line.y_m.push_back(p.y);
      const Track::Point before = line_of.at(s + line_of.length_m - line.u_step_m);
      line.heading_rad.push_back(std::atan2(p.y - before.y, p.x - before.x));
    }
    for (const double v : grid.v_m)
      grid.z_m.push_back(static_cast<float>(
          heights_of.height(s) + v * true_bank(car, heights_of, s) + heights_of.rough(s, v)));
  }
  crg::write(crg::make_crg(line, grid), path.string(), crg::Format::KRBI);
}

double front_friction(double brake_nm_per_pa) { return brake_nm_per_pa / (4 * 0.004 * 0.125); }
double rear_friction(double brake_nm_per_pa) { return brake_nm_per_pa / (4 * 0.003 * 0.115); }

double torque_factor(const StatedCar& car, double omega_radps) {
  const double middle_radps = car.engine.electric ? 1200.0 : 500.0;
  return car.torque_scale *
         (1 + car.torque_tilt * (omega_radps - middle_radps) / (0.6 * middle_radps));
}

void write_car(const StatedCar& car, const std::filesystem::path& folder) {
  write(folder / "front.tir", tir(car.front));
  write(folder / "rear.tir", tir(car.rear));
  write(folder / "engine.csv", engine_map(car));
  write(folder / "vehicle.yaml", vehicle(car));
}

}  // namespace trials
