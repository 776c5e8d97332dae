// import kerbstone.
#include "reports.h"
#include "road.h"

PYBIND11_MODULE(kerbstone, m) {
  namespace py = pybind11;
  m.doc() =
      "Roads for vehicle dynamics: built from meshes, refined from scans, and a car that drives on "
      "them.\n\n"
      "Metres, seconds, kilograms, kelvin and radians. u runs along the reference line, v to its "
      "left; x and y are map\n"
      "coordinates. A place without road gives NaN. Where a file or a value cannot be used: "
      "kerbstone.Error.";
  m.attr("__version__") = KERBSTONE_VERSION;
  kerbstone::add_errors(m);
  kerbstone::add_road(m);
  kerbstone::add_car(m);
  kerbstone::add_replay(m);
  kerbstone::add_log(m);
  kerbstone::add_build(m);
  kerbstone::add_refine(m);
  kerbstone::add_explain(m);
  kerbstone::add_identify(m);
}
