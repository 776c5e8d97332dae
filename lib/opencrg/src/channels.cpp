#include "channels.h"

namespace opencrg {
namespace {

CrgChannelStruct channel_of(std::vector<double>& values, double step) {
  return {{values.front(), values.back(), step, 0.0, values.size()}, values.data()};
}

}  // namespace

void Channels::take(const crg::Surface& surface) {
  const crg::Grid& grid = surface.grid();
  const crg::ReferenceLine& line = surface.reference_line();
  const std::size_t rows = grid.rows();
  u_m_.clear();
  z_m_.assign(grid.columns(), std::vector<float>(rows));
  for (std::size_t i = 0; i < rows; ++i) {
    u_m_.push_back(grid.u_of(i));
    for (std::size_t j = 0; j < grid.columns(); ++j) z_m_[j][i] = grid.at(i, j);
  }
  v_m_ = grid.v_m;
  x_m_ = line.x_m;
  y_m_ = line.y_m;
  line_z_m_ = line.z_m.empty() ? std::vector<double>(rows, 0.0) : line.z_m;
  z_.clear();
  for (std::vector<float>& z : z_m_)
    z_.push_back({{z.front(), z.back(), grid.u_step_m, 0.0, rows}, z.data()});
  seen_ = {channel_of(u_m_, grid.u_step_m),
           channel_of(v_m_, (v_m_.back() - v_m_.front()) / static_cast<double>(v_m_.size() - 1)),
           channel_of(x_m_, 0.0),
           channel_of(y_m_, 0.0),
           channel_of(line_z_m_, grid.u_step_m),
           z_.data()};
}

}  // namespace opencrg
