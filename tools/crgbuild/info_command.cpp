#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "commands.h"
#include "crg/file.h"
#include "make/summary.h"

namespace crgbuild {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(crg::Format format) {
  switch (format) {
    case crg::Format::KRBI:
      return "KRBI";
    case crg::Format::KDBI:
      return "KDBI";
    case crg::Format::LRFI:
      return "LRFI";
    case crg::Format::LDFI:
      return "LDFI";
  }
  return "?";
}

Json entries(const std::vector<crg::HeaderEntry>& section) {
  Json out = Json::object();
  for (const crg::HeaderEntry& entry : section) {
    if (entry.key == "*") continue;  // a comment line
    out[entry.key] = entry.text.empty() ? Json(entry.value) : Json(entry.text);
  }
  return out;
}

std::string text_of(const std::vector<crg::HeaderEntry>& section) {
  std::string out;
  for (const crg::HeaderEntry& entry : section)
    if (entry.key != "*")
      out += "  " + entry.key + " = " +
             (entry.text.empty() ? fmt::format("{}", entry.value) : one_line(entry.text)) + "\n";
  return out;
}

struct Range {
  double low = std::nan(""), high = std::nan("");
};

Range range_of(const std::vector<double>& values) {
  Range range;
  for (const double v : values) {
    range.low = std::fmin(range.low, v);
    range.high = std::fmax(range.high, v);
  }
  return range;
}

}  // namespace

int run_info(const InfoCommand& command, Terminal& terminal) {
  const crg::Crg file = crg::read(command.crg);
  const crg::ReferenceLine line = crg::integrate_reference_line(file);
  const road::GridReport grid = road::describe(file.grid, line);
  const Range x = range_of(line.x_m), y = range_of(line.y_m);
  const bool even = grid.v_step_max_m - grid.v_step_min_m < 1e-6;
  const double length_m = grid.u_end_m - grid.u_begin_m;

  if (terminal.json) {
    Json out;
    out["file"] = command.crg;
    out["format"] = name_of(file.format);
    out["comment"] = file.comment;
    out["reference_line"] = {{"length_m", length_m},
                             {"closed", line.closed},
                             {"x_min_m", x.low},
                             {"x_max_m", x.high},
                             {"y_min_m", y.low},
                             {"y_max_m", y.high},
                             {"slope_channel", !file.slope.empty()},
                             {"banking_channel", !file.banking.empty()}};
    out["grid"] = {{"rows", grid.rows},
                   {"columns", grid.columns},
                   {"nodes", grid.nodes},
                   {"nodes_with_z", grid.nodes_with_z},
                   {"holes", grid.holes},
                   {"u_begin_m", grid.u_begin_m},
                   {"u_end_m", grid.u_end_m},
                   {"u_step_m", grid.u_step_m},
                   {"v_min_m", grid.v_min_m},
                   {"v_max_m", grid.v_max_m},
                   {"v_step_min_m", grid.v_step_min_m},
                   {"v_step_max_m", grid.v_step_max_m},
                   {"z_min_m", grid.z_min_m},
                   {"z_max_m", grid.z_max_m},
                   {"width_min_m", grid.width_min_m},
                   {"width_median_m", grid.width_median_m},
                   {"width_max_m", grid.width_max_m}};
    out["wgs84"] = base::parse_json<Json>(road::json_text(road::geo_ends(file)));
    out["road"] = entries(file.road);
    out["options"] = entries(file.options);
    out["modifiers"] = file.has_modifier_section ? entries(file.modifiers) : Json(nullptr);
    out["projection"] = entries(file.projection);
    terminal.print(base::json_text(out));
    return kOk;
  }

  std::string text = fmt::format(
      "{}\n"
      "format   {}\n"
      "line     {:.3f} m, {}; x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m\n"
      "u        {:.3f} to {:.3f} m in steps of {:.6g} m\n"
      "v        {:.3f} to {:.3f} m in {} steps of {}\n"
      "z        {:.3f} to {:.3f} m\n"
      "width    {:.1f} m ({:.1f} to {:.1f} m), all that has a height\n"
      "nodes    {} x {} = {}; {} with height, {} holes\n",
      command.crg, name_of(file.format), length_m, line.closed ? "closed" : "open", x.low, x.high,
      y.low, y.high, grid.u_begin_m, grid.u_end_m, grid.u_step_m, grid.v_min_m, grid.v_max_m,
      even ? "even" : "uneven",
      even ? fmt::format("{:.6g} m", grid.v_step_max_m)
           : fmt::format("{:.6g} to {:.6g} m", grid.v_step_min_m, grid.v_step_max_m),
      grid.z_min_m, grid.z_max_m, grid.width_median_m, grid.width_min_m, grid.width_max_m,
      grid.rows, grid.columns, grid.nodes, grid.nodes_with_z, grid.holes);
  const road::GeoEnds wgs84 = road::geo_ends(file);
  for (const auto& [name, end] : {std::pair("start", wgs84.start), {"end", wgs84.end}}) {
    if (!end) continue;
    text += fmt::format("{:<8} latitude {:.8f}, longitude {:.8f} deg{}\n", name, end->latitude_deg,
                        end->longitude_deg,
                        end->height_m ? fmt::format(", height {:.3f} m", *end->height_m) : "");
  }
  if (!file.modifiers.empty())
    text += "modifiers (the numbers above are those before them)\n" + text_of(file.modifiers);
  if (!file.options.empty()) text += "options\n" + text_of(file.options);
  if (!file.projection.empty()) text += "projection\n" + text_of(file.projection);
  if (!file.comment.empty()) text += "comment\n";
  for (const std::string& comment : file.comment) text += "  " + one_line(comment) + "\n";
  terminal.print(text);
  return kOk;
}

}  // namespace crgbuild
