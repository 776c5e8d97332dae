#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "circuit/circuit.h"
#include "circuit_surface.h"
#include "mesh/error.h"

namespace road {
namespace {

// The tool leaves this gap between the last row of a closed CRG and the first: every reader closes
// it.
constexpr double kSeamGapM = 0.001;

}  // namespace

crg::Crg truth_crg(const Circuit& circuit, double step_m) {
  const Circuit::Data& data = circuit.data();
  if (!(step_m >= 0.01) || !(step_m <= data.length_m / 2)) {
    throw Error(
        fmt::format("truth step is {} m; give 0.01 to {:.1f} m", step_m, data.length_m / 2));
  }
  const double length = data.length_m - (data.design.closed ? kSeamGapM : 0.0);
  const auto rows = static_cast<std::size_t>(std::ceil(length / step_m - 1e-9)) + 1;
  crg::ReferenceLine line;
  line.u_step_m = length / static_cast<double>(rows - 1);
  line.closed = data.design.closed;
  std::vector<double> u(rows);
  double right = 0.0;
  double left = 0.0;
  for (std::size_t i = 0; i < rows; ++i) {
    u[i] = static_cast<double>(i) * line.u_step_m;
    const ReferencePoint point = reference(data, u[i]);
    line.x_m.push_back(point.x_m);
    line.y_m.push_back(point.y_m);
    line.heading_rad.push_back(
        i == 0 ? point.heading_rad
               : std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]));
    const CrossSection cross = section(data, u[i]);
    right = std::min(right, cross.outer_right_m);
    left = std::max(left, cross.outer_left_m);
  }
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  const auto first = static_cast<int>(std::ceil(right / step_m));
  const auto last = static_cast<int>(std::floor(left / step_m));
  for (int k = first; k <= last; ++k) grid.v_m.push_back(k * step_m);
  const std::size_t columns = grid.v_m.size();
  grid.z_m.resize(rows * columns);
  constexpr std::size_t kBlock = 256;  // bounds the memory for roughness in double
  std::vector<double> z;
  for (std::size_t begin = 0; begin < rows; begin += kBlock) {
    const std::size_t end = std::min(rows, begin + kBlock);
    z.assign((end - begin) * columns, 0.0);
    for (std::size_t i = begin; i < end; ++i) {
      const CircuitRow row = row_at(data, u[i]);
      for (std::size_t j = 0; j < columns; ++j) {
        z[(i - begin) * columns + j] = smooth_height(row, grid.v_m[j]);
      }
    }
    data.roughness.add_grid(std::span(u).subspan(begin, end - begin), grid.v_m, z);
    for (std::size_t k = 0; k < z.size(); ++k) {
      grid.z_m[begin * columns + k] = static_cast<float>(z[k]);
    }
  }
  if (data.design.closed) {
    std::copy_n(grid.z_m.begin(), columns, grid.z_m.end() - static_cast<std::ptrdiff_t>(columns));
  }
  return crg::make_crg(line, std::move(grid),
                       {"Exact heights of the circuit '" + data.design.name + "'"});
}

}  // namespace road
