// Command and movement of an actuator as the fit looks at them.
#pragma once

#include <vector>

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

}  // namespace identify
