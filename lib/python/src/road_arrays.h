// A road's numbers as numpy arrays: queries of many points, and views of what it holds.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "road.h"

namespace kerbstone {

using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// Both as arrays of one shape.
std::pair<Numbers, Numbers> alike(const pybind11::object& a, const pybind11::object& b);

template <class T>
pybind11::array_t<T> shaped_as(const Numbers& a) {
  return pybind11::array_t<T>(std::vector<pybind11::ssize_t>(a.shape(), a.shape() + a.ndim()));
}

/// Whole numbers come here too: for Python they are no floats.
pybind11::object number_or_array(const pybind11::array_t<double>& a);

/// Two answers per pair.
template <class Answer>
std::pair<pybind11::object, pybind11::object> two_of_arrays(const pybind11::object& a,
                                                            const pybind11::object& b,
                                                            Answer answer) {
  const auto [first, second] = alike(a, b);
  pybind11::array_t<double> one = shaped_as<double>(first), two = shaped_as<double>(first);
  double *const o = one.mutable_data(), *const t = two.mutable_data();
  {
    pybind11::gil_scoped_release free;
    for (pybind11::ssize_t k = 0; k < first.size(); ++k)
      std::tie(o[k], t[k]) = answer(first.data()[k], second.data()[k]);
  }
  return {number_or_array(one), number_or_array(two)};
}

/// Answers of the road for numbers or arrays (docstrings in road.cpp).
pybind11::object z_of_arrays(const Road& road, const pybind11::object& x_m,
                             const pybind11::object& y_m);
pybind11::object z_of_uv_arrays(const Road& road, const pybind11::object& u_m,
                                const pybind11::object& v_m);
pybind11::object samples_of_arrays(const Road& road, const pybind11::object& x_m,
                                   const pybind11::object& y_m);
pybind11::array_t<float> strip_of(Road& road, double x_m, double y_m, double heading_rad,
                                  std::size_t along, std::size_t across, double step_m);

/// The road's own numbers, not to be written to; the road lives as long as they do.
template <class T>
pybind11::array_t<T> view_of(const pybind11::object& road, const std::vector<T>& values,
                             std::vector<pybind11::ssize_t> shape) {
  pybind11::array_t<T> out(std::move(shape), values.data(), road);
  pybind11::detail::array_proxy(out.ptr())->flags &=
      ~pybind11::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return out;
}

}  // namespace kerbstone
