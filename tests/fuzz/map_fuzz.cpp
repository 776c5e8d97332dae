// Maps of a car, over one axis and over two; files that begin as MATLAB's do are read as such.
#include <cmath>

#include "base/error.h"
#include "fuzz/target.h"
#include "map_file.h"

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put(bytes.starts_with("MATLAB") ? "map.mat" : "map.csv", bytes);
  try {
    const vehicle::Map1 map = vehicle::read_map1(path, "x", "value");
    for (const double x : {-1e300, -1.0, 0.0, 0.5, 1e300})
      require(!std::isnan(vehicle::evaluate(map, x)), "a value everywhere");
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
  try {
    const vehicle::Map2 map = vehicle::read_map2(path, "x", "y", "value");
    for (const double x : {-1e300, -1.0, 0.0, 0.5, 1e300})
      require(!std::isnan(vehicle::evaluate(map, x, 2.0 * x)), "a value everywhere");
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
}
