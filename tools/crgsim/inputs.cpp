#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "base/csv.h"
#include "base/error.h"
#include "base/read_file.h"
#include "commands.h"

namespace crgsim {
namespace {

/// Names of the columns but time_s. Names of variables may hold commas only where quoted.
std::vector<std::string> columns_of(const std::string& path) {
  base::want_regular_file(path);
  std::ifstream file(path);
  std::string header;
  std::getline(file, header);
  std::vector<std::string> names(1);
  bool quoted = false;
  for (const char c : header) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      names.emplace_back();
    else if (c != '\r')
      names.back() += c;
  }
  std::erase(names, "time_s");
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
    throw base::Error(fmt::format("{}:1: two columns are called '{}'; take one away", path,
                                  twice->substr(0, 60)));
  return names;
}

}  // namespace

sim::UnitInputs read_inputs(const std::string& path) {
  sim::UnitInputs inputs;
  if (path.empty()) return inputs;
  inputs.names = columns_of(path);
  std::vector<std::string> wanted{"time_s"};
  wanted.insert(wanted.end(), inputs.names.begin(), inputs.names.end());
  const base::CsvTable table = base::read_csv(path, wanted);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double time_s = table.value(row, 0);
    if (!std::isfinite(time_s) || (row > 0 && time_s <= inputs.time_s.back()))
      throw base::Error(fmt::format("{}:{}: time_s is {}; later than the row before wanted", path,
                                    table.line[row], time_s));
    inputs.time_s.push_back(time_s);
    for (std::size_t k = 1; k < table.columns; ++k) {
      if (!std::isfinite(table.value(row, k)))
        throw base::Error(fmt::format("{}:{}: no value of {}; fill it in", path, table.line[row],
                                      inputs.names[k - 1]));
      inputs.values.push_back(table.value(row, k));
    }
  }
  return inputs;
}

}  // namespace crgsim
