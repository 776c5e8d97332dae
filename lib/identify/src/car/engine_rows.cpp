#include "engine_rows.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "drive_columns.h"
#include "vehicle/laws/boost.h"
#include "vehicle/laws/engine.h"
#include "vehicle/laws/steering.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
constexpr double kBeside_s = 0.1;     ///< a gear must have been in for so long before and after
constexpr double kInStep = 0.04;      ///< engine and driven wheels may differ by this share
constexpr double kInStepBlind = 0.1;  ///< engine and car, where no wheel's speed was recorded
/// Of windows that count; the second where the steering was not recorded.
constexpr double kMostLeft_mps2 = 8.0, kMostLeftBlind_mps2 = 2.0;
constexpr double kBlindThrottle = 0.1;  ///< less may be braking, where no pressure was recorded

class EngineCollector {
 public:
  EngineCollector(const vehicle::Car<double>& car, const recording::Recording& recording)
      : car_(car), recording_(recording) {
    const recording::Table& table = recording.table;
    time_ = table.find("time_s");
    throttle_ = table.find("throttle");
    if (throttle_ == nullptr)
      throw base::Error(
          "the recording has no channel throttle: wanted for an engine; name its column in a "
          "mapping");
    engine_ = table.find("engine_radps");
    gear_ = table.find("gear");
    left_ = table.find("wheel_rl_radps");
    right_ = table.find("wheel_rr_radps");
    if (right_ == nullptr) left_ = nullptr;
    steer_ = table.find("steer_rad");
    vx_ = table.find("vx_mps");
    out_.engine_speed = engine_ != nullptr;
    out_.wheel_speed = left_ != nullptr;
    out_.gears = static_cast<std::size_t>(vehicle::top_gear(car.parameters));
    out_.pressures = table.find("brake_pa") != nullptr || table.find("brake_fl_pa") != nullptr;
    for (const recording::Stretch& stretch : recording.stretches) charge(stretch);
  }

  EngineWindows collect(const DriveWindows& drive) {
    for (const DriveWindow& w : drive.windows) add(w);
    return std::move(out_);
  }

 private:
  double wheels_radps(std::size_t k) const {
    return left_ == nullptr ? DriveWindow::kNaN : 0.5 * ((*left_)[k] + (*right_)[k]);
  }

  double engine_radps(std::size_t k, int gear) const {
    const double recorded = engine_ == nullptr ? DriveWindow::kNaN : (*engine_)[k];
    if (std::isfinite(recorded)) return recorded;
    const double wheels = wheels_radps(k), ratio = overall_ratio(car_.parameters, gear);
    return ratio * (std::isfinite(wheels) ? wheels : (*vx_)[k] / car_.static_radius_m[1]);
  }

  /// The boost at every row of a stretch; at its begin there is none.
  void charge(const recording::Stretch& stretch) {
    boost_.resize(throttle_->size(), 0.0);
    if (!(car_.terms[Term::turbo_lag] > 0.0)) return;
    const auto law = vehicle::laws::boost_parameters(car_.parameters);
    double boost = 0.0;
    for (std::size_t k = stretch.begin; k < stretch.end; ++k) {
      boost_[k] = boost;
      const double gear = gear_ == nullptr ? 1.0 : (*gear_)[k];
      const double speed = engine_radps(k, std::isfinite(gear) ? static_cast<int>(gear) : 1);
      const double open = std::clamp((*throttle_)[k], 0.0, 1.0);
      if (k + 1 < stretch.end && std::isfinite(open + speed))
        boost = vehicle::laws::boost_after(law, boost, speed, open, (*time_)[k + 1] - (*time_)[k]);
    }
  }

  bool in_gear(const DriveWindow& w, int gear) const {
    if (gear_ == nullptr) return true;
    const auto beside =
        static_cast<std::size_t>(std::ceil(kBeside_s / std::max(1e-4, recording_.step_s)));
    const std::size_t from = w.begin_row > beside ? w.begin_row - beside : 0,
                      to = std::min(gear_->size(), w.end_row + beside);
    for (std::size_t k = from; k < to; ++k)
      if ((*gear_)[k] != static_cast<double>(gear)) return false;
    return true;
  }

  bool braked(const DriveWindow& w) const {
    if (!std::isfinite(w.brake_pa[0])) return !(w.throttle > kBlindThrottle);
    return identify::braked(w, kUnbraked_pa);
  }

  bool turns(const DriveWindow& w) const {
    return std::abs(left_mps2(w)) > (steer_ == nullptr ? kMostLeftBlind_mps2 : kMostLeft_mps2);
  }

