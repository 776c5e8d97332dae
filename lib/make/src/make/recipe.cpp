#include "make/recipe.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "key_kinds.h"
#include "mesh/error.h"
#include "recipe_keys.h"
#include "road/name_pattern.h"

namespace road {
namespace {

constexpr std::size_t kMaxRecipeBytes = 1 << 20;

constexpr std::size_t kMaxPatternLength = 200;

std::vector<RecipeKey> make_keys() {
  std::vector<RecipeKey> keys;
  add_surface_keys(keys);
  add_grid_keys(keys);
  add_output_keys(keys);
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

/// Values by their keys; what stands in the block `reference` has that word before it.
void read_values(const YAML::Node& table, const std::string& before, const Place& place,
                 std::set<std::string>& seen, Recipe& recipe) {
  for (const auto& entry : table) {
    const std::string name = before + value_text(entry.first, place, "key");
    if (!seen.insert(name).second)
      place.fail(entry.first.Mark(), fmt::format("{}: given twice", name));
    if (name == "name_rules") {
      read_name_rules(entry.second, place, recipe);
      continue;
    }
    if (name == "reference" && entry.second.IsMap()) {
      read_values(entry.second, "reference_", place, seen, recipe);
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
  read_values(root, "", place, seen, recipe);
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
