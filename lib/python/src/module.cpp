// import kerbstone.
#include "crg/error.h"
#include "road.h"
#include "vehicle/error.h"

PYBIND11_MODULE(kerbstone, m) {
  namespace py = pybind11;
  m.doc() =
      "Roads for vehicle dynamics, and a car that drives on them.\n\n"
      "Metres, seconds, kilograms, kelvin and radians. u runs along the reference line, v to its "
      "left; x and y are map\n"
      "coordinates. A place without road gives NaN. Where a file or a value cannot be used: "
      "kerbstone.Error.";
  m.attr("__version__") = KERBSTONE_VERSION;
  const auto& error = py::register_exception<crg::Error>(m, "Error", PyExc_RuntimeError);
  static const py::handle raised = error;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const vehicle::Error& e) {
      PyErr_SetString(raised.ptr(), e.what());
    }
  });
  kerbstone::add_road(m);
  kerbstone::add_car(m);
  kerbstone::add_replay(m);
}
