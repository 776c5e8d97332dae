// Cross sections of a synthetic circuit's mesh. Private to it.
#pragma once

#include <cstddef>
#include <vector>

#include "circuit_mesh.h"

namespace road {

/// Signed distance along u, the short way round when closed.
double along_circuit(const Circuit& circuit, double from_u_m, double to_u_m);

/// Where cross sections lie: at every begin and end of a feature, and between them close enough.
std::vector<double> place_rings(const Circuit& circuit, const SynthOptions& options,
                                double chunk_m);

struct Columns {
  std::size_t road, left, right;  // number of strips across
};

Columns count_columns(const Circuit& circuit, const std::vector<double>& rings,
                      const SynthOptions& options);

/// The kerb of a side at u; null where it has none.
const KerbDesign* kerb_at(const Circuit& circuit, Side side, double u_m);

Ring make_ring(const Circuit& circuit, double u_m, const Columns& columns, MeshBuilder& builder);

}  // namespace road
