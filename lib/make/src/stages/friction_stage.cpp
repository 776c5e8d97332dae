// Grip at the nodes of the heights, where the recipe wants it.
#include "grid_stage.h"
#include "key_kinds.h"
#include "road/friction.h"

namespace road {
namespace stage_friction {
namespace {

void add_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(yes_or_no("friction", "friction",
                           "also write <name>.friction.crg: friction in place of heights",
                           [](Recipe& r) -> bool& { return r.friction.wanted; }));
  keys.push_back(number("friction", "friction_road", 0.0, 3.0,
                        "friction of the road, against dry asphalt",
                        [](Recipe& r) -> double& { return r.friction.road; }));
  keys.push_back(number("friction", "friction_kerb", 0.0, 3.0, "friction of kerbs",
                        [](Recipe& r) -> double& { return r.friction.kerb; }));
  keys.push_back(number("friction", "friction_grass", 0.0, 3.0,
                        "friction of run-off that no name tells to be something else",
                        [](Recipe& r) -> double& { return r.friction.grass; }));
  keys.push_back(number("friction", "friction_gravel", 0.0, 3.0,
                        "friction of run-off named gravel or sand",
                        [](Recipe& r) -> double& { return r.friction.gravel; }));
  keys.push_back(number("friction", "friction_paint", 0.0, 3.0,
                        "friction of what is named paint, line or marking",
                        [](Recipe& r) -> double& { return r.friction.paint; }));
  keys.push_back(number("friction", "friction_concrete", 0.0, 3.0,
                        "friction of what is named concrete",
                        [](Recipe& r) -> double& { return r.friction.concrete; }));
  keys.push_back(words("friction", "friction_picture", "a path",
                       "PNG painted with friction times 100 as grey over <name>.classes.png; "
                       "relative to the recipe's folder",
                       "the path of a PNG file", [](Recipe& r) -> std::optional<std::string>& {
                         return r.friction.picture_path;
                       }));
  keys.push_back(words("friction", "friction_zones", "a path",
                       "CSV of u and v ranges with their friction, over the classes; relative to "
                       "the recipe's folder",
                       "the path of a CSV file", [](Recipe& r) -> std::optional<std::string>& {
                         return r.friction.zones_path;
                       }));
}

bool wanted(const Recipe& recipe) { return recipe.friction.wanted; }

void run(const GridWork& work) {
  MadeRoad& built = work.built;
  built.friction =
      friction_grid(built.sampled, work.surface, built.road, built.line, work.recipe.friction,
                    *work.paint, work.recipe.sample.threads, &built.summary.friction);
}

void report(const BuildSummary& summary, Json& out) {
  out["friction"] = summary.friction_file.empty()
                        ? Json(nullptr)
                        : Json{{"file", summary.friction_file}, {"nodes", summary.friction.nodes}};
}

}  // namespace
}  // namespace stage_friction

GridStage friction_stage() {
  using namespace stage_friction;
  return {.name = "friction", .add_keys = add_keys, .wanted = wanted, .run = run, .report = report};
}

}  // namespace road
