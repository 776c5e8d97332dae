// The numbers of one order that leave least of a movement, and what they leave where they were not
// fitted.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "actuator_record.h"
#include "actuator_simulation.h"
#include "identify/actuator_fit.h"

namespace identify {

struct Fitted {
  ActuatorOrder order;
  ActuatorValues values{};
  double gain = 1.0, offset = 0.0;
  double sum2 = INFINITY;  ///< of what is left, over the rows looked at
};

/// A fit looks at all rows that are judged, but those of every fourth block from `fold` on; -1: at
/// all that are judged.
/// What is left of these rows by `model` times the gain and plus the offset that fit best, which
/// are put into `fit`; 0 in all other rows.
Eigen::VectorXd project(const Record& record, int fold, const std::vector<double>& model,
                        Fitted& fit);

/// The same by the model of the fit's own numbers.
Eigen::VectorXd evaluate(const Record& record, Hold hold, int fold, Fitted& fit);

/// Slopes of what evaluate() leaves: one row each of the record, one column each of unknowns_of().
Eigen::MatrixXd slopes_of(const Record& record, Hold hold, int fold, const Fitted& at);

/// An order fitted to all rows that are judged, from a grid of beginnings or from those that
/// smaller orders give.
Fitted fit_order(const Record& record, Hold hold, const ActuatorOrder& order);

/// Squares of what is left in each block when the fit, begun at `whole`, did not see it.
std::vector<double> left_out(const Record& record, Hold hold, const Fitted& whole);

}  // namespace identify
