#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "circuit/synth.h"
#include "commands.h"

namespace crgbuild {

int run_synth(const SynthCommand& command, Terminal& terminal) {
  road::SynthOptions options;
  options.format = command.format == "glb"   ? road::MeshFormat::glb
                   : command.format == "ply" ? road::MeshFormat::ply
                   : command.format == "stl" ? road::MeshFormat::stl
                                             : road::MeshFormat::obj;
  options.up = command.up == "z" ? road::UpAxis::z : road::UpAxis::y;
  options.names = command.names == "torcs"  ? road::NameStyle::torcs
                  : command.names == "ac"   ? road::NameStyle::ac
                  : command.names == "none" ? road::NameStyle::none
                                            : road::NameStyle::plain;
  options.unit = road::unit_called(command.unit);
  // The sagitta grows with the square of a chord: bends get coarser in step with straights.
  const double coarser = command.facet_m / options.ring_step_m;
  options.ring_step_m = command.facet_m;
  options.column_step_m *= std::max(1.0, coarser / 4.0);
  options.max_sagitta_m *= coarser * coarser;
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  const road::Circuit circuit = road::read_circuit(command.circuit);
  progress("synth", 0.2);
  const road::SynthOutput made = road::write_synth(circuit, command.output_dir, options);
  terminal.progress_done();
  if (terminal.json) {
    const nlohmann::ordered_json numbers = {
        {"mesh", made.mesh_path},
        {"truth", made.truth_path},
        {"vertices", made.vertices},
        {"triangles", made.triangles},
        {"objects", made.objects},
        {"length_m", made.length_m},
        {"closing_error_m", made.closing_error_m},
        {"mesh_error",
         {{"road_p99_m", made.mesh_error.road_p99_m},
          {"road_max_m", made.mesh_error.road_max_m},
          {"kerb_p99_m", made.mesh_error.kerb_p99_m},
          {"kerb_max_m", made.mesh_error.kerb_max_m},
          {"runoff_p99_m", made.mesh_error.runoff_p99_m},
          {"runoff_max_m", made.mesh_error.runoff_max_m},
          {"points_without_mesh", made.mesh_error.points_without_mesh}}}};
    terminal.print(base::json_text(numbers));
  } else {
    terminal.print(
        fmt::format("circuit of {:.1f} m: {} triangles in {} objects, road within {:.2f} mm of the "
                    "exact surface\n"
                    "mesh   {}\ntruth  {}\n",
                    made.length_m, made.triangles, made.objects, 1e3 * made.mesh_error.road_p99_m,
                    made.mesh_path, made.truth_path));
  }
  return kOk;
}

}  // namespace crgbuild
