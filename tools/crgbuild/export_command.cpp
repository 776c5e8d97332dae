// A road in a format of other programs, and what that format cannot hold.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/file.h"
#include "crg/options.h"
#include "road/track_widths.h"

namespace crgbuild {
namespace {

/// Largest distance between neighbouring columns: by so much a width can be short.
double widest_column_m(const crg::Grid& grid) {
  double widest = 0.0;
  for (std::size_t j = 1; j < grid.columns(); ++j)
    widest = std::max(widest, grid.v_m[j] - grid.v_m[j - 1]);
  return widest;
}

}  // namespace

int run_export(const ExportCommand& command, Terminal& terminal) {
  const crg::Crg crg = crg::apply_modifiers(crg::read(command.crg));
  const auto widths = road::track_widths(crg::integrate_reference_line(crg), crg.grid);
  base::write_file(command.output, road::track_widths_csv(widths));
  const double short_by_m = widest_column_m(crg.grid);
  if (terminal.json) {
    nlohmann::ordered_json out;
    out["file"] = command.output;
    out["format"] = "tum";
    out["points"] = widths.size();
    out["width_short_by_at_most_m"] = short_by_m;
    out["lost"] = {"heights", "banking", "kerbs", "road beyond holes"};
    terminal.print(base::json_text(out));
  } else {
    terminal.print(fmt::format(
        "{} points; widths end at a column, up to {:.3f} m inside the edge\n"
        "lost     heights, banking, kerbs, road beyond holes: the format has no place for them\n"
        "file     {}\n",
        widths.size(), short_by_m, command.output));
  }
  return kOk;
}

}  // namespace crgbuild
