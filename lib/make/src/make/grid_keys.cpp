#include <optional>
#include <string>

#include "grid_stage.h"
#include "key_kinds.h"
#include "recipe_keys.h"

namespace road {
namespace {

void add_step_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(number_or_automatic(
      "reference_line", "u_step_m", 0.001, 10.0,
      "step along the road; automatic: 0.1, or a fortieth of the width of a narrow road",
      [](Recipe& r) -> std::optional<double>& { return r.reference_line.u_step_m; }));
  keys.push_back(number_or_automatic(
      "sample", "v_step_m", 0.001, 10.0, "step across the road; automatic as along it",
      [](Recipe& r) -> std::optional<double>& { return r.sample.v_step_m; }));
  keys.push_back(number("sample", "v_max_m", 1.0, 100.0,
                        "how far from the reference line the grid reaches on both sides",
                        [](Recipe& r) -> double& { return r.sample.v_max_m; }));
  keys.push_back(
      number_or_automatic("sample", "max_step_m", 0.001, 5.0,
                          "a larger jump of height between neighbouring nodes ends the surface; "
                          "automatic: 0.3, less on "
                          "a narrow road",
                          [](Recipe& r) -> std::optional<double>& { return r.sample.max_step_m; }));
  keys.push_back(number_or_automatic(
      "sample", "max_gap_m", 0.0, 5.0,
      "gaps in the road up to this wide are filled and flagged; automatic: 0.3, less on a narrow "
      "road",
      [](Recipe& r) -> std::optional<double>& { return r.sample.max_gap_m; }));
}

}  // namespace

void add_grid_keys(std::vector<RecipeKey>& keys) {
  add_step_keys(keys);
  for (const GridStage& stage : grid_stages()) stage.add_keys(keys);
}

}  // namespace road
