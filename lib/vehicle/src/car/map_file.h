// Maps from CSV or MATLAB files. Private to the vehicle reader.
#pragma once

#include <string>
#include <vector>

#include "vehicle/map.h"

namespace vehicle {

/// Reads a map whose axes are called `x` and `y` (with unit) and whose values are called `value`.
/// CSV: Map1 has the columns x,value; Map2 has the first header cell "x:y" and the places of y as
/// the other header cells, then rows of place, values. MATLAB: variables of these names, the value
/// with one row per place of x. Throws Error.
Map1 read_map1(const std::string& path, const std::string& x, const std::string& value);
Map2 read_map2(const std::string& path, const std::string& x, const std::string& y,
               const std::string& value);

/// One real variable of a MATLAB file, row after row. Throws Error.
struct Matrix {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;
};
Matrix read_mat_variable(const std::string& path, const std::string& name);

}  // namespace vehicle
