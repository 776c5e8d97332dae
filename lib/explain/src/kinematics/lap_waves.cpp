#include "lap_waves.h"

#include <cmath>
#include <numbers>

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;

double wave_turns(std::size_t column, bool closed) {
  const std::size_t whole = (column + 1) / 2;
  return closed ? static_cast<double>(whole) : 0.5 * static_cast<double>(column);
}

MatrixXd waves(std::size_t places, std::size_t columns, bool closed) {
  MatrixXd out(static_cast<Index>(places), static_cast<Index>(columns));
  for (Index i = 0; i < out.rows(); ++i) {
    const double lap = static_cast<double>(i) / static_cast<double>(closed ? places : places - 1);
    for (Index k = 0; k < out.cols(); ++k) {
      const double angle =
          2 * std::numbers::pi * wave_turns(static_cast<std::size_t>(k), closed) * lap;
      out(i, k) = closed && k % 2 == 0 && k > 0 ? std::sin(angle) : std::cos(angle);
    }
  }
  return out;
}

}  // namespace explain
