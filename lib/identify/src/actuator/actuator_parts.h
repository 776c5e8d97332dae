// What the fit of an actuator is made of: the record, its simulation, and the numbers of one order.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "identify/actuator_fit.h"

namespace identify {

/// A record on an even grid.
struct Record {
  double step_s = 0.0;
  std::vector<double> command, movement;
  std::vector<int> block;  ///< of each row; -1: not judged
  int blocks = 0;
  double command_range = 0.0;
};

/// Brings rows to an even grid and cuts it into blocks; checks and refuses as fit_actuator() says.
Record record_of(const std::vector<double>& time_s, const std::vector<double>& command,
                 const std::vector<double>& movement);

/// Whether a command moves in steps: squares of second differences over those of first ones are 2
/// for single steps, small for what is smooth at this rate, also with some noise on it.
bool in_steps(const std::vector<double>& command);

/// Free numbers of an actuator. Lags and damping as logarithms, so that they stay above zero.
enum ActuatorUnknown { kDead, kLag, kDamping, kLag2, kLead, kPlay, kActuatorUnknowns };
using ActuatorValues = std::array<double, kActuatorUnknowns>;

/// Those that an order has, in the order of the enumeration.
std::vector<int> unknowns_of(const ActuatorOrder& order);

/// Movement for gain 1 and offset 0, at rest with the first command before it. Exact: between two
/// samples the delayed command has one kink, and linear differential equations are solved over both
/// pieces. kPlay is in the unit of the command.
std::vector<double> simulate(const ActuatorOrder& order, const ActuatorValues& values, Hold hold,
                             double step_s, const std::vector<double>& command);

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
