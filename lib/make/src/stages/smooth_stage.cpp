// Smoothing of the heights, where the recipe has a window.
#include "base/json_text.h"
#include "grid_stage.h"
#include "key_kinds.h"
#include "road/smooth.h"

namespace road {
namespace stage_smooth {
namespace {

void add_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(number("smooth", "smooth_window_m", 0.0, 100.0,
                        "length of the moving average along u; 0: off",
                        [](Recipe& r) -> double& { return r.smooth.window_u_m; }));
  keys.push_back(number("smooth", "smooth_window_v_m", 0.0, 20.0,
                        "length of the moving average across the road; 0: off",
                        [](Recipe& r) -> double& { return r.smooth.window_v_m; }));
  keys.push_back(number("smooth", "smooth_max_change_road_m", 0.0, 1.0,
                        "smoothing moves no road node further than this",
                        [](Recipe& r) -> double& { return r.smooth.max_change_road_m; }));
  keys.push_back(number("smooth", "smooth_max_change_kerb_m", 0.0, 1.0,
                        "smoothing moves no kerb node further than this",
                        [](Recipe& r) -> double& { return r.smooth.max_change_kerb_m; }));
}

void run(const GridWork& work) {
  SmoothOptions options = work.recipe.smooth;
  options.closed = work.built.line.closed;
  smooth(work.built.sampled, options, &work.built.summary.smooth);
}

Json json_of(const SmoothReport& report, const SmoothOptions& options) {
  Json bands = Json::array();
  for (const SmoothedBand& band : report.bands)
    bands.push_back(
        {{"n_cpm", band.n_cpm}, {"before_m3", band.before_m3}, {"after_m3", band.after_m3}});
  return {{"window_m", options.window_u_m},
          {"window_v_m", options.window_v_m},
          {"largest_change_road_m", report.largest_change_road_m},
          {"largest_change_u_m", report.largest_change_u_m},
          {"largest_change_v_m", report.largest_change_v_m},
          {"largest_change_kerb_m", report.largest_change_kerb_m},
          {"nodes_at_bound", report.nodes_at_bound},
          {"halved_waves_m", report.halved_waves_m ? Json{report.halved_waves_m->shortest_m,
                                                          report.halved_waves_m->longest_m}
                                                   : Json(nullptr)},
          {"wheel_path_psd", bands}};
}

void report(const BuildSummary& summary, Json& out) {
  out["smooth"] = json_of(summary.smooth, summary.recipe.smooth);
}

}  // namespace
}  // namespace stage_smooth

std::string json_text(const SmoothReport& report, const SmoothOptions& options) {
  return base::json_text(stage_smooth::json_of(report, options));
}

GridStage smooth_stage() {
  using namespace stage_smooth;
  return {.name = "smooth", .add_keys = add_keys, .run = run, .report = report};
}

}  // namespace road
