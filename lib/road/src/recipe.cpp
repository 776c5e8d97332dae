#include "road/recipe.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>

#include "base/text_lines.h"
#include "name_pattern.h"
#include "road/error.h"

namespace road {
namespace {

constexpr std::size_t kMaxRecipeBytes = 1 << 20;
constexpr std::size_t kMaxNameLength = 100;
constexpr std::size_t kMaxPatternLength = 200;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// Text from a file as it may be shown in one line of an error.
std::string in_quotes(std::string_view text) {
  std::string out = "'";
  for (char c : text.substr(0, 60)) out += static_cast<unsigned char>(c) < 32 ? '?' : c;
  return out + (text.size() > 60 ? "...'" : "'");
}

[[noreturn]] void refuse(const std::string& seen, const std::string& wanted) {
  throw Error(fmt::format("{} seen, {} wanted", in_quotes(seen), wanted));
}

std::optional<double> parse_number(std::string_view text) {
  const auto value = base::to_number<double>(base::trimmed(text));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// "1, 2" or "[1, 2]".
std::vector<double> parse_numbers(const std::string& text, std::size_t count, double limit,
                                  const std::string& wanted) {
  std::string_view rest = base::trimmed(text);
  if (rest.starts_with('[') && rest.ends_with(']')) rest = rest.substr(1, rest.size() - 2);
  std::vector<double> values;
  while (true) {
    const std::size_t comma = rest.find(',');
    const auto value = parse_number(rest.substr(0, comma));
    if (!value || std::abs(*value) > limit || values.size() == count) refuse(text, wanted);
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (values.size() != count) refuse(text, wanted);
  return values;
}

RecipeKey number(std::string stage, std::string name, double low, double high, std::string meaning,
                 const std::function<double&(Recipe&)>& field) {
  std::string wanted = fmt::format("{} to {}", low, high);
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            const auto value = parse_number(text);
            if (!value || *value < low || *value > high) refuse(text, "a number from " + wanted);
            field(recipe) = *value;
          },
          [=](const Recipe& recipe) {
            return fmt::format("{}", field(const_cast<Recipe&>(recipe)));  // only read here
          }};
}

RecipeKey number_or_automatic(std::string stage, std::string name, double low, double high,
                              std::string meaning,
                              const std::function<std::optional<double>&(Recipe&)>& field) {
  std::string wanted = fmt::format("automatic or {} to {}", low, high);
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            field(recipe).reset();
            if (text == "automatic") return;
            const auto value = parse_number(text);
            if (!value || *value < low || *value > high)
              refuse(text, fmt::format("automatic or a number from {} to {}", low, high));
            field(recipe) = *value;
          },
          [=](const Recipe& recipe) -> std::string {
            const auto& value = field(const_cast<Recipe&>(recipe));  // only read here
            return value ? fmt::format("{}", *value) : "automatic";
          }};
}

template <class Integer>
RecipeKey whole_number(std::string stage, std::string name, std::uint64_t low, std::uint64_t high,
                       std::string meaning,
                       const std::function<std::vector<Integer*>(Recipe&)>& fields) {
  std::string wanted = fmt::format("{} to {}", low, high);
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            const auto value = parse_number(text);
            if (!value || *value < static_cast<double>(low) || *value > static_cast<double>(high) ||
                *value != std::floor(*value))
              refuse(text, "a whole number from " + wanted);
            for (Integer* field : fields(recipe)) *field = static_cast<Integer>(*value);
          },
          [=](const Recipe& recipe) {
            return fmt::format("{}", *fields(const_cast<Recipe&>(recipe)).front());
          }};
}

RecipeKey yes_or_no(std::string stage, std::string name, std::string meaning,
                    const std::function<bool&(Recipe&)>& field) {
  return {std::move(stage),
          std::move(name),
          "true or false",
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            if (text != "true" && text != "false") refuse(text, "true or false");
            field(recipe) = text == "true";
          },
          [=](const Recipe& recipe) -> std::string {
            return field(const_cast<Recipe&>(recipe)) ? "true" : "false";
          }};
}

