// A mesh such as a simulator exports, made from a circuit, and the circuit's exact heights as a
// CRG.
#pragma once

#include <string>

#include "circuit/circuit.h"
#include "mesh/mesh.h"
#include "mesh/read_mesh.h"

namespace road {

enum class MeshFormat { obj, glb, ply, stl };

/// How objects and materials are called: as in TORCS (TKMN0, TKLS0, T0LB, B0LT, TERR, OBJ, TREE),
/// as for Assetto Corsa (1ROAD_00, 2KERB_L_00, 3GRASS_L_00, 4WALL_L_00), in plain English, or not
/// at all.
enum class NameStyle { torcs, ac, plain, none };

/// Coarse facets as in old simulators: ring_step_m 10, column_step_m 5, max_sagitta_m 0.3.
struct SynthOptions {
  MeshFormat format = MeshFormat::obj;
  UpAxis up = UpAxis::y;  ///< y: (x, y, z) is written as (x, z, -y); automatic counts as y
  Unit unit = Unit::m;    ///< automatic counts as m
  NameStyle names = NameStyle::plain;
  double ring_step_m = 0.5;    ///< largest distance of cross sections
  double column_step_m = 1.0;  ///< largest distance of vertices across the road; run-off: 2x
  double max_sagitta_m =
      0.001;  ///< closer cross sections in bends, so that chords leave the curve by no more
  double chunk_m = 250.0;     ///< a new object begins about every so many metres
  double truth_step_m = 0.1;  ///< of the truth CRG along u and v
};

/// How far a mesh is from the exact surface, in z at 20,000 seeded points per class (run-off: where
/// no kerb lies); all 0 without such a class.
struct SynthError {
  double road_p99_m = 0.0, road_max_m = 0.0;
  double kerb_p99_m = 0.0, kerb_max_m = 0.0;
  double runoff_p99_m = 0.0, runoff_max_m = 0.0;
  std::size_t points_without_mesh = 0;  ///< no triangle within 0.5 m of the exact height
};

struct SynthOutput {
  std::string mesh_path;   ///< DIR/<name>.<format> (and DIR/<name>.mtl for obj)
  std::string truth_path;  ///< DIR/<name>_truth.crg, float64 binary (KDBI)
  std::size_t vertices = 0, triangles = 0, objects = 0;
  double length_m = 0.0;
  double closing_error_m = 0.0;
  SynthError mesh_error;
};

/// The mesh in memory: metres, z up, origin at 0, vertices shared between neighbouring objects.
/// Vertices of road, kerbs and run-off lie on true_height exactly; these three form one surface
/// that is watertight at all shared edges. Same circuit and options give the same bytes on any
/// machine with the same libm.
Mesh make_circuit_mesh(const Circuit& circuit, const SynthOptions& options = {});

/// Distance in z of `mesh` (from make_circuit_mesh) from the exact surface.
SynthError measure_mesh_error(const Circuit& circuit, const Mesh& mesh);

/// Writes mesh and truth into `output_dir` (made if missing). Each file appears whole or not at
/// all.
SynthOutput write_synth(const Circuit& circuit, const std::string& output_dir,
                        const SynthOptions& options = {});

}  // namespace road
