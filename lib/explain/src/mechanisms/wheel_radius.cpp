// Wheels that roll on another radius than stated.
#include <string>
#include <utility>

#include "car_changes.h"
#include "listing.h"
#include "mapping_changes.h"
#include "standing_car.h"

namespace explain::wheel_radius {
namespace {

using P = vehicle::Parameter;

constexpr const char* kId = "parameter.wheel_radius";

void list(const Listing& l) {
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
    if (!has(l, k == 0 ? kWheelFront : kWheelRear)) continue;
    Unknown u;
    u.id = kId;
    u.kind = "parameter";
    u.name = k == 0 ? "front wheel radius, share" : "rear wheel radius, share";
    u.unit = "1";
    u.role = Role::kParameter;
    u.stated = 1.0;
    u.width = 0.05;
    u.step = 0.01;
    u.form = k == 0 ? 0.0006 : 0.001;
    u.physics = "the rolling radius is not the stated one";
    u.equation = "v = omega * radius";
    u.set = [k](Setting& s, double amount) { s.wheel_radius[k] += amount; };
    l.out.unknowns.push_back(std::move(u));
  }
  if (!has(l, kWheelFront) && !has(l, kWheelRear)) untestable(l, kId, "no wheel speeds in the log");
}

bool in_front(const Finding& f) { return f.parameters[0].name.starts_with("front"); }

/// The free radius at which the standing tyre rolls on `share` of what the stated one rolls on.
double radius_that_rolls(const vehicle::TyreCoefficients& stated, double load_n, double pressure_pa,
                         double share) {
  const auto rolls = [&](double radius_m) {
    vehicle::TyreCoefficients t = stated;
    t.unloaded_radius_m = radius_m;
    return vehicle::standing_rolling_radius(t, load_n, pressure_pa);
  };
  double radius = stated.unloaded_radius_m;
  const double wanted = share * rolls(radius);
  for (int k = 0; k < 5; ++k) radius += (wanted - rolls(radius)) / stated.qre0;
  return radius;
}

void write(CarChanges& out, const Finding& f) {
  if (out.logs.front().wheels_in_mps) return;  // the logger's, see write_mapping()
  const std::size_t k = in_front(f) ? 0 : 1;
  const double pressure_pa = out.car.parameters.axle(k, P::front_tyre_pressure_pa);
  out.tyre[k]["UNLOADED_RADIUS"] = radius_that_rolls(
      out.car.files.tyre[k], standing_load_n(out.car, k), pressure_pa, f.parameters[0].value);
}

void write_mapping(MappingChanges& out, const Finding& f) {
  if (!out.logs.front().wheels_in_mps) return;
  const double value = f.parameters[0].value;
  for (ColumnMapping& m : out.mapping.columns)
    if (m.channel.starts_with(in_front(f) ? "wheel_f" : "wheel_r") && m.channel.ends_with("_mps"))
      m.scale *= value, m.offset *= value, out.changed = true;
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .write_car = write, .write_mapping = write_mapping}};
}

}  // namespace explain::wheel_radius