/// In any case: KRBI and krbi.
bool same_word(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char c, unsigned char d) {
    return std::tolower(c) == std::tolower(d);
  });
}

template <class Enum>
RecipeKey choice(std::string stage, std::string name,
                 std::vector<std::pair<std::string, Enum>> choices, std::string meaning,
                 const std::function<Enum&(Recipe&)>& field) {
  std::string wanted = choices.front().first;
  for (std::size_t i = 1; i < choices.size(); ++i)
    wanted += (i + 1 == choices.size() ? " or " : ", ") + choices[i].first;
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          true,
          [=](Recipe& recipe, const std::string& text) {
            for (const auto& [word, value] : choices)
              if (same_word(word, text)) return void(field(recipe) = value);
            refuse(text, wanted);
          },
          [=](const Recipe& recipe) -> std::string {
            for (const auto& [word, value] : choices)
              if (value == field(const_cast<Recipe&>(recipe))) return word;
            return {};
          }};
}

RecipeKey point(std::string stage, std::string name, std::string meaning,
                const std::function<std::optional<Eigen::Vector2d>&(Recipe&)>& field) {
  return {std::move(stage),
          std::move(name),
          "x,y",
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            const auto xy = parse_numbers(text, 2, 1e8, "two coordinates x,y in metres");
            field(recipe) = Eigen::Vector2d(xy[0], xy[1]);
          },
          [=](const Recipe& recipe) -> std::string {
            const auto& at = field(const_cast<Recipe&>(recipe));
            return at ? fmt::format("[{}, {}]", at->x(), at->y()) : "";
          }};
}

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

