#include <optional>
#include <string>

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

void add_kerb_keys(std::vector<RecipeKey>& keys) {
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
  keys.push_back(number("patch", "kerb_patch_error_m", 0.0, 1.0,
                        "kerbs that the rows miss by more get a finer road laid over; 0: off",
                        [](Recipe& r) -> double& { return r.patch.max_error_m; }));
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

void add_friction_keys(std::vector<RecipeKey>& keys) {
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

}  // namespace

void add_grid_keys(std::vector<RecipeKey>& keys) {
  add_step_keys(keys);
  add_kerb_keys(keys);
  add_friction_keys(keys);
}

}  // namespace road
