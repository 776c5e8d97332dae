// Tyres whose grip and stiffness change as they warm up.
#include <cmath>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"
#include "vehicle/laws/tyre_warm_up.h"

namespace explain::tyre_thermal {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kId = "vehicle.tyre_thermal";

/// Amount: grip missing when cold; constant: time of warming up, s.
constexpr Effect kWarmUp{[](vehicle::Car<double>& car, const Acting& a) {
  const double stated = car.terms[Term::tyre_warm_up] * car.parameters[P::tyre_warm_up_loss];
  if (stated == 0) car.parameters[P::tyre_warm_up_s] = a.constant[0];
  car.parameters[P::tyre_warm_up_loss] = stated + a.amount[0];
  car.terms[Term::tyre_warm_up] = 1.0;
}};

void list(const Listing& l) {
  if (!l.lateral) return untestable(l, kId, kNoSlip);
  if (l.car.terms[Term::tyre_thermal] != 0.0 ||
      l.car.terms[Term::tyre_warm_up] * l.car.parameters[P::tyre_warm_up_loss] != 0.0)
    return untestable(l, kId, kStatedToo);
  for (const double time : {25.0, 80.0, 250.0})
    candidate(l, kId, {"grip missing when cold", "1", 0.1, 0.025},
              {"the tyres' grip and stiffness change as they warm up",
               "grip = 1 - k (1 - warmth); d(warmth)/dt = work / T",
               "log the tyre temperature, or repeat the first laps on warm tyres"},
              [time](Setting& s, double v) {
                s.act(kWarmUp, v, {time, 0.0});
              })
        .constants = {{"tyre.warm_up_s", time}};
}

/// `tyre_warmth` of tyres that warm up, by recorded speed and yaw rate; cold at the log's begin.
/// Nothing without a yaw rate.
void add_warmth(recording::Recording& recording, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  const auto* const rate = recording.table.find("yaw_rate_radps");
  if (car.terms[Term::tyre_warm_up] * p[P::tyre_warm_up_loss] == 0.0 || rate == nullptr) return;
  const std::vector<double>& time = *recording.table.find("time_s");
  const std::vector<double> speed = recording::fill_gaps(time, *recording.table.find("vx_mps"));
  const std::vector<double> turning = recording::fill_gaps(time, *rate);
  std::vector<double> warmth(time.size(), 0.0);
  for (std::size_t i = 1; i < time.size(); ++i)
    warmth[i] = vehicle::laws::warmth_after(warmth[i - 1], p[P::tyre_warm_up_s],
                                            speed[i - 1] * turning[i - 1], time[i] - time[i - 1]);
  if (std::isfinite(warmth.back())) recording.table.add("tyre_warmth", warmth);
}

void write(CarChanges& out, const Finding& f) {
  out.set(Term::tyre_warm_up, 1);
  out.set(P::tyre_warm_up_loss, f.parameters[0].value);
  out.set_constants(f);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 0.6, .add_state = add_warmth, .write_car = write}};
}

}  // namespace explain::tyre_thermal
