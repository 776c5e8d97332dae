// A strip: the rectangle of samples that a tyre's contact patch looks at.
#pragma once

#include <cstddef>

namespace crg {

/// Which code evaluates a strip. All give the same bits.
enum class StripKernel {
  Best,    ///< the fastest that this processor runs
  Scalar,  ///< any processor
  Avx2,    ///< x86 with AVX2; Scalar elsewhere
  Avx512   ///< x86 with AVX-512; Scalar elsewhere
};

/// along x across samples, step_m apart, centred on (x, y); `along` counts in the direction of
/// heading, `across` to the left of it.
struct Strip {
  double x_m = 0.0, y_m = 0.0;
  double heading_rad = 0.0;  ///< CCW from +x
  std::size_t along = 10, across = 40;
  double step_m = 0.01;
  StripKernel kernel = StripKernel::Best;
};

/// Whether this processor has what the kernel needs.
bool available(StripKernel kernel);

}  // namespace crg
