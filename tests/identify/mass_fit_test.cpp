// Mass, its place and lift from wheel loads: cars whose truth is known, driven and logged with
// noise, and another simulator's recordings.
#include "identify/mass_fit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/read_file.h"
#include "base/statistics.h"
#include "identify/proving_road.h"
#include "recorded_drive.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "vehicle/vehicle_file.h"

namespace {

using identify::DriveFit, identify::DriveWindows, identify::Found;
using vehicle::Recording;
using P = vehicle::Parameter;

vehicle::Vehicle racer() {
  return vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
}

/// One car that is not quite the stated one, and its drive.
struct Driven {
  vehicle::Vehicle stated = racer();
  vehicle::Parameters<double> truth = stated.parameters;
  vehicle::Car<double> car;
  Recording recording;
};

/// Everything that the fit looks for is off by up to 8 %; what it takes from the vehicle file, by
/// its prior.
Driven driven(std::uint64_t seed, const crg::Surface& surface) {
  Driven out;
  base::Random dice = base::random_of(seed, "car");
  const auto off = [&](P p, double share) { out.truth[p] *= 1.0 + dice.uniform(-share, share); };
  for (const P p :
       {P::chassis_mass_kg, P::chassis_cog_height_m, P::front_lift_area_m2, P::rear_lift_area_m2})
    off(p, 0.08);
  off(P::chassis_cog_behind_front_m, 0.03);
  for (const P p : {P::aero_drag_area_m2, P::aero_drag_height_m, P::front_wheel_inertia_kgm2,
                    P::rear_wheel_inertia_kgm2, P::front_spring_npm, P::rear_spring_npm,
                    P::front_ride_height_m, P::rear_ride_height_m})
    out.truth[p] *= 1.0 + 0.5 * out.stated.prior[static_cast<std::size_t>(p)] * dice.normal();
  out.car = make_car(out.stated.files, out.truth, out.stated.terms, out.stated.contact);
  const test_drive::Drive drive =
      test_drive::drive_car(out.car, vehicle::Road(surface), 20, 1, 100.0);
  out.recording = vehicle::make_recording(test_drive::logged(drive, true, seed, true), "log");
  out.recording.table.add("true_fuel_kg", *drive.telemetry.find("fuel_kg"));
  return out;
}

struct Score {
  int inside = 0, all = 0, unseen = 0;
};

TEST(MassFit, Trial) {
  const crg::Surface surface{identify::proving_road()};
  std::map<std::string, Score> scores;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Driven d = driven(seed, surface);
    const auto stated =
        make_car(d.stated.files, d.stated.parameters, d.stated.terms, d.stated.contact);
    const double fuel = base::median(*d.recording.table.find("true_fuel_kg"));
    for (const bool with_road : {true, false}) {
      const DriveWindows w =
          identify::drive_windows(stated, with_road ? &surface : nullptr, d.recording);
      identify::MassFitOptions options;
      options.fuel_kg = fuel;
      const DriveFit fit = identify::fit_mass(stated, d.stated.prior, w, options);
      const double m = d.truth[P::chassis_mass_kg] + fuel;
      const std::map<std::string, double> truth{
          {"mass_kg", m},
          {"cog_behind_front_m",
           (d.truth[P::chassis_mass_kg] * d.truth[P::chassis_cog_behind_front_m] +
            fuel * d.truth[P::fuel_tank_behind_front_m]) /
               m},
          {"cog_height_m", (d.truth[P::chassis_mass_kg] * d.truth[P::chassis_cog_height_m] +
                            fuel * d.truth[P::fuel_tank_height_m]) /
                               m},
          {"front_lift_area_m2", d.truth[P::front_lift_area_m2]},
          {"rear_lift_area_m2", d.truth[P::rear_lift_area_m2]}};
      for (const auto& [name, is] : truth) {
        const Found& f = fit.at(name);
        Score& s = scores[fmt::format("{} {}", with_road ? "road" : "az  ", name)];
        ++s.all;
        s.unseen += f.unseen.empty() ? 0 : 1;
        s.inside += std::abs(f.value - is) < f.within ? 1 : 0;
        fmt::print("{:2} {} {:20} {:8.4f} is {:8.4f} off {:8.4f} sd {:7.4f} of drive {:7.4f} {}\n",
                   seed, with_road, name, f.value, is, f.value - is, f.sd, f.sd_drive, f.unseen);
      }
      if (seed == 1)
        for (const auto& r : fit.remarks) fmt::print("  {}\n", r);
      fmt::print("windows {} blocks {}\n", fit.windows, fit.blocks);
    }
  }
  for (const auto& [name, s] : scores)
    fmt::print("{:30} {} of {} inside, {} unseen\n", name, s.inside, s.all, s.unseen);
}

TEST(MassFit, Others) {
  const std::string folder = places::data() + "/ocd_trials";
  const auto truth = nlohmann::json::parse(base::read_file(folder + "/truth.json", 1u << 24));
  for (const auto& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    if (id != "t01" && id != "t06" && id != "t18" && id != "t19") continue;
    const Recording log = support::recorded_log(folder + "/" + id + ".csv.xz");
    auto as_stated = trial.at("parameter_factors");
    for (auto& [name, factor] : as_stated.items()) factor = 1.0;
    support::RecordedCar c = support::recorded_car(folder, as_stated);
    c.terms[vehicle::Term::gyroscopic] = c.terms[vehicle::Term::wheel_reaction] = 0.0;
    const auto car = make_car(c.files, c.parameters, c.terms);
    std::array<double, vehicle::kParameterCount> prior;
    for (std::size_t i = 0; i < prior.size(); ++i) prior[i] = vehicle::parameter_list()[i].prior;
    for (const bool body : {false, true}) {
      identify::DriveWindowsOptions wo;
      wo.body_axes = body;
      const DriveWindows w = identify::drive_windows(car, nullptr, log, wo);
      identify::MassFitOptions options;
      options.fuel_kg = 0.0;
      options.body_axes = body;
      const DriveFit fit = identify::fit_mass(car, prior, w, options);
      const auto& f = trial.at("parameter_factors");
      fmt::print("{} body {} truth {} {} 0.28 0.95 1.45\n", id, body,
                 760.0 * f.at("mass").get<double>(), 1.6 * f.at("cog").get<double>());
      for (const Found& x : fit.found)
        fmt::print("  {:20} {:9.4f} sd {:8.4f} within {:8.4f} {}\n", x.name, x.value, x.sd,
                   x.within, x.unseen);
      for (const auto& r : fit.remarks) fmt::print("  {}\n", r);
    }
  }
}

}  // namespace
