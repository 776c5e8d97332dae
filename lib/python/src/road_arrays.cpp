#include "road_arrays.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <span>
#include <string>

#include "crg/surface.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

std::span<const double> all(const Numbers& a) {
  return {a.data(), static_cast<std::size_t>(a.size())};
}

}  // namespace

std::pair<Numbers, Numbers> alike(const py::object& a, const py::object& b) {
  Numbers first(a), second(b);
  if (!first || !second) throw py::error_already_set();
  if (first.ndim() == second.ndim() &&
      std::equal(first.shape(), first.shape() + first.ndim(), second.shape()))
    return {first, second};
  const py::list both = py::module_::import("numpy").attr("broadcast_arrays")(first, second);
  return {Numbers(both[0]), Numbers(both[1])};
}

py::object number_or_array(const py::array_t<double>& a) {
  if (a.ndim() == 0) return py::float_(*a.data());
  return a;
}

py::object z_of_arrays(const Road& road, const py::object& x_m, const py::object& y_m) {
  const auto [x, y] = alike(x_m, y_m);
  py::array_t<double> out = shaped_as<double>(x);
  double* const z = out.mutable_data();
  {
    py::gil_scoped_release free;
    crg::Cursor cursor;
    road.surface.z_at_xy(all(x), all(y), {z, static_cast<std::size_t>(out.size())}, cursor);
  }
  return number_or_array(out);
}

py::object z_of_uv_arrays(const Road& road, const py::object& u_m, const py::object& v_m) {
  const auto [u, v] = alike(u_m, v_m);
  py::array_t<double> out = shaped_as<double>(u);
  double* const z = out.mutable_data();
  {
    py::gil_scoped_release free;
    for (py::ssize_t k = 0; k < u.size(); ++k)
      z[k] = road.surface.z_at_uv(u.data()[k], v.data()[k]);
  }
  return number_or_array(out);
}

py::object samples_of_arrays(const Road& road, const py::object& x_m, const py::object& y_m) {
  const auto [x, y] = alike(x_m, y_m);
  if (x.ndim() == 0) {
    crg::Cursor cursor;
    return py::cast(road.surface.at_xy(*x.data(), *y.data(), cursor));
  }
  py::array_t<crg::Sample> out = shaped_as<crg::Sample>(x);
  crg::Sample* const samples = out.mutable_data();
  {
    py::gil_scoped_release free;
    crg::Cursor cursor;
    road.surface.at_xy(all(x), all(y), {samples, static_cast<std::size_t>(out.size())}, cursor);
  }
  return out.attr("view")(py::module_::import("numpy").attr("recarray"));
}

py::array_t<float> strip_of(Road& road, double x_m, double y_m, double heading_rad,
                            std::size_t along, std::size_t across, double step_m) {
  if (along < 1 || across < 1 || along > 100000 || across > 100000 || along * across > 10000000)
    throw py::value_error("a strip of 1 to 10,000,000 samples wanted");
  if (!(step_m > 0)) throw py::value_error("step_m: more than 0 wanted");
  py::array_t<float> out({static_cast<py::ssize_t>(along), static_cast<py::ssize_t>(across)});
  const double base_m = road.surface.strip({.x_m = x_m,
                                            .y_m = y_m,
                                            .ahead = {std::cos(heading_rad), std::sin(heading_rad)},
                                            .along = along,
                                            .across = across,
                                            .step_m = step_m},
                                           {out.mutable_data(), along * across}, road.cursor);
  for (float *z = out.mutable_data(), *end = z + along * across; z != end; ++z)
    *z = static_cast<float>(base_m + static_cast<double>(*z));
  return out;
}

}  // namespace kerbstone
