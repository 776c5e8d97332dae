// Entry for libFuzzer, with a limit on what one input may make the library allocate.
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "fuzz/crg_fuzz.h"

namespace {
std::size_t live_bytes = 0, peak_bytes = 0;
}

void* operator new(std::size_t size) {
  void* memory = std::malloc(size != 0 ? size : 1);
  if (memory == nullptr) throw std::bad_alloc();
  live_bytes += malloc_usable_size(memory);
  if (live_bytes > peak_bytes) peak_bytes = live_bytes;
  return memory;
}
void operator delete(void* memory) noexcept {
  if (memory != nullptr) live_bytes -= std::min(live_bytes, malloc_usable_size(memory));
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }

void* operator new(std::size_t size, std::align_val_t alignment) {
  const std::size_t step = static_cast<std::size_t>(alignment);
  void* memory = std::aligned_alloc(step, (size + step - 1) / step * step);
  if (memory == nullptr) throw std::bad_alloc();
  live_bytes += malloc_usable_size(memory);
  if (live_bytes > peak_bytes) peak_bytes = live_bytes;
  return memory;
}
void operator delete(void* memory, std::align_val_t) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { operator delete(memory); }

// The fuzzer's own allocations pass through nothrow new, which stays as it was.
extern "C" const char* __asan_default_options() { return "alloc_dealloc_mismatch=0"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::size_t before = live_bytes;
  peak_bytes = live_bytes;
  crg::fuzz::run(data, size);
  // 64 MB beyond the file's own size; the target itself keeps two copies of the input.
  if (peak_bytes - before > (std::size_t{64} << 20) + 3 * size) {
    std::fprintf(stderr, "peak of %zu bytes for an input of %zu\n", peak_bytes - before, size);
    std::abort();
  }
  return 0;
}
