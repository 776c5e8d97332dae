#include "map_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "base/ending.h"
#include "recording/table.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

bool is_matlab(const std::string& path) { return base::ending_of(path) == ".mat"; }

void require_exists(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw Error(path + ": no such file");
}

std::vector<double> read_vector(const std::string& path, const std::string& name) {
  Matrix m = read_mat_variable(path, name);
  if (m.rows != 1 && m.columns != 1)
    throw Error(fmt::format("{}: '{}' is {} x {}, wanted one row or one column", path, name, m.rows,
                            m.columns));
  return std::move(m.values);
}

void require_filled(const std::vector<double>& values, const std::string& path) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(fmt::format("{}: value {} is empty or not finite", path, i + 1));
}

}  // namespace

Map1 read_map1(const std::string& path, const std::string& x, const std::string& value) {
  require_exists(path);
  Map1 map;
  if (is_matlab(path)) {
    map.x = read_vector(path, x);
    map.y = read_vector(path, value);
  } else {
    const recording::Table table = recording::read_table(path, base::Gaps::refused);
    const auto* const places = table.find(x);
    const auto* const values = table.find(value);
    if (places == nullptr || values == nullptr || table.names.size() != 2)
      throw Error(fmt::format("{}: wanted the columns '{}' and '{}'", path, x, value));
    map.x = *places;
    map.y = *values;
  }
  require_filled(map.x, path);
  require_filled(map.y, path);
  check_map(map, path);
  if (map.empty()) throw Error(path + ": the map has no values");
  return map;
}

Map2 read_map2(const std::string& path, const std::string& x, const std::string& y,
               const std::string& value) {
  require_exists(path);
  Map2 map;
  if (is_matlab(path)) {
    map.x = read_vector(path, x);
    map.y = read_vector(path, y);
    Matrix m = read_mat_variable(path, value);
    if (m.rows != map.x.size() || m.columns != map.y.size())
      throw Error(fmt::format("{}: '{}' is {} x {}, but '{}' has {} and '{}' {} places", path,
                              value, m.rows, m.columns, x, map.x.size(), y, map.y.size()));
    map.z = std::move(m.values);
  } else {
    const recording::Table table = recording::read_table(path, base::Gaps::refused);
    const std::string corner = x + ":" + y;
    if (table.names.front() != corner)
      throw Error(fmt::format("{}: first header cell is '{}', wanted '{}'", path,
                              table.names.front().substr(0, 40), corner));
    for (std::size_t c = 1; c < table.names.size(); ++c) {
      const std::string& cell = table.names[c];
      double place = 0.0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), place);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(place))
        throw Error(fmt::format("{}: header cell {} is '{}', wanted a place of {}", path, c + 1,
                                cell.substr(0, 40), y));
      map.y.push_back(place);
    }
    map.x = table.columns.front();
    for (std::size_t r = 0; r < table.rows(); ++r)
      for (std::size_t c = 1; c < table.columns.size(); ++c) map.z.push_back(table.columns[c][r]);
  }
  require_filled(map.x, path);
  require_filled(map.z, path);
  check_map(map, path);
  if (map.empty()) throw Error(path + ": the map has no values");
  return map;
}

}  // namespace vehicle