std::vector<RecipeKey> make_keys() {
  std::vector<RecipeKey> keys;
  // input
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
  // read
  keys.push_back(choice<UpAxis>(
      "read", "up", {{"automatic", UpAxis::automatic}, {"y", UpAxis::y}, {"z", UpAxis::z}},
      "axis of the mesh that points up", [](Recipe& r) -> UpAxis& { return r.read.up; }));
  std::vector<std::pair<std::string, Unit>> units{{"automatic", Unit::automatic}};
  for (const NamedUnit& known : kUnits) units.emplace_back(known.name, known.unit);
  keys.push_back(choice<Unit>("read", "unit", std::move(units), "unit of the mesh",
                              [](Recipe& r) -> Unit& { return r.read.unit; }));
  keys.push_back(number("read", "scale", 1e-6, 1e6,
                        "factor on top of the unit, for meshes in a unit without a name",
                        [](Recipe& r) -> double& { return r.read.scale; }));
  keys.push_back(yes_or_no("read", "allow_outside",
                           "the mesh may refer to files outside its folder",
                           [](Recipe& r) -> bool& { return r.read.allow_outside; }));
  // clean
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
  keys.push_back(
      point("clean", "near_m", "of several separate roads take the one nearest to this point",
            [](Recipe& r) -> std::optional<Eigen::Vector2d>& { return r.clean.near_m; }));
  keys.push_back({"clean", "guide", "a path",
                  "rough line along the road (CSV, GPX, KML, GeoJSON, a driven log): what lies under "
                  "it is the road; relative to the recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a CSV, GPX, KML or GeoJSON file, or of a log");
                    recipe.guide_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.guide_path.value_or(""); }});
  keys.push_back({"clean", "guide_mapping", "a path",
                  "mapping.yaml that says which columns of a log as guide are the place; relative "
                  "to the recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a mapping.yaml");
                    recipe.guide_mapping_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.guide_mapping_path.value_or(""); }});
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
  // centreline
  keys.push_back(yes_or_no("centreline", "reverse", "drive the other way round",
                           [](Recipe& r) -> bool& { return r.centreline.reverse; }));
  keys.push_back(point(
      "centreline", "start_near_m", "u = 0 where the line passes nearest to this point",
      [](Recipe& r) -> std::optional<Eigen::Vector2d>& { return r.centreline.start_near_m; }));
  keys.push_back(
      {"centreline", "start_object", "an object's name",
       "u = 0 at the middle of this object of the mesh", true,
       [](Recipe& recipe, const std::string& text) {
         if (text.empty()) refuse(text, "the name of an object in the mesh");
         recipe.centreline.start_object = text;
       },
       [](const Recipe& recipe) { return recipe.centreline.start_object.value_or(""); }});
  // reference line
  keys.push_back(number_or_automatic(
      "reference_line", "u_step_m", 0.001, 10.0,
      "step along the road; automatic: 0.1, or a fortieth of the width of a narrow road",
      [](Recipe& r) -> std::optional<double>& { return r.reference_line.u_step_m; }));
  // sample
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
  // kerb
  keys.push_back(number("kerb", "kerb_max_extra_columns_share", 0.0, 10.0,
                        "most columns added at kerbs, as a share of the even ones",
                        [](Recipe& r) -> double& { return r.kerb.max_extra_columns_share; }));
  keys.push_back(number("kerb", "kerb_min_height_m", 0.0, 1.0, "lower kerbs are not refined",
                        [](Recipe& r) -> double& { return r.kerb.min_height_m; }));
  keys.push_back({"kerb", "kerb_zones", "a path",
                  "CSV of u and v ranges that are kerb (1) or not (0), whatever the mesh says; "
                  "relative to the recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a CSV file");
                    recipe.kerb.zones_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.kerb.zones_path.value_or(""); }});
  keys.push_back(number("patch", "kerb_patch_error_m", 0.0, 1.0,
                        "kerbs that the rows miss by more get a finer road laid over; 0: off",
                        [](Recipe& r) -> double& { return r.patch.max_error_m; }));
  // smooth
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
  // friction
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
  keys.push_back({"friction", "friction_picture", "a path",
                  "PNG painted with friction times 100 as grey over <name>.classes.png; relative "
                  "to the recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a PNG file");
                    recipe.friction.picture_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.friction.picture_path.value_or(""); }});
  keys.push_back({"friction", "friction_zones", "a path",
                  "CSV of u and v ranges with their friction, over the classes; relative to the "
                  "recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a CSV file");
                    recipe.friction.zones_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.friction.zones_path.value_or(""); }});
  // align
  keys.push_back({"align", "control_points", "a path",
                  "CSV of control points; relative to the recipe's folder", true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a CSV file");
                    recipe.control_points_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.control_points_path.value_or(""); }});
  keys.push_back({"align", "trajectory", "a path",
                  "CSV of positions driven on the road, when there are no control points; relative "
                  "to the recipe's folder",
                  true,
                  [](Recipe& recipe, const std::string& text) {
                    if (text.empty()) refuse(text, "the path of a CSV file");
                    recipe.trajectory_path = text;
                  },
                  [](const Recipe& recipe) { return recipe.trajectory_path.value_or(""); }});
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
  // output
  keys.push_back(
      choice<crg::Format>("output", "format",
                          {{"KRBI", crg::Format::KRBI},
                           {"KDBI", crg::Format::KDBI},
                           {"LRFI", crg::Format::LRFI},
                           {"LDFI", crg::Format::LDFI}},
                          "of the numbers: binary 4 or 8 bytes, text 10 or 20 characters",
                          [](Recipe& r) -> crg::Format& { return r.format; }));
  keys.push_back(
      whole_number<unsigned>("output", "threads", 0, 1024,
                             "0: all cores; any number writes the same bytes", [](Recipe& r) {
                               return std::vector<unsigned*>{&r.sample.threads, &r.kerb.threads,
                                                             &r.patch.threads, &r.smooth.threads};
                             }));
  // validate
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
  return keys;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string nearest_key(std::string_view unknown) {
  unknown = unknown.substr(0, 64);
  std::string best = "name_rules";
  std::size_t best_distance = edit_distance(unknown, best);
  for (const RecipeKey& key : recipe_keys()) {
    const std::size_t distance = edit_distance(unknown, key.name);
    if (distance < best_distance) {
      best = key.name;
      best_distance = distance;
    }
  }
  return best;
}

