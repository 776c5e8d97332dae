// What lies between commands and car: dead times of throttle, brake and steering, a lag of the
// steering and its free play.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"
#include "mapping_changes.h"

namespace explain::actuators {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

/// The actuator of the car that acts late.
struct Actuator {
  Term term;
  Channel channel;
  P gain, dead_time, lag, damping, lead;
};
constexpr Actuator kThrottleActuator{
    Term::throttle_actuator, kThrottle,           P::throttle_gain,  P::throttle_dead_time_s,
    P::throttle_lag_s,       P::throttle_damping, P::throttle_lead_s};
constexpr Actuator kBrakeActuator{Term::brake_actuator, kBrakeFront,    P::brake_gain,
                                  P::brake_dead_time_s, P::brake_lag_s, P::brake_damping,
                                  P::brake_lead_s};
constexpr Actuator kSteeringActuator{Term::steering_actuator, kSteer,
                                     P::steering_ratio,       P::steering_dead_time_s,
                                     P::steering_lag_s,       P::steering_damping,
                                     P::steering_lead_s};

void list_throttle(const Listing& l) {
  const char* const id = "vehicle.throttle_dead_time";
  if (!l.engine) return untestable(l, id, kNoThrottle);
  // Read between rows its noise is less: at 50 Hz that passes for up to 8 ms, on other cars too.
  candidate(l, id, {"throttle.dead_time_s", "s", 0.04, 0.01, true},
            {"torque follows the throttle late", "torque(t) = map(throttle(t - T))",
             "short throttle pulses at constant speed"},
            [](Setting& s, double v) { s.throttle_s += v; });
}

void list_brake(const Listing& l) {
  const char* const id = "vehicle.brake_dead_time";
  if (!l.engine || !l.brake)
    return untestable(l, id, l.engine ? "no brake pressure in the log" : kNoThrottle);
  candidate(l, id, {"brake.dead_time_s", "s", 0.04, 0.008, true},
            {"deceleration follows the pressure late", "force(t) = k p(t - T)",
             "short brake pulses on a straight"},
            [](Setting& s, double v) { s.brake_s += v; });
}

void list_steering(const Listing& l) {
  const char* const id = "vehicle.steering_dead_time";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  candidate(l, id, {"steering.dead_time_s", "s", 0.03, 0.006, true},
            {"the wheels follow the steering late", "delta(t) = command(t - T)",
             "step steer at constant speed"},
            [](Setting& s, double v) { s.steer_s += v; });
}

void list_steering_lag(const Listing& l) {
  const char* const id = "vehicle.steering_lag";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  candidate(l, id, {"steering.lag_s", "s", 0.05, 0.006, true},
            {"the wheels follow the steering through a lag", "T d(delta)/dt = command - delta",
             "sine steer at two frequencies"},
            [](Setting& s, double v) { s.steer_lag_s += v; });
}

constexpr const char* kBacklash = "vehicle.steering_backlash";

double stated_play_rad(const vehicle::Vehicle& car) {
  return car.terms[Term::steering_backlash] * car.parameters[P::steering_backlash_rad];
}

/// To the play that the stated car has, an amount adds.
constexpr Effect kPlay{[](vehicle::Car<double>& car, const Acting& a) {
  double& play_rad = car.parameters[P::steering_backlash_rad];
  play_rad = std::max(0.0, car.terms[Term::steering_backlash] * play_rad + a.amount[0]);
  car.terms[Term::steering_backlash] = 1.0;
}};

void list_steering_backlash(const Listing& l) {
  if (!l.lateral) return untestable(l, kBacklash, kNoSlip);
  if (!commanded(l.logs, kSteer))
    return untestable(l, kBacklash, "the log has the road wheels' angle itself, behind the play");
  candidate(
      l, kBacklash, {"steering.backlash_rad", "rad", 0.004, 0.001, true},
      {"the road wheels stay until the steering has crossed its free play",
       "|command / ratio - delta| <= play / 2",
       "slow sine steer, ever slower: what a lag leaves behind vanishes, what play does stays"},
      [](Setting& s, double v) { s.act(kPlay, v); });
}

/// An actuator that the stated car lacks is a pure delay or lag; to one that it has, the finding
/// adds.
void add_to(CarChanges& out, const Finding& f, const Actuator& late, P to, double amount) {
  const bool had = out.car.terms[late.term] > 0;
  if (had && !commanded(out.logs, late.channel))
    out.remarks.push_back(fmt::format(
        "{}: found behind the measured position, where no actuator of this file acts; it is added "
        "to the one before, for the driver's commands",
        f.mechanism));
  if (!had && out.terms.count(name_of(late.term)) == 0) {
    out.set(late.dead_time, 0);
    out.set(late.lag, 0);
    out.set(late.damping, 1);
    out.set(late.lead, 0);
  }
  out.set(late.term, 1);
  out.set(to, out.now(to) + amount);
}

template <const Actuator& kLate>
void write_dead_time(CarChanges& out, const Finding& f) {
  add_to(out, f, kLate, kLate.dead_time, f.parameters[0].value);
}

/// Two lags in a row of half the time are as late as the one that was found.
void write_lag(CarChanges& out, const Finding& f) {
  add_to(out, f, kSteeringActuator, kSteeringActuator.lag, 0.5 * f.parameters[0].value);
}

void write_steering_backlash(CarChanges& out, const Finding& f) {
  out.set(Term::steering_backlash, 1);
  out.set(P::steering_backlash_rad, stated_play_rad(out.car) + f.parameters[0].value);
}

/// Measured behind the actuator of this channel.
bool is_outcome(const std::string& channel, Channel c) {
  if (c == kSteer) return channel == "steer_rad";
  if (c == kThrottle) return channel == "throttle";
  return channel.starts_with("brake_") && channel.ends_with("_pa") &&
         channel.find("command") == std::string::npos;
}

/// steer_rad: steer_command_rad; throttle: throttle_command; brake_fl_pa: brake_fl_command_pa.
std::string command_of(const std::string& channel) {
  const std::size_t unit =
      channel.ends_with("_rad") || channel.ends_with("_pa") ? channel.rfind('_') : channel.size();
  return channel.substr(0, unit) + "_command" + channel.substr(unit);
}

/// What was measured where the stated car has no actuator becomes the command of the one that
/// write_dead_time() adds.
template <const Actuator& kLate>
void write_mapping(MappingChanges& out, const Finding&) {
  if (out.car.terms[kLate.term] != 0 || commanded(out.logs, kLate.channel)) return;
  const double stated = out.car.parameters[kLate.gain];
  const double gain = kLate.channel == kSteer ? stated : 1 / stated;
  for (ColumnMapping& m : out.mapping.columns) {
    if (!is_outcome(m.channel, kLate.channel)) continue;
    m.channel = command_of(m.channel);
    m.scale *= gain, m.offset *= gain, out.changed = true;
  }
}

}  // namespace

std::vector<Mechanism> late_pedals() {
  return {{.id = "vehicle.throttle_dead_time",
           .list = list_throttle,
           .most = 0.5,
           .write_car = write_dead_time<kThrottleActuator>,
           .write_mapping = write_mapping<kThrottleActuator>},
          {.id = "vehicle.brake_dead_time",
           .list = list_brake,
           .most = 0.5,
           .write_car = write_dead_time<kBrakeActuator>,
           .write_mapping = write_mapping<kBrakeActuator>}};
}

std::vector<Mechanism> late_steering() {
  return {{.id = "vehicle.steering_dead_time",
           .list = list_steering,
           .most = 0.3,
           .write_car = write_dead_time<kSteeringActuator>,
           .write_mapping = write_mapping<kSteeringActuator>},
          {.id = "vehicle.steering_lag",
           .list = list_steering_lag,
           .most = 0.5,
           .write_car = write_lag,
           .write_mapping = write_mapping<kSteeringActuator>},
          {.id = kBacklash,
           .list = list_steering_backlash,
           .most = 0.05,
           .write_car = write_steering_backlash}};
}

}  // namespace explain::actuators
