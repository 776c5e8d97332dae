#include "base/error.h"
#include "fuzz/target.h"
#include "make/recipe.h"

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put("track.yaml", bytes);
  try {
    const road::Recipe recipe = road::read_recipe(path);
    require(!recipe.mesh_path.empty() && !recipe.name.empty(), "a mesh and a name");
    for (const road::RecipeKey& key : road::recipe_keys()) (void)key.show(recipe);
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
}
