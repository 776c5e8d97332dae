// A car that becomes lighter while it drives.
#include <fmt/format.h>

#include <algorithm>

#include "car_changes.h"
#include "explain/fuel.h"
#include "listing.h"
#include "vehicle/laws/fuel.h"

namespace explain::fuel_burn {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kId = "vehicle.fuel_burn";

void list(const Listing& l) {
  if (!l.engine) return untestable(l, kId, kNoThrottle);
  candidate(l, kId, {"mass lost", "kg/s", 0.05, 0.004, true},
            {"the car becomes lighter", "m(t) = m0 - k t", "weigh the car before and after"},
            [](Setting& s, double v) { s.burn += v; });
}

/// The car as stated is that of the log's begin: what burns over the log becomes fuel in its centre
/// of mass. What the power does not explain burns without torque.
void write(CarChanges& out, const Finding& f) {
  const double rate = f.parameters[0].value;
  const auto logged = [](const Signals& s) { return s.present[kFuel]; };
  if (std::any_of(out.logs.begin(), out.logs.end(), logged)) {
    out.remarks.push_back(fmt::format(
        "{}: {:.4g} kg/s beyond what the fuel loses that was logged or given; the gauge, the mass "
        "or the stated fuel_burn is off",
        f.mechanism, rate));
    return;
  }
  const auto& p = out.car.parameters;
  double longest = 0, work = 0, seconds = 1e-9;
  for (const Signals& s : out.logs) {
    longest = std::max(longest, Signals::kStep_s * static_cast<double>(s.n));
    seconds += Signals::kStep_s * static_cast<double>(s.n);
    for (const double power : useful_power_w(s, out.car)) work += power * Signals::kStep_s;
  }
  const auto stated = [&](P which) { return out.car.stated[static_cast<std::size_t>(which)]; };
  out.fuel_kg = rate * longest;
  out.set(Term::fuel_burn, 1);
  out.set(P::fuel_idle_kgps, std::max(0.0, rate - vehicle::laws::fuel_for_work(p, work / seconds)));
  out.set(P::chassis_mass_kg, out.now(P::chassis_mass_kg) - out.fuel_kg);
  if (!stated(P::fuel_tank_behind_front_m))
    out.set(P::fuel_tank_behind_front_m, out.now(P::chassis_cog_behind_front_m));
  if (!stated(P::fuel_tank_height_m))
    out.set(P::fuel_tank_height_m, out.now(P::chassis_cog_height_m));
  out.remarks.push_back(
      fmt::format("chassis.mass_kg is less by the {:.4g} kg of fuel with which the log begins: "
                  "drive with --fuel-kg {:.4g}",
                  out.fuel_kg, out.fuel_kg));
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 0.6, .write_car = write, .turn = Turn::kLast}};
}

}  // namespace explain::fuel_burn
