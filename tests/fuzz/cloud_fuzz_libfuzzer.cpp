// Entry of libFuzzer: the first byte chooses the reader, the rest is the file.
#include <cstddef>
#include <cstdint>

#include "fuzz/cloud_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  cloud::fuzz::run(cloud::fuzz::kKinds[data[0] % cloud::fuzz::kKinds.size()],
                   {reinterpret_cast<const char*>(data) + 1, size - 1});
  return 0;
}
