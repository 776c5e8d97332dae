#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>

#include "key_kinds.h"
#include "recipe_keys.h"

namespace road {
namespace {

constexpr std::size_t kMaxNameLength = 100;

void check_name(const std::string& text) {
  const bool bad = text.empty() || text.size() > kMaxNameLength || text.front() == '.' ||
                   text.front() == '-' || std::any_of(text.begin(), text.end(), [](char c) {
                     return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 32;
                   });
  if (bad)
    refuse(text, fmt::format("a file name of 1 to {} characters without / that starts with neither "
                             ". nor -",
                             kMaxNameLength));
}

RecipeKey scale_key() {
  RecipeKey key = number("read", "scale", 1e-6, 1e6,
                         "factor on top of the unit, for meshes in a unit without a name",
                         [](Recipe& r) -> double& { return r.read.scale; });
  key.set = [set = key.set, wanted = key.wanted](Recipe& recipe, const std::string& text) {
    const auto value = parse_number(text);
    if (value && *value < 0.0)
      refuse(text, fmt::format("a number from {}; --mirror (mirror: true) reflects the plan, --up "
                               "-y or -z turns what lies on its back",
                               wanted));
    set(recipe, text);
  };
  return key;
}

void add_input_keys(std::vector<RecipeKey>& keys) {
  keys.push_back({"input", "mesh", "a path", "the track mesh; relative to the recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a mesh file");
                    recipe.mesh_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.mesh_path; }});
  keys.push_back({"input", "name", "a file name", "files are called <name>.crg, <name>.stl, ...",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    check_name(text);
                    recipe.name = text;
                  },
                  [](const Recipe& recipe) { return recipe.name; }});
  std::vector<std::pair<std::string, UpAxis>> ups{{"automatic", UpAxis::automatic}};
  for (const NamedUp& known : kUps) ups.emplace_back(known.name, known.up);
  keys.push_back(choice<UpAxis>("read", "up", std::move(ups), "axis of the mesh that points up",
                                [](Recipe& r) -> UpAxis& { return r.read.up; }));
  keys.push_back(yes_or_no("read", "mirror",
                           "reflect the plan: the file has left and right exchanged",
                           [](Recipe& r) -> bool& { return r.read.mirror; }));
  std::vector<std::pair<std::string, Unit>> units{{"automatic", Unit::automatic}};
  for (const NamedUnit& known : kUnits) units.emplace_back(known.name, known.unit);
  keys.push_back(choice<Unit>("read", "unit", std::move(units), "unit of the mesh",
                              [](Recipe& r) -> Unit& { return r.read.unit; }));
  keys.push_back(scale_key());
  keys.push_back(yes_or_no("read", "allow_outside",
                           "the mesh may refer to files outside its folder",
                           [](Recipe& r) -> bool& { return r.read.allow_outside; }));
}

void add_clean_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(choice<UseNames>(
      "clean", "use_names",
      {{"automatic", UseNames::automatic}, {"true", UseNames::yes}, {"false", UseNames::no}},
      "classify by object, material and texture names, or (false) by shape alone; automatic: what "
      "finds the more "
      "plausible road",
      [](Recipe& r) -> UseNames& { return r.clean.use_names; }));
  keys.push_back(number("clean", "weld_tolerance_m", 0.0, 0.1,
                        "vertices closer than this become one",
                        [](Recipe& r) -> double& { return r.clean.weld_tolerance_m; }));
  keys.push_back(number("clean", "max_slope_deg", 1.0, 89.0,
                        "steeper triangles are neither road nor run-off",
                        [](Recipe& r) -> double& { return r.clean.max_slope_deg; }));
  keys.push_back(number("clean", "snap_tolerance_m", 0.0, 0.5,
                        "border vertices this near each other become one",
                        [](Recipe& r) -> double& { return r.clean.snap_tolerance_m; }));
  keys.push_back(number("clean", "bridge_gap_m", 0.0, 100.0,
                        "gaps across the whole road up to this long are closed by new triangles",
                        [](Recipe& r) -> double& { return r.clean.max_gap_m; }));
}

void add_guide_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(
      point("clean", "near_m", "of several separate roads take the one nearest to this point",
            [](Recipe& r) -> std::optional<Eigen::Vector2d>& { return r.clean.near_m; }));
  keys.push_back(words("clean", "guide", "a path",
                       "rough line along the road (CSV, GPX, KML, GeoJSON, a driven log): what "
                       "lies under it is the road; relative to the recipe's folder",
                       "the path of a CSV, GPX, KML or GeoJSON file, or of a log",
                       [](Recipe& r) -> std::optional<std::string>& { return r.guide_path; }));
  keys.push_back(words("clean", "guide_mapping", "a path",
                       "mapping.yaml that says which columns of a log as guide are the place; "
                       "relative to the recipe's folder",
                       "the path of a mapping.yaml", [](Recipe& r) -> std::optional<std::string>& {
                         return r.guide_mapping_path;
                       }));
  keys.push_back({"clean", "route", "x,y x,y ...",
                  "points in the order of driving: the road is the shortest way through them; "
                  "closed when the last is the first",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    std::vector<Eigen::Vector2d> points;
                    std::istringstream words{text};
                    for (std::string word; words >> word;) {
                      const auto xy =
                          parse_numbers(word, 2, 1e8, "points x,y in metres, parted by blanks");
                      points.emplace_back(xy[0], xy[1]);
                    }
                    if (points.size() < 2 || points.size() > 1000)
                      refuse(text, "2 to 1000 points x,y in metres, parted by blanks");
                    recipe.clean.route_m = std::move(points);
                  },
                  [](const Recipe& recipe) {
                    std::string text;
                    for (const Eigen::Vector2d& p : recipe.clean.route_m)
                      text += fmt::format("{}{},{}", text.empty() ? "" : " ", p.x(), p.y());
                    return text;
                  }});
  keys.push_back({"clean", "guide_width_m", "0.1 to 200",
                  "width of the road along the guide where the surface does not tell", false,
                  [](Recipe& recipe, const std::string& text) {
                    const auto value = parse_number(text);
                    if (!value || *value < 0.1 || *value > 200.0)
                      refuse(text, "a number from 0.1 to 200");
                    recipe.clean.guide_width_m = recipe.centreline.guide_width_m = *value;
                  },
                  [](const Recipe& recipe) {
                    return recipe.clean.guide_width_m
                               ? fmt::format("{}", *recipe.clean.guide_width_m)
                               : "";
                  }});
}

void add_line_keys(std::vector<RecipeKey>& keys) {
  keys.push_back(yes_or_no("centreline", "reverse", "drive the other way round",
                           [](Recipe& r) -> bool& { return r.centreline.reverse; }));
  keys.push_back(point(
      "centreline", "start_near_m", "u = 0 where the line passes nearest to this point",
      [](Recipe& r) -> std::optional<Eigen::Vector2d>& { return r.centreline.start_near_m; }));
  keys.push_back(words("centreline", "start_object", "an object's name",
                       "u = 0 at the middle of this object of the mesh",
                       "the name of an object in the mesh",
                       [](Recipe& r) -> std::optional<std::string>& { return r.start_object; }));
}

}  // namespace

void add_surface_keys(std::vector<RecipeKey>& keys) {
  add_input_keys(keys);
  add_clean_keys(keys);
  add_guide_keys(keys);
  add_line_keys(keys);
}

}  // namespace road
