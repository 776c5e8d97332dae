#include "vehicle/steady_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/dynamics/drive.h"
#include "vehicle/error.h"
#include "vehicle/laws/turbocharger.h"
#include "vehicle/settle.h"

namespace vehicle {
namespace {

/// The air path at a speed and throttle that are held, from where it was.
class Settling {
 public:
  explicit Settling(const Car<double>& car)
      : car_(car), p_(laws::turbo_parameters(car.parameters)) {
    // A lighter shaft comes to the same speed, sooner.
    p_.inertia_kgm2 *= 0.1;
  }

  void begin(double engine_radps) {
    const laws::TurboState<double> idle = laws::idling_air_path(car_.parameters, engine_radps);
    state_[kManifold] = idle.manifold_pa;
    state_[kCharge] = idle.charge_pa;
    state_[kExhaust] = idle.exhaust_pa;
    state_[kTurbo] = idle.shaft_radps;
  }

  /// Torque once nothing changes, N m.
  double torque(double engine_radps, double throttle) {
    constexpr double kStep_s = 1e-3, kLongest_s = 60.0;
    const auto& t = car_.terms;
    double calm_s = 0.0;
    for (double time_s = 0.0; time_s < kLongest_s; time_s += kStep_s) {
      detail_.turbo = laws::turbocharged<double>(
          p_,
          {t[Term::compressor_map], t[Term::wastegate], t[Term::overrun_valve],
           t[Term::intercooler], t[Term::turbine_map]},
          {state_[kManifold], state_[kCharge], state_[kExhaust], state_[kTurbo]}, engine_radps,
          throttle, 1.0, dynamics::turbo_maps(*car_.files));
      State<double> rate{};
      rate[kManifold] = detail_.turbo.manifold_paps;
      rate[kCharge] = detail_.turbo.charge_paps;
      rate[kExhaust] = detail_.turbo.exhaust_paps;
      settle_air(kStep_s, rate, detail_);
      const double before = state_[kTurbo], before_pa = state_[kManifold];
      for (const std::size_t k : {kManifold, kCharge, kExhaust})
        state_[k] = std::max(1e3, state_[k] + kStep_s * rate[k]);
      state_[kTurbo] = std::max(0.0, before + kStep_s * detail_.turbo.shaft_radps2);
      const bool still = std::abs(state_[kTurbo] - before) < 1e-6 * (before + 1.0) &&
                         std::abs(state_[kManifold] - before_pa) < 1e-6 * before_pa;
      calm_s = still ? calm_s + kStep_s : 0.0;
      if (calm_s > 0.02) return detail_.turbo.engine_nm;
    }
    throw Error(fmt::format(
        "the full turbocharged engine does not settle at {:.0f} rad/s and a throttle of {:g}; the "
        "driver needs an engine whose torque is steady there",
        engine_radps, throttle));
  }

 private:
  const Car<double>& car_;
  laws::TurboParameters<double> p_;
  State<double> state_{};
  Detail<double> detail_{};
};

}  // namespace

Map2 steady_engine(const Car<double>& car) {
  Map2 out;
  if (car.files->turbo != Turbo::kFull) return out;
  constexpr int kSpeeds = 16;
  const double limit = car.parameters[Parameter::engine_limit_radps];
  for (int i = 0; i < kSpeeds; ++i) out.x.push_back(limit * (0.1 + 0.92 * i / (kSpeeds - 1)));
  out.y = {0.0, 0.1, 0.2, 0.3, 0.45, 0.65, 1.0};
  Settling path(car);
  for (const double engine_radps : out.x) {
    path.begin(engine_radps);
    for (const double throttle : out.y) out.z.push_back(path.torque(engine_radps, throttle));
  }
  return out;
}

double throttle_for(const Map2& torque_nm, double engine_radps, double torque) {
  double below_nm = evaluate(torque_nm, engine_radps, torque_nm.y.front());
  if (torque <= below_nm) return torque_nm.y.front();
  for (std::size_t j = 1; j < torque_nm.y.size(); ++j) {
    const double above_nm = evaluate(torque_nm, engine_radps, torque_nm.y[j]);
    if (above_nm >= torque) {
      const double share = (torque - below_nm) / std::max(1e-9, above_nm - below_nm);
      return torque_nm.y[j - 1] + share * (torque_nm.y[j] - torque_nm.y[j - 1]);
    }
    below_nm = std::max(below_nm, above_nm);
  }
  return torque_nm.y.back();
}

}  // namespace vehicle