  void add(const DriveWindow& w) {
    const int gear = gear_of(car_, w).value_or(0);
    if (braked(w)) return void(++out_.braked);
    if (turns(w)) return void(++out_.turning);
    if (gear < 1 || !(overall_ratio(car_.parameters, gear) > 0.0) || !in_gear(w, gear))
      return void(++out_.gear_unknown);
    EngineWindow out{&w, gear, 0.0, {}};
    const auto& p = car_.parameters;
    const double ratio = overall_ratio(p, gear);
    double steer = 0.0, apart = 0.0;
    for (std::size_t k = w.begin_row; k < w.end_row; ++k) {
      const double speed = engine_radps(k, gear), open = std::clamp((*throttle_)[k], 0.0, 1.0);
      if (!std::isfinite(speed + open)) continue;
      out.rows.push_back({speed, open, boost_[k]});
      if (steer_ != nullptr && std::isfinite((*steer_)[k])) steer += (*steer_)[k];
      const double wheels = wheels_radps(k);
      apart +=
          speed - ratio * (std::isfinite(wheels) ? wheels : (*vx_)[k] / car_.static_radius_m[1]);
    }
    const auto rows = static_cast<double>(out.rows.size());
    if (2.0 * rows < static_cast<double>(w.end_row - w.begin_row)) return;
    out.steer_rad = steer / rows;
    double fastest = 0.0, slowest = 1e9;
    for (const EngineRow& row : out.rows) {
      fastest = std::max(fastest, row.engine_radps);
      slowest = std::min(slowest, row.engine_radps);
    }
    const double clutch =
        car_.terms[Term::centrifugal_clutch] > 0.0 ? p[P::clutch_full_radps] : 0.0;
    if (fastest > p[P::engine_limit_radps] || slowest < p[P::engine_idle_radps] || slowest < clutch)
      return void(++out_.limited);
    if (std::abs(apart) / rows > (left_ == nullptr ? kInStepBlind : kInStep) * fastest)
      return void(++out_.out_of_step);
    out_.windows.push_back(std::move(out));
  }

  const vehicle::Car<double>& car_;
  const recording::Recording& recording_;
  Column time_, throttle_, engine_, gear_, left_, right_, steer_, vx_;
  std::vector<double> boost_;
  EngineWindows out_;
};

/// What the front tyres' side force takes from the drive where the wheels are turned, N.
double side_n(const vehicle::Car<double>& car, const EngineWindow& e, double mass_kg) {
  const auto& p = car.parameters;
  return mass_kg * left_mps2(*e.window) *
         (1.0 - p[P::chassis_cog_behind_front_m] / p[P::chassis_wheelbase_m]) *
         std::sin(e.steer_rad);
}

}  // namespace

EngineWindows engine_windows(const vehicle::Car<double>& car, const DriveWindows& drive,
                             const recording::Recording& recording) {
  return EngineCollector(car, recording).collect(drive);
}

EngineEquations engine_equations(const vehicle::Car<double>& car, const EngineWindows& windows,
                                 const vehicle::Map2& torque_nm, bool by_speed,
                                 const Granted& granted) {
  using Eigen::Index;
  const auto& p = car.parameters;
  const double share = car.terms[Term::turbo_lag] * p[P::turbo_share];
  const auto places = static_cast<Index>(torque_nm.z.size());
  const auto count = static_cast<Index>(windows.windows.size());
  EngineEquations out;
  out.rows.setZero(count, places + static_cast<Index>(windows.gears));
  out.wanted = out.drag_n = out.inertia_n = Eigen::VectorXd::Zero(count);
  for (Index r = 0; r < out.rows.rows(); ++r) {
    const EngineWindow& e = windows.windows[static_cast<std::size_t>(r)];
    const DriveWindow& w = *e.window;
    const AlongForces f = along_forces(car, w, granted.mass_kg, 0, by_speed);
    const double rear_radps2 = 0.5 * (spin_up_radps2(car, w, 2, granted.mass_kg) +
                                      spin_up_radps2(car, w, 3, granted.mass_kg));
    const double turned_nm = p[P::engine_inertia_kgm2] * overall_ratio(p, e.gear) * rear_radps2;
    double given = 0.0;
    for (const EngineRow& row : e.rows) {
      const double stated = vehicle::evaluate(torque_nm, row.engine_radps, row.throttle);
      const Gearing g = gearing(car, w, e.gear, granted.mass_kg, stated > turned_nm);
      const double part = 1.0 / static_cast<double>(e.rows.size());
      const double boosted = vehicle::laws::boosted_torque(stated, share, row.throttle - row.boost);
      const double left = stated == 0.0 ? 1.0 : boosted / stated;
      for (const auto& [place, weight] :
           map_weights(torque_nm.x, torque_nm.y, row.engine_radps, row.throttle))
        out.rows(r, static_cast<Index>(place)) += part * g.per_torque_1pm * left * weight;
      out.rows(r, places + e.gear - 1) += part * g.per_torque_1pm * boosted;
      given += part * g.per_torque_1pm * (boosted - turned_nm);
      out.inertia_n(r) += part * g.per_torque_1pm * turned_nm;
    }
    out.drag_n(r) = p[P::aero_drag_area_m2] * f.drag_m2_n;
    out.wanted(r) = f.inertia_n + granted.mass_kg * granted.offset_mps2 +
                    granted.rolling * f.rolling_n + out.drag_n(r) +
                    granted.side * side_n(car, e, granted.mass_kg) - given;
  }
  return out;
}

}  // namespace identify
