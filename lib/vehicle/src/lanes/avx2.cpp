// The laws compiled once more, for packs of 4: with options of its own (CMakeLists.txt), so nothing
// in it may be code that other sources share.
#if defined(__x86_64__)
#include "native.h"
#include "pack_step.h"

namespace vehicle::many {

std::unique_ptr<Kernel> make_avx2_kernel(std::span<const Car<double>* const> cars) {
  return std::make_unique<PackKernel<4>>(cars);
}

}  // namespace vehicle::many
#endif
