// A strip: the rectangle of samples that a tyre's contact patch looks at.
#pragma once

#include <cstddef>
#include <functional>

#include "crg/reference_line.h"

namespace crg {

/// Which code evaluates a strip. All give the same bits.
enum class StripKernel {
  Best,    ///< the fastest that this processor runs
  Scalar,  ///< any processor
  Avx2,    ///< x86 with AVX2; Scalar elsewhere
  Avx512   ///< x86 with AVX-512; Scalar elsewhere
};

/// along x across samples, step_m apart, centred on (x, y); `along` counts in the direction of
/// `ahead`, `across` to the left of it.
struct Strip {
  double x_m = 0.0, y_m = 0.0;
  Point2 ahead{1.0, 0.0};  ///< direction of travel, of length 1
  std::size_t along = 10, across = 40;
  double step_m = 0.01;
  StripKernel kernel = StripKernel::Best;
};

/// Rows of samples of a strip, [begin, end).
struct StripRows {
  std::size_t begin, end;
};

/// Asked once, when the first rows are filled: which are wanted in all, those first ones among
/// them? No sample before them is above before_m, none behind above after_m, both relative to
/// base_m; infinite where only a look would tell: then all rows are filled already.
using MoreRows = std::function<StripRows(double base_m, float before_m, float after_m)>;

/// Whether this processor has what the kernel needs.
bool available(StripKernel kernel);

}  // namespace crg
