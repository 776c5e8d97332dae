// Torque that waits for boost after the throttle opens.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "car_changes.h"
#include "effect.h"
#include "gears.h"
#include "listing.h"
#include "vehicle/driver.h"
#include "vehicle/laws/boost.h"

namespace explain::turbo_lag {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
namespace laws = vehicle::laws;

constexpr const char* kId = "vehicle.turbo_lag";

/// Amount: share of the torque that waits; constants: rise time, s, and its engine speed, rad/s.
constexpr Effect kWait{[](vehicle::Car<double>& car, const Acting& a) {
  const double stated = car.terms[Term::turbo_lag] * car.parameters[P::turbo_share];
  if (stated == 0) {
    car.parameters[P::turbo_rise_s] = a.constant[0];
    car.parameters[P::turbo_reference_radps] = a.constant[1];
  }
  car.parameters[P::turbo_share] = stated + a.amount[0];
  car.terms[Term::turbo_lag] = 1.0;
}};

/// Median of the engine speed of the logs: as logged, or by the gears and the speed; rad/s.
double typical_engine_radps(const std::vector<Signals>& logs, const vehicle::Vehicle& car) {
  std::vector<double> all;
  for (const Signals& s : logs) {
    const double radius_m = car.files.tyre[1].unloaded_radius_m;
    const Gears gears = gears_of(s, car, radius_m);
    for (std::size_t i = 0; i < s.n; ++i) {
      const double engine =
          s.present[kEngine]
              ? s.x[kEngine][i]
              : vehicle::overall_ratio(car.parameters, gears.gear[i]) * s.x[kVx][i] / radius_m;
      if (std::isfinite(engine) && s.x[kVx][i] > 6) all.push_back(engine);
    }
  }
  return base::median_or(car.parameters[P::turbo_reference_radps], std::move(all));
}

void list(const Listing& l) {
  if (!l.engine) return untestable(l, kId, kNoThrottle);
  if (l.car.terms[Term::turbo_lag] != 0.0) return untestable(l, kId, kStatedToo);
  const double reference =
      std::clamp(std::round(typical_engine_radps(l.logs, l.car)), 10.0, 3000.0);
  for (const double rise :
       {0.02, 0.028, 0.036, 0.044, 0.054, 0.066, 0.08, 0.1, 0.13, 0.17, 0.23, 0.3, 0.4, 0.5})
    candidate(l, kId, {"turbo.share", "1", 0.2, 0.12, true},
              {"torque waits for boost after tip-in",
               fmt::format("d(boost)/dt = (throttle - boost) flow / rise; torque *= 1 - share "
                           "(throttle - boost); rise {} s at {:.0f} rad/s",
                           rise, reference),
               "tip in at two engine speeds and compare the delay"},
              [rise, reference](Setting& s, double v) {
                s.act(kWait, v, {rise, reference});
              })
        .constants = {{"turbo.rise_s", rise}, {"turbo.reference_radps", reference}};
}

/// `boost` by recorded throttle and engine speed (without it: that at which turbo.rise_s holds),
/// settled at the log's begin. Nothing where the car has no first-order boost, the log no throttle,
/// or the column already.
void add_boost(recording::Recording& recording, const vehicle::Vehicle& car) {
  const std::vector<double>* throttle = recording.table.find("throttle");
  if (throttle == nullptr) throttle = recording.table.find("throttle_command");
  if (car.terms[Term::turbo_lag] == 0.0 || throttle == nullptr ||
      recording.table.find("boost") != nullptr)
    return;
  const laws::BoostParameters<double> turbo = laws::boost_parameters(car.parameters);
  const std::vector<double>& time = *recording.table.find("time_s");
  const std::vector<double> opening = recording::fill_gaps(time, *throttle);
  const auto* const engine = recording.table.find("engine_radps");
  const std::vector<double> speed = engine == nullptr
                                        ? std::vector<double>(time.size(), turbo.reference_radps)
                                        : recording::fill_gaps(time, *engine);
  std::vector<double> boost(time.size(), opening.front());
  for (std::size_t i = 1; i < time.size(); ++i)
    boost[i] =
        laws::boost_after(turbo, boost[i - 1], speed[i - 1], opening[i - 1], time[i] - time[i - 1]);
  if (std::isfinite(boost.back())) recording.table.add("boost", boost);
}

void write(CarChanges& out, const Finding& f) {
  out.set(Term::turbo_lag, 1);
  out.set(P::turbo_share, f.parameters[0].value);
  out.set_constants(f);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 1.25, .add_state = add_boost, .write_car = write}};
}

}  // namespace explain::turbo_lag
