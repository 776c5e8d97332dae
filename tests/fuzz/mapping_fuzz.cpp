// mapping.yaml, read, written and read back; and the mapping that is proposed for a log.
#include "base/error.h"
#include "explain/mapping.h"
#include "fuzz/target.h"
#include "recording/log_table.h"

namespace {

void read_back(const explain::Mapping& mapping) {
  const std::string path = fuzz::folder().put("again.yaml", explain::format_mapping(mapping));
  const recording::Mapping again = recording::read_mapping(path);
  fuzz::require(again.columns.size() == mapping.columns.size(), "as many columns as were written");
  for (std::size_t k = 0; k < again.columns.size(); ++k)
    fuzz::require(again.columns[k].column == mapping.columns[k].column &&
                      again.columns[k].channel == mapping.columns[k].channel,
                  "the columns that were written");
}

}  // namespace

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put("mapping.yaml", bytes);
  try {
    read_back({recording::read_mapping(path), {}, {}, {}});
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
  try {
    const recording::Table log = recording::parse_log_table(std::string(bytes), path);
    read_back(explain::propose_mapping(log, path));
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
}
