// The road along the whole lap and all that sensors may get wrong, fitted together to what needs no
// car.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "led_car.h"
#include "rows.h"

namespace explain {

/// Of a profile: how large it is, in steps of its unknown, and over how many metres it stays alike.
struct Roughness {
  double size = 1.0, length_m = 240.0;
};
/// One profile along the lap.
struct Profile {
  std::size_t unknown = 0;  ///< in the inventory
  Eigen::Index column = 0;  ///< the first in the design matrix
  bool in = true;
  Roughness roughness;
  Eigen::MatrixXd shapes;
  Eigen::VectorXd amounts;
};

/// What one sensor may get wrong.
struct SensorError {
  std::size_t unknown = 0;
  double amount = 0.0;
  UsualError usual;
};

/// The rows at the present amounts as a linear problem, both sides whitened.
struct Linear {
  Eigen::MatrixXd x;
  Eigen::VectorXd y;  ///< the residual and what the amounts explain of it already
};

/// Its sums per fold, from which any choice of columns is solved.
struct Folds {
  std::vector<Eigen::MatrixXd> normal;
  std::vector<Eigen::VectorXd> right;
};

/// Per row: what the uniform change does there, times each shape at its place.
Eigen::MatrixXd along_the_lap(const Rows& rows, const Eigen::VectorXd& per_unit,
                              const Eigen::MatrixXd& shapes, double length_m, bool closed);

/// All profiles and all that the sensors may get wrong, fitted together to what needs no car.
class RoadFit {
 public:
  RoadFit(const std::vector<Signals>& logs, const vehicle::Vehicle& car, const Setting& stated,
          const std::vector<KnownDrive>& drives, const Inventory& inventory, const Rows& rows,
          const std::vector<bool>& training, unsigned threads);

  /// Gauss and Newton; the folds are those of the last step.
  void settle(int rounds, const std::function<void()>& done);

  /// Whether the derivative of the speed behind some filter gives ax better than an accelerometer
  /// on the road that was found: then it says nothing about grade. The force along the car takes
  /// its place, beside all that the stated car may get wrong.
  bool leave_out_derived_ax();

  /// By the evidence: what large and rough profiles can take the place of counts against them.
  void choose_roughness();

  /// What the profile saves on what was left out, beside all errors that sensors may have.
  struct Worth {
    double gain = 0.0, threshold = 0.0;
    bool counts = false;
  };
  Worth worth(const Profile& p) const;
  Eigen::VectorXd own_precision(const Profile& p) const;

  /// The larger of the yaw rate's two errors in time, if it is one; else null.
  const SensorError* late_yaw_rate() const;

  std::vector<Profile> profiles;

 private:
  Eigen::VectorXd precision(double UsualError::*usual = &UsualError::beside,
                            const Profile* left_out = nullptr) const;
  double derived_ax_deviation() const;  ///< of ax from the derivative of the speed, m/s2
  void go_by_force();
  double evidence(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right) const;
  Setting setting() const;
  Eigen::VectorXd rows_at(const Setting& s) const;
  Eigen::VectorXd weights(const Eigen::VectorXd& r) const;
  Eigen::MatrixXd per_unit(const Eigen::VectorXd& r, const Eigen::VectorXd& w) const;
  Linear linear(const Eigen::VectorXd& r) const;
  void solve(const Linear& l);

  const std::vector<Signals>& logs_;
  const vehicle::Vehicle& car_;
  const Setting& stated_;
  const std::vector<KnownDrive>& drives_;
  const Inventory& inventory_;
  const Rows& rows_;
  const std::vector<bool>& training_;
  unsigned threads_;
  double length_m_;
  bool closed_;
  Eigen::Index spaces_ = 0, width_ = 0, first_sensor_ = 0;
  bool by_force_ = false;  ///< along the car, not by ax
  Eigen::MatrixXd
      car_moves_;  ///< of the force along it, per unit of what the stated car may get wrong
  Eigen::VectorXd car_precision_;
  std::vector<SensorError> sensors_;
  Folds folds_;
};

}  // namespace explain
