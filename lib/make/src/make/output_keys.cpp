#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "key_kinds.h"
#include "recipe_keys.h"

namespace road {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

void add_fit_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(
      words("align", "control_points", "a path",
            "CSV of control points; relative to the recipe's folder", "the path of a CSV file",
            [](Recipe& r) -> std::optional<std::string>& { return r.control_points_path; }));
  keys.push_back(words("align", "trajectory", "a path",
                       "CSV of positions driven on the road, when there are no control points; "
                       "relative to the recipe's folder",
                       "the path of a CSV file",
                       [](Recipe& r) -> std::optional<std::string>& { return r.trajectory_path; }));
  keys.push_back(choice<AlignOptions::Rotation>(
      "align", "align_rotation",
      {{"z", AlignOptions::Rotation::about_z}, {"free", AlignOptions::Rotation::free}},
      "fitted to control points: about z, or free, which also tilts the mesh",
      [](Recipe& r) -> AlignOptions::Rotation& { return r.align.rotation; }));
  keys.push_back(yes_or_no("align", "align_scale", "a scale is fitted to control points too",
                           [](Recipe& r) -> bool& { return r.align.scale; }));
  keys.push_back(choice<Projection::Kind>(
      "align", "projection", {{"utm", Projection::Kind::utm}, {"tm", Projection::Kind::tm}},
      "of latitudes and longitudes: UTM, or transverse Mercator of scale 1 about the first",
      [](Recipe& r) -> Projection::Kind& { return r.projection; }));
}

void add_place_keys(std::vector<RecipeKey>& keys) {
  keys.push_back({"align", "utm_zone", "1N to 60S",
                  "UTM zone of projected coordinates, for the header of the file", true,
                  [](Recipe& recipe, const std::string& text) {
                    const std::string wanted = "a UTM zone from 1N to 60N or 1S to 60S";
                    if (text.size() < 2) refuse(text, wanted);
                    const char side = text.back();
                    const auto number =
                        parse_number(std::string_view(text).substr(0, text.size() - 1));
                    if (!number || *number < 1.0 || *number > 60.0 ||
                        *number != std::floor(*number) || (side != 'N' && side != 'S'))
                      refuse(text, wanted);
                    recipe.utm_zone = UtmZone{static_cast<int>(*number), side == 'N'};
                  },
                  [](const Recipe& recipe) {
                    return recipe.utm_zone ? fmt::format("{}{}", recipe.utm_zone->number,
                                                         recipe.utm_zone->north ? 'N' : 'S')
                                           : "";
                  }});
  keys.push_back({"align", "yaw_deg", "-360 to 360",
                  "turns the road about z by this angle, counter-clockwise", false,
                  [](Recipe& recipe, const std::string& text) {
                    const auto value = parse_number(text);
                    if (!value || std::abs(*value) > 360.0)
                      refuse(text, "a number from -360 to 360");
                    if (!recipe.T_global_mesh) recipe.T_global_mesh.emplace();
                    recipe.T_global_mesh->yaw_rad = *value * kRadPerDeg;
                  },
                  [](const Recipe& recipe) {
                    return recipe.T_global_mesh
                               ? fmt::format("{}", recipe.T_global_mesh->yaw_rad / kRadPerDeg)
                               : "";
                  }});
  keys.push_back({"align", "translation_m", "x,y,z", "then moves it by this vector", false,
                  [](Recipe& recipe, const std::string& text) {
                    const auto xyz = parse_numbers(text, 3, 1e8, "three lengths x,y,z in metres");
                    if (!recipe.T_global_mesh) recipe.T_global_mesh.emplace();
                    recipe.T_global_mesh->translation_m = {xyz[0], xyz[1], xyz[2]};
                  },
                  [](const Recipe& recipe) -> std::string {
                    if (!recipe.T_global_mesh) return "";
                    const auto& t = recipe.T_global_mesh->translation_m;
                    return fmt::format("[{}, {}, {}]", t.x(), t.y(), t.z());
                  }});
}

void add_file_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(
      choice<crg::Format>("output", "format",
                          {{"KRBI", crg::Format::KRBI},
                           {"KDBI", crg::Format::KDBI},
                           {"LRFI", crg::Format::LRFI},
                           {"LDFI", crg::Format::LDFI}},
                          "of the numbers: binary 4 or 8 bytes, text 10 or 20 characters",
                          [](Recipe& r) -> crg::Format& { return r.format; }));
  keys.push_back(whole_number<unsigned>(
      "output", "threads", 0, 1024, "0: all cores; any number writes the same bytes",
      [](Recipe& r) {
        return std::vector<unsigned*>{&r.sample.threads, &r.kerb.threads, &r.patch.threads,
                                      &r.smooth.threads, &r.validate.threads};
      }));
}

void add_validate_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(whole_number<std::size_t>(
      "validate", "validate_points", 1, 100'000'000, "random points compared with the mesh",
      [](Recipe& r) { return std::vector<std::size_t*>{&r.validate.points}; }));
  keys.push_back(whole_number<std::uint64_t>(
      "validate", "validate_seed", 0, 1'000'000'000, "seed of these points",
      [](Recipe& r) { return std::vector<std::uint64_t*>{&r.validate.seed}; }));
  keys.push_back(number("validate", "validate_reach_m", 0.01, 100.0,
                        "a mesh surface further above or below is another one",
                        [](Recipe& r) -> double& { return r.validate.reach_m; }));
  keys.push_back(yes_or_no(
      "validate", "line_is_right",
      "somebody has looked at the picture and the line is the road: doubts about it do not count",
      [](Recipe& r) -> bool& { return r.line_is_right; }));
  keys.push_back(number("validate", "max_z_error_p99_m", 0.0, 100.0,
                        "validation fails when 1 % of the points are further from the mesh",
                        [](Recipe& r) -> double& { return r.limits.max_z_error_p99_m; }));
  keys.push_back(number("validate", "max_share_without_mesh", 0.0, 1.0,
                        "validation fails when more points have height but no mesh",
                        [](Recipe& r) -> double& { return r.limits.max_share_without_mesh; }));
  keys.push_back(number("validate", "max_seam_z_step_m", 0.0, 100.0,
                        "validation fails when the ends of a closed road differ by more",
                        [](Recipe& r) -> double& { return r.limits.max_seam_z_step_m; }));
}

void add_reference_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(optional_number(
      "reference", "reference_length_m", 1.0, 1e6, "published length, for the report",
      [](Recipe& r) -> std::optional<double>& { return r.published.length_m; }));
  keys.push_back(optional_number(
      "reference", "reference_climb_m", 0.1, 1e4, "published height from lowest to highest point",
      [](Recipe& r) -> std::optional<double>& { return r.published.climb_m; }));
  keys.push_back(
      optional_number("reference", "reference_width_m", 0.1, 200.0, "published width of the road",
                      [](Recipe& r) -> std::optional<double>& { return r.published.width_m; }));
  keys.push_back(
      words("reference", "reference_source", "words", "where that is published", "a source",
            [](Recipe& r) -> std::optional<std::string>& { return r.published.source; }));
  keys.push_back(words("reference", "reference_mesh", "words",
                       "whose the mesh is, its date and licence: on the page and in $CT",
                       "whose the mesh is",
                       [](Recipe& r) -> std::optional<std::string>& { return r.published.mesh; }));
}

}  // namespace

void add_output_keys(std::vector<RecipeKey>& keys) {
  add_fit_keys(keys);
  add_place_keys(keys);
  add_file_keys(keys);
  add_validate_keys(keys);
  add_reference_keys(keys);
}

}  // namespace road
