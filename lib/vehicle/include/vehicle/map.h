// Maps from files: piecewise linear over one or two axes, held constant outside.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "vehicle/parameters.h"

namespace vehicle {

/// y over x. x ascending, both of equal length; empty: no map given.
struct Map1 {
  std::vector<double> x, y;
  bool empty() const { return x.empty(); }
};

/// z over x and y, z[i * y.size() + j] at (x[i], y[j]). Axes ascending; empty: no map given.
struct Map2 {
  std::vector<double> x, y, z;
  bool empty() const { return z.empty(); }
};

/// Throws Error naming `name` unless axes ascend strictly, sizes fit and all values are finite.
void check_map(const Map1& map, const std::string& name);
void check_map(const Map2& map, const std::string& name);

namespace map_detail {

/// Cell of `axis` around v, and the place in it, held in [0, 1].
template <class T>
struct Place {
  std::size_t cell;
  T fraction;
};

template <class T>
Place<T> place(const std::vector<double>& axis, const T& v) {
  const double at = value_of(v);
  if (axis.size() < 2 || !(at > axis.front())) return {0, T(0)};
  if (at >= axis.back()) return {axis.size() - 2, T(1)};
  const std::size_t cell =
      static_cast<std::size_t>(std::upper_bound(axis.begin(), axis.end(), at) - axis.begin()) - 1;
  return {cell, (v - axis[cell]) / (axis[cell + 1] - axis[cell])};
}

}  // namespace map_detail

/// The map at x; derivatives are those of the cell. Precondition: checked and not empty.
template <class T>
T evaluate(const Map1& map, const T& x) {
  if (map.x.size() < 2) return T(map.y.front());
  const auto at = map_detail::place(map.x, x);
  return map.y[at.cell] + at.fraction * (map.y[at.cell + 1] - map.y[at.cell]);
}

template <class T>
T evaluate(const Map2& map, const T& x, const T& y) {
  const auto i = map_detail::place(map.x, x);
  const auto j = map_detail::place(map.y, y);
  const std::size_t n = map.y.size();
  const std::size_t i1 = map.x.size() < 2 ? i.cell : i.cell + 1;
  const std::size_t j1 = n < 2 ? j.cell : j.cell + 1;
  const double* const z = map.z.data();
  const T low = z[i.cell * n + j.cell] + j.fraction * (z[i.cell * n + j1] - z[i.cell * n + j.cell]);
  const T high = z[i1 * n + j.cell] + j.fraction * (z[i1 * n + j1] - z[i1 * n + j.cell]);
  return low + i.fraction * (high - low);
}

}  // namespace vehicle
