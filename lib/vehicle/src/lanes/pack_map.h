// Maps asked by a pack of cars: each lane gets the cell and the numbers of the single lookup.
#pragma once

#include "vehicle/map.h"

namespace vehicle {

namespace map_detail {

template <int N>
struct PackPlace {
  std::array<std::size_t, N> cell;
  Pack<N> fraction;
};

template <int N>
PackPlace<N> place(const std::vector<double>& axis, const Pack<N>& v) {
  PackPlace<N> out{{}, Pack<N>(0.0)};
  const std::size_t n = axis.size();
  if (n < 2) return out;
  // How many inner nodes lie at or below the value.
  typename Mask<N>::Vector below{};
  const double* const node = axis.data();
  for (std::size_t k = 1; k + 1 < n; ++k) below -= (v >= Pack<N>(node[k])).v;
  Pack<N> low(0.0), high(0.0);
  for (std::size_t lane = 0; lane < N; ++lane) {
    out.cell[lane] = static_cast<std::size_t>(below[lane]);
    low.set(lane, node[out.cell[lane]]);
    high.set(lane, node[out.cell[lane] + 1]);
  }
  const Pack<N> between = (v - low) / (high - low);
  out.fraction = select(v > Pack<N>(node[0]), between, Pack<N>(0.0));
  out.fraction = select(v >= Pack<N>(node[n - 1]), Pack<N>(1.0), out.fraction);
  return out;
}

template <int N, class Index>
Pack<N> looked_up(const std::vector<double>& values, const Index& index) {
  const double* const from = values.data();
  Pack<N> out(0.0);
  for (std::size_t lane = 0; lane < N; ++lane) out.set(lane, from[index(lane)]);
  return out;
}

}  // namespace map_detail

template <int N>
Pack<N> evaluate(const Map1& map, const Pack<N>& x) {
  if (map.x.size() < 2) return Pack<N>(map.y.data()[0]);
  const auto at = map_detail::place(map.x, x);
  const auto value = [&](std::size_t more) {
    return map_detail::looked_up<N>(map.y, [&](std::size_t lane) { return at.cell[lane] + more; });
  };
  const Pack<N> low = value(0);
  return low + at.fraction * (value(1) - low);
}

template <int N>
Pack<N> evaluate(const Map2& map, const Pack<N>& x, const Pack<N>& y) {
  const auto i = map_detail::place(map.x, x);
  const auto j = map_detail::place(map.y, y);
  const std::size_t n = map.y.size();
  const std::size_t di = map.x.size() < 2 ? 0 : 1, dj = n < 2 ? 0 : 1;
  const auto value = [&](std::size_t more_i, std::size_t more_j) {
    return map_detail::looked_up<N>(map.z, [&](std::size_t lane) {
      return (i.cell[lane] + more_i) * n + j.cell[lane] + more_j;
    });
  };
  const auto along_y = [&](std::size_t more_i) {
    const Pack<N> near = value(more_i, 0);
    return near + j.fraction * (value(more_i, dj) - near);
  };
  const Pack<N> low = along_y(0), high = along_y(di);
  return low + i.fraction * (high - low);
}

}  // namespace vehicle
