// Values at places of a sorted sample, without sorting it.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>
#include <vector>

namespace base {

/// The value at place floor(share * (n - 1)) of the n sorted values: no interpolation. `share`
/// within 0 to 1; at least one value, none of them NaN.
template <class T>
T quantile(std::vector<T> values, double share) {
  assert(!values.empty() && share >= 0.0 && share <= 1.0);
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The value at place n / 2 of the n sorted values: of an even number the upper of the two in the
/// middle. At least one value, none of them NaN.
template <class T>
T median(std::vector<T> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The same, and `if_empty` of no values.
template <class T>
T median_or(T if_empty, std::vector<T> values) {
  return values.empty() ? if_empty : median(std::move(values));
}

}  // namespace base