/// Position in the recipe for an error message.
class Place {
 public:
  explicit Place(std::string path) : path_(std::move(path)) {}
  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& words) const {
    throw Error(mark.is_null() ? fmt::format("{}: {}", path_, words)
                               : fmt::format("{}:{}: {}", path_, mark.line + 1, words));
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// A scalar as it stands; a list of scalars joined by commas.
std::string value_text(const YAML::Node& node, const Place& place, const std::string& key) {
  if (node.IsScalar()) return node.Scalar();
  if (node.IsSequence()) {
    std::string text;
    for (const YAML::Node& item : node) {
      if (!item.IsScalar()) place.fail(item.Mark(), key + ": a nested value seen, a number wanted");
      text += (text.empty() ? "" : ",") + item.Scalar();
    }
    return text;
  }
  if (node.IsNull()) return {};
  place.fail(node.Mark(), key + ": a table seen, a single value wanted");
}

NameRule read_name_rule(const YAML::Node& node, const Place& place) {
  if (!node.IsMap())
    place.fail(node.Mark(),
               "name_rules: wanted are lines like - {object: 'tkmn', class: road}; the first of "
               "object, material, texture is a regular expression");
  NameRule rule;
  bool has_pattern = false, has_class = false;
  for (const auto& entry : node) {
    const std::string key = value_text(entry.first, place, "name_rules");
    const std::string text = value_text(entry.second, place, "name_rules: " + key);
    if (key == "class") {
      constexpr SurfaceClass kClasses[] = {SurfaceClass::road, SurfaceClass::kerb,
                                           SurfaceClass::runoff, SurfaceClass::barrier,
                                           SurfaceClass::scenery};
      const auto* found = std::find_if(std::begin(kClasses), std::end(kClasses),
                                       [&](SurfaceClass c) { return text == to_string(c); });
      if (found == std::end(kClasses))
        place.fail(
            entry.second.Mark(),
            fmt::format("name_rules: class {} seen, road, kerb, runoff, barrier or scenery wanted",
                        in_quotes(text)));
      rule.surface_class = *found;
      has_class = true;
    } else if (key == "object" || key == "material" || key == "texture") {
      if (has_pattern)
        place.fail(entry.first.Mark(), "name_rules: one of object, material, texture per rule");
      if (text.empty() || text.size() > kMaxPatternLength)
        place.fail(entry.second.Mark(),
                   fmt::format("name_rules: a pattern of {} characters seen, 1 to {} wanted",
                               text.size(), kMaxPatternLength));
      try {
        NamePattern check(text);
      } catch (const Error& error) {
        place.fail(entry.second.Mark(), fmt::format("name_rules: {}", error.what()));
      }
      rule.field = key == "object"     ? NameRule::Field::object
                   : key == "material" ? NameRule::Field::material
                                       : NameRule::Field::texture;
      rule.pattern = text;
      has_pattern = true;
    } else {
      place.fail(
          entry.first.Mark(),
          fmt::format("name_rules: unknown key {}; known are object, material, texture, class",
                      in_quotes(key)));
    }
  }
  if (!has_pattern || !has_class)
    place.fail(node.Mark(),
               "name_rules: a rule needs a class and one of object, material, texture");
  return rule;
}

void read_name_rules(const YAML::Node& node, const Place& place, Recipe& recipe) {
  if (!node.IsSequence())
    place.fail(node.Mark(), "name_rules: a single value seen, a list of rules wanted");
  std::vector<NameRule> rules;
  for (const YAML::Node& item : node) rules.push_back(read_name_rule(item, place));
  // The first match decides, so the recipe's own rules stand before the built-in ones.
  recipe.clean.name_rules.insert(recipe.clean.name_rules.begin(), rules.begin(), rules.end());
}

std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw Error(path + ": a folder seen, a recipe file wanted (track.yaml)");
  if (const auto type = std::filesystem::status(path, error).type();
      type != std::filesystem::file_type::not_found && type != std::filesystem::file_type::regular)
    throw Error(path + ": no regular file; give the path of a recipe (track.yaml) or of a mesh");
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(path + ": cannot be opened; give the path of a recipe (track.yaml) or of a mesh");
  std::string text(kMaxRecipeBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxRecipeBytes)
    throw Error(fmt::format("{}: more than {} bytes seen, a recipe of a few lines wanted", path,
                            kMaxRecipeBytes));
  if (text.find('\0') != std::string::npos)
    throw Error(path + ": binary data seen, a recipe in YAML wanted");
  return text;
}

