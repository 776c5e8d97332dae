// z(u, v): grid, reference line height and banking, with border modes, offsets and smoothing.
#pragma once

#include <cstddef>
#include <vector>

#include "closing.h"
#include "crg/file.h"
#include "crg/options.h"

namespace crg {

/// Height and its derivatives along u and v; NaN where there is no road.
struct Height {
  double z_m;
  double dzdu, dzdv;
};

/// Everything that height needs. Refers to the vectors of a Crg and a ReferenceLine that must
/// outlive it.
class HeightField {
 public:
  HeightField(const Grid& grid, const ReferenceLine& line, const Options& options);

  Height at(double u_m, double v_m) const noexcept;

  /// u of a closed track within [begin - before, end + after); other tracks unchanged.
  double wrap_u(double u_m) const noexcept;

  double u_end_m() const { return u_end_m_; }
  double v_right_m() const { return v_m_.front(); }
  double v_left_m() const { return v_m_.back(); }

 private:
  std::size_t column_of(double v_m) const noexcept;

  const float* z_m_;
  const std::vector<double>& v_m_;
  const std::vector<double>& line_z_m_;
  const std::vector<double>& banking_;
  Options options_;
  std::size_t rows_, columns_;
  double u_begin_m_, u_end_m_, u_step_m_;
  double uniform_v_step_m_ = 0.0;  ///< 0 where v spacing varies
  double period_m_ = 0.0;          ///< 0 where the track is not closed
  double wrap_begin_m_ = 0.0;
};

}  // namespace crg
