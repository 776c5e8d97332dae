// Large arrays on large pages: random reads of a long road otherwise miss the address cache too.
#pragma once

#include <cstddef>
#include <vector>

namespace crg {

/// Asks the system for large pages under memory that has not been touched yet; only those that lie
/// within it, so that no more becomes resident. Does nothing where there are none.
void prefer_huge_pages(void* memory, std::size_t bytes) noexcept;

template <typename T>
void reserve_huge(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  prefer_huge_pages(values.data(), values.capacity() * sizeof(T));
}

}  // namespace crg
