#include "circuit_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/error.h"
#include "rings.h"

namespace road {
namespace {

/// Triangles between a piece of ring `a` and a piece of the next ring `b`, both from right to left.
/// The pieces may have different numbers of vertices; every vertex is used, so borders stay
/// watertight.
void zip(MeshBuilder& builder, std::uint32_t object, const Ring& a, std::size_t a_begin,
         std::size_t a_end, const Ring& b, std::size_t b_begin, std::size_t b_end) {
  const auto share = [](const Ring& ring, std::size_t begin, std::size_t end, std::size_t i) {
    return (ring.v_m[i] - ring.v_m[begin]) / (ring.v_m[end] - ring.v_m[begin]);
  };
  std::size_t i = a_begin;
  std::size_t j = b_begin;
  while (i < a_end || j < b_end) {
    const bool advance_a = j == b_end || (i < a_end && share(a, a_begin, a_end, i + 1) <=
                                                           share(b, b_begin, b_end, j + 1));
    if (advance_a) {
      builder.triangle(object, a.vertex[i], b.vertex[j], a.vertex[i + 1]);
      ++i;
    } else {
      builder.triangle(object, a.vertex[i], b.vertex[j], b.vertex[j + 1]);
      ++j;
    }
  }
}

void add_band(const Circuit& circuit, const Ring& a, const Ring& b, double chunk_m,
              MeshBuilder& builder) {
  const CircuitDesign& design = circuit.design();
  const double middle = a.u_m + 0.5 * along_circuit(circuit, a.u_m, b.u_m);
  const int chunk = static_cast<int>(middle / chunk_m);
  std::uint32_t road = 0;
  bool strip = false;
  for (std::size_t k = 0; k < design.start_strips.size() && !strip; ++k) {
    strip = middle > design.start_strips[k].u_begin_m && middle < design.start_strips[k].u_end_m;
    if (strip) road = builder.object(Part::start_strip, Side::left, static_cast<int>(k));
  }
  if (!strip) road = builder.object(Part::road, Side::left, chunk);
  zip(builder, road, a, a.road_right, a.road_left, b, b.road_right, b.road_left);

  const auto kerb_number = [&](const KerbDesign* kerb) {
    return static_cast<int>(kerb - design.kerbs.data());
  };
  const KerbDesign* left = kerb_at(circuit, Side::left, middle);
  const std::size_t last_a = a.v_m.size() - 1;
  const std::size_t last_b = b.v_m.size() - 1;
  std::size_t from_a = a.road_left;
  std::size_t from_b = b.road_left;
  if (left) {
    zip(builder, builder.object(Part::kerb, Side::left, kerb_number(left)), a, a.road_left,
        a.kerb_left, b, b.road_left, b.kerb_left);
    from_a = a.kerb_left;
    from_b = b.kerb_left;
  }
  if (from_a < last_a || from_b < last_b) {
    zip(builder, builder.object(Part::runoff, Side::left, chunk), a, from_a, last_a, b, from_b,
        last_b);
  }
  const KerbDesign* right = kerb_at(circuit, Side::right, middle);
  std::size_t to_a = a.road_right;
  std::size_t to_b = b.road_right;
  if (right) {
    zip(builder, builder.object(Part::kerb, Side::right, kerb_number(right)), a, a.kerb_right,
        a.road_right, b, b.kerb_right, b.road_right);
    to_a = a.kerb_right;
    to_b = b.kerb_right;
  }
  if (to_a > 0 || to_b > 0) {
    zip(builder, builder.object(Part::runoff, Side::right, chunk), a, 0, to_a, b, 0, to_b);
  }
}

/// Inside a hairpin the run-off ends at the middle on both legs; the strip left between them is
/// filled so that the surface goes on, as grass does. Not part of true_height.
void fill_hairpins(const std::vector<Ring>& rings, double chunk_m, MeshBuilder& builder) {
  constexpr double kWidestMouthM = 3.0;
  const std::size_t count = rings.size();
  for (const Side side : {Side::left, Side::right}) {
    const auto is_cut = [&](std::size_t i) {
      return side == Side::left ? rings[i].cross.cut_left : rings[i].cross.cut_right;
    };
    std::size_t origin = 0;  // a ring that is not cut, so that no range crosses the seam
    while (origin < count && is_cut(origin)) ++origin;
    if (origin == count) continue;
    for (std::size_t k = 0; k < count;) {
      if (!is_cut((origin + k) % count)) {
        ++k;
        continue;
      }
      std::vector<std::uint32_t> border;
      const double u = rings[(origin + k) % count].u_m;
      for (; k < count && is_cut((origin + k) % count); ++k) {
        const Ring& ring = rings[(origin + k) % count];
        border.push_back(side == Side::left ? ring.vertex.back() : ring.vertex.front());
      }
      const auto distance = [&](std::size_t i, std::size_t j) {
        return (builder.position(border[i]) - builder.position(border[j])).head<2>().norm();
      };
      if (border.size() < 3 || distance(0, border.size() - 1) > kWidestMouthM) continue;
      const std::uint32_t object =
          builder.object(Part::runoff, side, static_cast<int>(u / chunk_m));
      const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
        if (side == Side::left) {
          builder.triangle(object, border[a], border[b], border[c]);
        } else {
          builder.triangle(object, border[b], border[a], border[c]);
        }
      };
      std::size_t i = 0;
      std::size_t j = border.size() - 1;
      while (j - i > 1) {
        if (distance(i + 1, j) <= distance(i, j - 1)) {
          add(i, i + 1, j);
          ++i;
        } else {
          add(i, j - 1, j);
          --j;
        }
      }
    }
  }
}

}  // namespace

Mesh make_circuit_mesh(const Circuit& circuit, const SynthOptions& options) {
  for (const auto& [name, value] : {std::pair{"ring_step_m", options.ring_step_m},
                                    std::pair{"column_step_m", options.column_step_m},
                                    std::pair{"max_sagitta_m", options.max_sagitta_m}}) {
    if (!(value > 0.0) || !(value <= 100.0)) {
      throw Error(fmt::format("{} is {}; give more than 0 and at most 100", name, value));
    }
  }
  if (!(options.chunk_m >= 1.0)) {
    throw Error(fmt::format("chunk_m is {}; give at least 1", options.chunk_m));
  }
  // Whole chunks, so that no object is a short rest.
  const double chunk_m =
      circuit.length_m() / std::max(1.0, std::round(circuit.length_m() / options.chunk_m));
  const std::vector<double> stations = place_rings(circuit, options, chunk_m);
  const Columns columns = count_columns(circuit, stations, options);
  MeshBuilder builder(options.names);
  std::vector<Ring> rings;
  rings.reserve(stations.size());
  for (const double u : stations) rings.push_back(make_ring(circuit, u, columns, builder));
  const bool closed = circuit.design().closed;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < rings.size(); ++i) {
    add_band(circuit, rings[i], rings[(i + 1) % rings.size()], chunk_m, builder);
  }
  fill_hairpins(rings, chunk_m, builder);
  add_scenery(circuit, rings, chunk_m, builder);
  return builder.take();
}

}  // namespace road