std::string beside(const std::string& recipe_path, const std::string& path) {
  namespace fs = std::filesystem;
  return fs::path(path).is_absolute() ? path
                                      : (fs::path(recipe_path).parent_path() / path).string();
}

Recipe parse_recipe(const std::string& text, const Place& place) {
  const YAML::Node root = YAML::Load(text);
  if (root.IsNull() || !root.IsDefined())
    place.fail(YAML::Mark::null_mark(), "empty; a recipe needs at least the line mesh: PATH");
  if (!root.IsMap())
    place.fail(root.Mark(), "no recipe; wanted are lines like mesh: track.obj or u_step_m: 0.1");

  Recipe recipe;
  recipe.recipe_path = place.path();
  std::set<std::string> seen;
  for (const auto& entry : root) {
    const std::string name = value_text(entry.first, place, "key");
    if (!seen.insert(name).second)
      place.fail(entry.first.Mark(), fmt::format("{}: given twice", name));
    if (name == "name_rules") {
      read_name_rules(entry.second, place, recipe);
      continue;
    }
    const auto& keys = recipe_keys();
    const auto key =
        std::find_if(keys.begin(), keys.end(), [&](const RecipeKey& k) { return k.name == name; });
    if (key == keys.end())
      place.fail(entry.first.Mark(), fmt::format("unknown key {}; the nearest known one is '{}'",
                                                 in_quotes(name), nearest_key(name)));
    const std::string value = value_text(entry.second, place, name);
    try {
      key->set(recipe, value);
    } catch (const Error& error) {
      place.fail(entry.second.Mark(), name + ": " + error.what());
    }
  }
  if (recipe.mesh_path.empty())
    place.fail(YAML::Mark::null_mark(), "the key mesh is missing; add the line mesh: PATH");
  if ((recipe.control_points_path ? 1 : 0) + (recipe.trajectory_path ? 1 : 0) +
          (recipe.T_global_mesh ? 1 : 0) >
      1)
    place.fail(YAML::Mark::null_mark(),
               "more than one of control_points, trajectory, and yaw_deg with translation_m seen; "
               "give one");
  return recipe;
}

}  // namespace

const std::vector<RecipeKey>& recipe_keys() {
  static const std::vector<RecipeKey> keys = make_keys();
  return keys;
}

Recipe read_recipe(const std::string& path) {
  const std::string text = read_text(path);
  const Place place(path);
  Recipe recipe;
  try {
    recipe = parse_recipe(text, place);
  } catch (const YAML::Exception& error) {
    place.fail(error.mark, "no valid YAML: " + error.msg);
  }
  recipe.mesh_path = beside(path, recipe.mesh_path);
  if (recipe.guide_path) recipe.guide_path = beside(path, *recipe.guide_path);
  if (recipe.guide_mapping_path)
    recipe.guide_mapping_path = beside(path, *recipe.guide_mapping_path);
  if (recipe.control_points_path)
    recipe.control_points_path = beside(path, *recipe.control_points_path);
  if (recipe.friction.picture_path)
    recipe.friction.picture_path = beside(path, *recipe.friction.picture_path);
  if (recipe.friction.zones_path)
    recipe.friction.zones_path = beside(path, *recipe.friction.zones_path);
  if (recipe.trajectory_path) recipe.trajectory_path = beside(path, *recipe.trajectory_path);
  if (recipe.kerb.zones_path) recipe.kerb.zones_path = beside(path, *recipe.kerb.zones_path);
  if (recipe.name.empty()) recipe.name = std::filesystem::path(recipe.mesh_path).stem().string();
  return recipe;
}

Recipe recipe_for_mesh(const std::string& mesh_path) {
  Recipe recipe;
  recipe.mesh_path = mesh_path;
  recipe.name = std::filesystem::path(mesh_path).stem().string();
  return recipe;
}

}  // namespace road
