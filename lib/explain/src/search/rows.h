// Residuals as rows of a linear problem: 0.3 s means of every relation, and how each unknown moves
// them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "explain/model.h"
#include "explain/unknowns.h"

namespace explain {

struct Row {
  std::size_t log = 0, relation = 0;
  int lap = 0;    ///< over all recordings
  int fold = 0;   ///< laps, or halves of laps where laps are few
  int block = 0;  ///< 3 s of one recording
  double t_s = 0, u_m = 0;
  double speed = 0, ax = 0, ay = 0, throttle = 0, brake = 0;
  double pressed_swing = 0;  ///< as in Signals
};

struct Rows {
  static constexpr std::size_t kSteps = 6;  ///< of Signals::kStep_s
  std::vector<Row> row;
  std::vector<std::size_t> first_step;  ///< of the mean, in its log
  int folds = 0, blocks = 0, laps = 0;
};

/// Which means exist at the stated setting: at least four of six steps.
Rows make_rows(const std::vector<Signals>& logs, const std::vector<Residuals>& at_stated);

/// The means of these residuals; 0 where a change of setting lost the value.
Eigen::VectorXd gather(const Rows& rows, const std::vector<Residuals>& r);

/// What is left in each relation once the model is taken away, and 1 / standard deviation of every
/// row: by what is usual, with its correlation in time up to 3 s. Rows that do not count and
/// relations with less than 30 rows have the weight 0; outliers count as 4 standard deviations.
struct Noise {
  std::array<double, kRelationCount> sigma{};  ///< standard deviation, in the relation's unit
  std::array<double, kRelationCount>
      spread{};  ///< variance of a mean over that of as many independent rows
  Eigen::VectorXd weight;
};
Noise noise_of(const Rows& rows, const Eigen::VectorXd& e, const std::vector<bool>& counts);

/// Their rows at each of these settings; NaN where a change lost the value. `known`: of each
/// recording, a drive that need not be driven again. Cars that can be are led together, and threads
/// share what is left; `progress` gets the share that is done.
std::vector<Eigen::VectorXd> rows_at(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                                     const std::vector<Setting>& settings,
                                     const std::vector<KnownDrive>& known, const Rows& rows,
                                     unsigned threads,
                                     const std::function<void(double)>& progress = {});

/// Columns d(row)/d(unknown) with the sign that makes `r0 = columns * amount` the model of a
/// residual: minus the derivative of the residual. `known` as above.
Eigen::MatrixXd derivatives(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                            const Setting& at, const std::vector<const Unknown*>& unknowns,
                            const std::vector<KnownDrive>& known, const Rows& rows,
                            unsigned threads, const std::function<void(double)>& progress);

}  // namespace explain
