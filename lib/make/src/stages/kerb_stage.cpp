// Kerbs: columns of the grid where their edges are.
#include "grid_stage.h"
#include "key_kinds.h"
#include "road/kerb.h"

namespace road {
namespace stage_kerb {
namespace {

void add_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(number("kerb", "kerb_max_extra_columns_share", 0.0, 10.0,
                        "most columns added at kerbs, as a share of the even ones",
                        [](Recipe& r) -> double& { return r.kerb.max_extra_columns_share; }));
  keys.push_back(number("kerb", "kerb_min_height_m", 0.0, 1.0, "lower kerbs are not refined",
                        [](Recipe& r) -> double& { return r.kerb.min_height_m; }));
  keys.push_back(
      words("kerb", "kerb_zones", "a path",
            "CSV of u and v ranges that are kerb (1) or not (0), whatever the mesh says; "
            "relative to the recipe's folder",
            "the path of a CSV file",
            [](Recipe& r) -> std::optional<std::string>& { return r.kerb.zones_path; }));
}

void run(const GridWork& work) {
  MadeRoad& built = work.built;
  built.sampled = refine_kerbs(std::move(built.sampled), work.surface, built.road, built.line,
                               work.recipe.kerb, &built.summary.kerb);
}

void report(const BuildSummary& summary, Json& out) {
  Json kerbs = Json::array();
  for (const Kerb& kerb : summary.kerb.kerbs)
    kerbs.push_back({{"u_begin_m", kerb.u_begin_m},
                     {"u_end_m", kerb.u_end_m},
                     {"v_begin_m", kerb.v_begin_m},
                     {"v_end_m", kerb.v_end_m},
                     {"height_m", kerb.height_m}});
  out["kerb"] = {{"cells", summary.kerb.cells},
                 {"columns_added", summary.kerb.columns_added},
                 {"kerbs", kerbs}};
}

}  // namespace
}  // namespace stage_kerb

GridStage kerb_stage() {
  using namespace stage_kerb;
  return {.name = "kerb", .add_keys = add_keys, .run = run, .report = report};
}

}  // namespace road
