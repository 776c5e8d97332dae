#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/file.h"
#include "make/make_road.h"
#include "make/place.h"
#include "road/track_crg.h"

namespace crgbuild {

int run_stretch(const StretchCommand& command, Terminal& terminal) {
  road::Recipe recipe = make_recipe(command.input, command.flags);
  recipe.patch.max_error_m = 0.0;
  recipe.friction.wanted = false;
  road::MakeOptions options;
  options.progress = terminal.progress();
  options.stretch = {command.u_begin_m, command.u_end_m};
  if (!command.build.empty())
    options.clean_cache_path =
        (std::filesystem::path(command.build) / road::clean_cache_name(recipe)).string();
  road::MadeRoad built = road::make_road(recipe, road::inputs_of(recipe), options);
  const double u_begin_m = built.line.u_begin_m,
               u_end_m =
                   u_begin_m + static_cast<double>(built.line.size() - 1) * built.line.u_step_m;
  const std::size_t rows = built.sampled.grid.rows(), columns = built.sampled.grid.columns();
  crg::Crg file = road::track_crg(built.line, std::move(built.sampled.grid));
  if (built.summary.placement)
    road::write_projection(built.summary.placement->projection, built.line, file);
  base::write_file(command.output, crg::to_bytes(file, recipe.format));
  terminal.progress_done();
  const std::size_t kerbs = built.summary.kerb.kerbs.size();
  const char* const cleaned = built.clean_reused ? "as the build has it" : "cleaned now";
  terminal.print(terminal.json
                     ? base::json_text(nlohmann::ordered_json{{"u_begin_m", u_begin_m},
                                                              {"u_end_m", u_end_m},
                                                              {"rows", rows},
                                                              {"columns", columns},
                                                              {"kerbs", kerbs},
                                                              {"clean_reused", built.clean_reused},
                                                              {"road", command.output}})
                     : fmt::format("u {:.3f} to {:.3f} m, {} x {} nodes, {} kerbs; the mesh {}\n"
                                   "road  {}\n",
                                   u_begin_m, u_end_m, rows, columns, kerbs, cleaned,
                                   command.output));
  return kOk;
}

}  // namespace crgbuild
