// Finer roads over kerbs whose teeth fall between the rows.
#include "grid_stage.h"
#include "key_kinds.h"
#include "road/patch.h"

namespace road {
namespace stage_patch {
namespace {

void add_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(number("patch", "kerb_patch_error_m", 0.0, 1.0,
                        "kerbs that the rows miss by more get a finer road laid over; 0: off",
                        [](Recipe& r) -> double& { return r.patch.max_error_m; }));
}

void run(const GridWork& work) {
  MadeRoad& built = work.built;
  built.patches = patch_kerbs(built.sampled, work.surface, built.road, built.line,
                              built.summary.kerb.kerbs, work.recipe.patch);
}

void report(const BuildSummary& summary, Json& out) {
  out["patches"] = Json::array();
  for (const PatchFile& patch : summary.patches)
    out["patches"].push_back({{"file", patch.file},
                              {"u_begin_m", patch.u_begin_m},
                              {"u_end_m", patch.u_end_m},
                              {"v_begin_m", patch.v_begin_m},
                              {"v_end_m", patch.v_end_m},
                              {"u_step_m", patch.u_step_m},
                              {"z_error_p95_before_m", patch.error_before_m},
                              {"z_error_p95_m", patch.error_m}});
}

}  // namespace
}  // namespace stage_patch

GridStage patch_stage() {
  using namespace stage_patch;
  return {.name = "patch", .add_keys = add_keys, .run = run, .report = report};
}

}  // namespace road
