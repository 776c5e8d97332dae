#include "write_telemetry.h"

#include "base/write_file.h"
#include "recording/telemetry_mcap.h"

namespace crgdrive {

bool is_mcap(const std::string& path) { return path.ends_with(".mcap"); }

void write_telemetry(const std::string& path, const std::string& from,
                     const recording::Table& table, int digits) {
  base::write_file(path, is_mcap(path) ? recording::format_mcap(table, from)
                                       : from + recording::format_table(table, digits));
}

}  // namespace crgdrive
