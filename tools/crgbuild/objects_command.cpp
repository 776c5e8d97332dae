#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/one_line.h"
#include "commands.h"
#include "make/objects.h"

namespace crgbuild {
namespace {

constexpr std::size_t kMostLines = 60;  // of a mesh with thousands of objects; --json has all

std::string line_of(const road::ObjectRow& row) {
  const std::string above = row.above_road_m ? fmt::format("{:+.2f}", *row.above_road_m) : "-";
  return fmt::format("{:<8} {:>10.0f} {:>8} {:>9}  {}  {}  ({})\n", row.surface_class, row.area_m2,
                     above, row.triangles, row.object.empty() ? "-" : base::one_line(row.object),
                     row.material.empty() ? "-" : base::one_line(row.material),
                     base::one_line(row.why));
}

std::string table_text(const road::ObjectTable& table, std::size_t most, const std::string& where) {
  std::string text = fmt::format("{:<8} {:>10} {:>8} {:>9}  object  material  (why)\n", "class",
                                 "area m2", "above m", "triangles");
  for (std::size_t k = 0; k < std::min(most, table.rows.size()); ++k)
    text += line_of(table.rows[k]);
  if (table.rows.size() > most)
    text += fmt::format("{} more; {} lists all\n", table.rows.size() - most, where);
  return text;
}

nlohmann::ordered_json json_of(const road::ObjectTable& table) {
  auto rows = nlohmann::ordered_json::array();
  for (const road::ObjectRow& row : table.rows)
    rows.push_back({{"object", row.object},
                    {"material", row.material},
                    {"class", row.surface_class},
                    {"why", row.why},
                    {"triangles", row.triangles},
                    {"area_m2", row.area_m2},
                    {"above_road_m", row.above_road_m ? nlohmann::ordered_json(*row.above_road_m)
                                                      : nlohmann::ordered_json()}});
  return {{"objects", rows},
          {"up", table.up},
          {"unit", table.unit},
          {"refusal", table.refusal},
          {"remarks", table.remarks}};
}

}  // namespace

void print_objects_in_short(const std::string& input, const RecipeFlags& flags,
                            Terminal& terminal) {
  if (terminal.json || terminal.quiet) return;
  const road::ObjectTable table = road::objects_of(make_recipe(input, flags));
  if (table.rows.size() > 1)
    terminal.print(table_text(table, 6, road::command_line("objects", {{"", input}}, flags)));
}

int run_objects(const ObjectsCommand& command, Terminal& terminal) {
  terminal.start("reading the mesh");
  const road::ObjectTable table = road::objects_of(make_recipe(command.input, command.flags));
  terminal.progress_done();
  terminal.print(terminal.json ? base::json_text(json_of(table))
                               : table_text(table, kMostLines, "--json"));
  if (!table.refusal.empty())
    terminal.remark("no road can be made of it as it is: " + table.refusal);
  return kOk;
}

}  // namespace crgbuild
