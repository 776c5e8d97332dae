// The road that Python holds, and what each source adds to the module.
#pragma once

#include <pybind11/pybind11.h>

#include "crg/surface.h"

namespace kerbstone {

/// A road that is evaluated, and where the last single query was; the interpreter's lock guards
/// that.
struct Road {
  crg::Surface surface;
  crg::SurfaceOptions options = {};  ///< that it was made with, for pickling
  crg::Cursor cursor = {};
};

void add_road(pybind11::module_& m);
void add_car(pybind11::module_& m);
void add_replay(pybind11::module_& m);  ///< after add_car()
void add_log(pybind11::module_& m);

}  // namespace kerbstone
