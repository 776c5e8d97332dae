#include <fmt/format.h>

#include "base/csv.h"
#include "base/error.h"
#include "commands.h"

namespace crgsim {
sim::UnitInputs read_inputs(const std::string& path) {
  sim::UnitInputs inputs;
  if (path.empty()) return inputs;
  const base::CsvTable table = base::read_whole_csv(path, {"time_s"});
  inputs.names.assign(table.names.begin() + 1, table.names.end());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double time_s = table.value(row, 0);
    if (row > 0 && time_s <= inputs.time_s.back())
      throw base::Error(fmt::format("{}:{}: time_s is {}; later than the row before wanted", path,
                                    table.line[row], time_s));
    inputs.time_s.push_back(time_s);
    for (std::size_t k = 1; k < table.columns; ++k) inputs.values.push_back(table.value(row, k));
  }
  return inputs;
}

}  // namespace crgsim
