// A summary of a drive: read, written and read back, and taken into a joint estimate. The bytes go
// without the check at their end, which no mutant would have right.
#include <cmath>

#include "base/archive.h"
#include "base/error.h"
#include "explain/fleet.h"
#include "fuzz/target.h"

void fuzz::run(std::string_view bytes) {
  std::string file(bytes);
  const std::uint64_t check = base::checksum(file);
  file.append(reinterpret_cast<const char*>(&check), 8);
  try {
    explain::summary_from_bytes(bytes, "file.summary");
  } catch (const base::Error& error) {
    require_refusal(error, "file.summary");
  }
  try {
    const explain::DriveSummary read = explain::summary_from_bytes(file, "file.summary");
    require(explain::to_bytes(read) == file, "the bytes that were read");
    if (read.columns.size() > 20 || read.knots > 12) return;  // time
    try {
      const explain::FleetFindings found =
          explain::explain_fleet(1, [&](std::size_t) { return read; }, {1, {}});
      for (const explain::FleetFinding& f : found.findings)
        require(std::isfinite(f.amount) && std::isfinite(f.gain), "amounts that are numbers");
    } catch (const base::Error& error) {
      require(std::string_view(error.what()).find('\n') == std::string_view::npos,
              "a refusal of one line");
    }
  } catch (const base::Error& error) {
    require_refusal(error, "file.summary");
  }
}
