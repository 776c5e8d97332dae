// How a car drove beside the line that is usually driven.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "explain/banking_by_turning.h"

namespace explain {

/// At the steps of a recording: to the left of the usual line, m; its first derivative along the
/// road, m/m, and its second, 1/m, both of a parabola through the metres around. NaN: not known, or
/// the car leaves the line or comes to it.
struct OffTheLine {
  std::vector<double> beside_m, slope, bend_1pm;
};

/// `line_v_m`: the usual line at places that are equally far apart.
OffTheLine off_the_line(const Turning& log, const Eigen::VectorXd& line_v_m, double length_m,
                        bool closed);

}  // namespace explain
