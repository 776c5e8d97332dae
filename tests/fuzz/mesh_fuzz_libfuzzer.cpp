// libFuzzer entry: the first byte chooses the kind of file.
#include <cstddef>
#include <cstdint>

#include "fuzz/mesh_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  constexpr std::size_t kinds = sizeof road::fuzz::kKinds / sizeof road::fuzz::kKinds[0];
  road::fuzz::run(road::fuzz::kKinds[data[0] % kinds],
                  std::string_view(reinterpret_cast<const char*>(data + 1), size - 1));
  return 0;
}
