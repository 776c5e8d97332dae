#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/random.h"
#include "circuit_mesh.h"

namespace road {
namespace {

using Eigen::Vector3d;

constexpr double kTerrainDepthM = 0.8;
constexpr double kTerrainRise = 0.25;  // steepest rise of the land away from the track
constexpr double kTerrainSampleM = 8.0;
constexpr double kWallGapM = 0.05;  // between the end of the surface and the barrier
constexpr double kWallThicknessM = 0.25;
constexpr double kWallPieceM = 2.0;
constexpr double kSkirtWidthM = 1.0;
constexpr double kSkirtDropM = 1.3;  // steeper than 45 degrees: nobody's run-off

double outer(const CrossSection& cross, Side side) {
  return side == Side::left ? cross.outer_left_m : cross.outer_right_m;
}
double edge(const CrossSection& cross, Side side) {
  return side == Side::left ? cross.road_left_m : cross.road_right_m;
}
bool cut(const CrossSection& cross, Side side) {
  return side == Side::left ? cross.cut_left : cross.cut_right;
}
double outwards(Side side) { return side == Side::left ? 1.0 : -1.0; }

Vector3d at(const Circuit& circuit, double u_m, double v_m, double z_m) {
  const crg::Point2 point = position_at(circuit, u_m, v_m);
  return {point.x_m, point.y_m, z_m};
}

/// Upright block over the (u, v) rectangle; straight between its corners.
void add_block(const Circuit& circuit, MeshBuilder& builder, std::uint32_t object, double u0,
               double u1, double v0, double v1, double z0, double z1) {
  if (v0 > v1) std::swap(v0, v1);
  builder.box(object, {at(circuit, u0, v0, z0), at(circuit, u1, v0, z0), at(circuit, u1, v1, z0),
                       at(circuit, u0, v1, z0), at(circuit, u0, v0, z1), at(circuit, u1, v0, z1),
                       at(circuit, u1, v1, z1), at(circuit, u0, v1, z1)});
}

void add_barrier(const Circuit& circuit, const std::vector<Ring>& rings,
                 const BarrierDesign& barrier, double chunk_m, MeshBuilder& builder) {
  const double sign = outwards(barrier.side);
  std::optional<std::array<std::uint32_t, 4>> last;
  double last_u = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Ring& ring = rings[i];
    if (ring.u_m < barrier.u_begin_m || ring.u_m > barrier.u_end_m ||
        cut(ring.cross, barrier.side)) {
      last.reset();
      continue;
    }
    const bool end = i + 1 == rings.size() || rings[i + 1].u_m > barrier.u_end_m ||
                     cut(rings[i + 1].cross, barrier.side);
    if (last && !end && ring.u_m - last_u < kWallPieceM) continue;
    const double v = outer(ring.cross, barrier.side);
    const double ground = true_height(circuit, ring.u_m, v);
    const double front = v + sign * kWallGapM;
    const double back = front + sign * kWallThicknessM;
    const double top = ground + barrier.height_m;
    const std::array<std::uint32_t, 4> corners = {
        builder.vertex(at(circuit, ring.u_m, front, ground - 0.3)),
        builder.vertex(at(circuit, ring.u_m, front, top)),
        builder.vertex(at(circuit, ring.u_m, back, top)),
        builder.vertex(at(circuit, ring.u_m, back, ground - 0.3))};
    if (last) {
      const std::uint32_t object =
          builder.object(Part::barrier, barrier.side, static_cast<int>(last_u / chunk_m));
      for (std::size_t k = 0; k < 3; ++k) {
        if (barrier.side == Side::left) {
          builder.quad(object, (*last)[k], corners[k], corners[k + 1], (*last)[k + 1]);
        } else {
          builder.quad(object, corners[k], (*last)[k], (*last)[k + 1], corners[k + 1]);
        }
      }
    }
    last = corners;
    last_u = ring.u_m;
  }
}

bool on_bridge(const Circuit& circuit, double u_m) {
  return std::any_of(
      circuit.design().bridges.begin(), circuit.design().bridges.end(),
      [&](const BridgeDesign& bridge) { return u_m >= bridge.u_begin_m && u_m <= bridge.u_end_m; });
}

/// Steep strip from the end of the surface down into the land.
void add_skirts(const Circuit& circuit, const std::vector<Ring>& rings, const Terrain& terrain,
                double chunk_m, MeshBuilder& builder) {
  const std::size_t bands = rings.size() - (circuit.design().closed ? 0 : 1);
  for (const Side side : {Side::left, Side::right}) {
    std::vector<std::uint32_t> foot(rings.size());
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const Ring& ring = rings[i];
      const std::uint32_t top = side == Side::left ? ring.vertex.back() : ring.vertex.front();
      const crg::Point2 p =
          position_at(circuit, ring.u_m, outer(ring.cross, side) + outwards(side) * kSkirtWidthM);
      const double z =
          std::min(builder.position(top).z() - kSkirtDropM, terrain.height_m(p.x_m, p.y_m) - 0.3);
      foot[i] = builder.vertex({p.x_m, p.y_m, z});
    }
    for (std::size_t i = 0; i < bands; ++i) {
      const std::size_t next = (i + 1) % rings.size();
      const Ring& a = rings[i];
      const Ring& b = rings[next];
      if (cut(a.cross, side) || cut(b.cross, side)) continue;
      if (on_bridge(circuit, a.u_m) && on_bridge(circuit, b.u_m)) continue;
      const std::uint32_t object =
          builder.object(Part::terrain, side, 1 + static_cast<int>(a.u_m / chunk_m));
      if (side == Side::left) {
        builder.quad(object, a.vertex.back(), b.vertex.back(), foot[next], foot[i]);
      } else {
        builder.quad(object, b.vertex.front(), a.vertex.front(), foot[i], foot[next]);
      }
    }
  }
}

void add_terrain(const Circuit& circuit, const std::vector<Ring>& rings, const Terrain& terrain,
                 MeshBuilder& builder) {
  const TerrainDesign& design = circuit.design().terrain;
  Eigen::Vector2d low(1e30, 1e30);
  Eigen::Vector2d high(-1e30, -1e30);
  for (const Ring& ring : rings) {
    for (const std::uint32_t vertex : {ring.vertex.front(), ring.vertex.back()}) {
      low = low.cwiseMin(builder.position(vertex).head<2>());
      high = high.cwiseMax(builder.position(vertex).head<2>());
    }
  }
  low.array() -= design.margin_m;
  high.array() += design.margin_m;
  const auto nx = static_cast<std::size_t>(std::ceil((high.x() - low.x()) / design.cell_m)) + 1;
  const auto ny = static_cast<std::size_t>(std::ceil((high.y() - low.y()) / design.cell_m)) + 1;
  std::vector<std::uint32_t> node(nx * ny);
  for (std::size_t j = 0; j < ny; ++j) {
    for (std::size_t i = 0; i < nx; ++i) {
      const double x = low.x() + static_cast<double>(i) * design.cell_m;
      const double y = low.y() + static_cast<double>(j) * design.cell_m;
      node[j * nx + i] = builder.vertex({x, y, terrain.height_m(x, y)});
    }
  }
  const std::uint32_t object = builder.object(Part::terrain);
  for (std::size_t j = 0; j + 1 < ny; ++j) {
    for (std::size_t i = 0; i + 1 < nx; ++i) {
      builder.quad(object, node[j * nx + i], node[j * nx + i + 1], node[(j + 1) * nx + i + 1],
                   node[(j + 1) * nx + i]);
    }
  }
}

void add_bridge(const std::vector<Ring>& rings, const BridgeDesign& bridge, double chunk_m,
                int number, MeshBuilder& builder) {
  const std::uint32_t sides = builder.object(Part::bridge, Side::left, number);
  const std::uint32_t underside =
      bridge.underside_named_as_road
          ? builder.object(Part::road, Side::left, static_cast<int>(bridge.u_begin_m / chunk_m))
          : sides;
  struct Corners {
    std::uint32_t top_right, top_left, bottom_right, bottom_left;
  };
  std::vector<Corners> corners;
  for (const Ring& ring : rings) {
    if (ring.u_m < bridge.u_begin_m || ring.u_m > bridge.u_end_m) continue;
    const Vector3d down(0.0, 0.0, -bridge.thickness_m);
    const std::uint32_t right = ring.vertex.front();
    const std::uint32_t left = ring.vertex.back();
    corners.push_back({right, left, builder.vertex(builder.position(right) + down),
                       builder.vertex(builder.position(left) + down)});
  }
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Corners& a = corners[i];
    const Corners& b = corners[i + 1];
    builder.quad(underside, a.bottom_right, a.bottom_left, b.bottom_left, b.bottom_right);
    builder.quad(sides, a.bottom_left, a.top_left, b.top_left, b.bottom_left);
    builder.quad(sides, a.top_right, a.bottom_right, b.bottom_right, b.top_right);
  }
  if (corners.size() < 2) return;
  const Corners& first = corners.front();
  const Corners& last = corners.back();
  builder.quad(sides, first.top_right, first.top_left, first.bottom_left, first.bottom_right);
  builder.quad(sides, last.top_left, last.top_right, last.bottom_right, last.bottom_left);
}

/// Two upright quads crossing at the trunk and a level one through the crown, the usual billboard
/// tree.
void add_trees(const Circuit& circuit, const TreeRow& row, int number, base::Random& random,
               MeshBuilder& builder) {
  const std::uint32_t object = builder.object(Part::trees, row.side, number);
  double u = row.u_begin_m;
  while (u < row.u_end_m) {
    const double at_u = u;
    u += row.spacing_m * random.uniform(0.7, 1.3);
    const double size = random.uniform(0.85, 1.15);
    const double yaw = random.uniform(0.0, 2.0 * std::numbers::pi);
    const CrossSection cross = section_at(circuit, at_u);
    if (cut(cross, row.side)) continue;
    const double v = edge(cross, row.side) + outwards(row.side) * row.from_road_edge_m;
    const double inside = std::clamp(v, cross.outer_right_m, cross.outer_left_m);
    const double drop = std::abs(v - inside) > 0.0 ? kTerrainDepthM : 0.0;
    const double ground = true_height(circuit, at_u, inside) - drop - 0.1;
    const Vector3d foot = at(circuit, at_u, v, ground);
    const double height = size * row.height_m;
    const double radius = 0.5 * size * row.crown_width_m;
    const Vector3d up(0.0, 0.0, height);
    for (const double turn : {0.0, 0.5 * std::numbers::pi}) {
      const Vector3d arm(radius * std::cos(yaw + turn), radius * std::sin(yaw + turn), 0.0);
      builder.quad(object, {foot - arm, foot + arm, foot + arm + up, foot - arm + up});
    }
    const Vector3d along(radius * std::cos(yaw), radius * std::sin(yaw), 0.0);
    const Vector3d across(-along.y(), along.x(), 0.0);
    const Vector3d crown = foot + 0.65 * up;
    builder.quad(object, {crown - along - across, crown + along - across, crown + along + across,
                          crown - along + across});
  }
}

void add_grandstand(const Circuit& circuit, const Grandstand& stand, int number,
                    MeshBuilder& builder) {
  constexpr int kSteps = 6;
  const std::uint32_t object = builder.object(Part::grandstand, stand.side, number);
  const double sign = outwards(stand.side);
  const double middle = 0.5 * (stand.u_begin_m + stand.u_end_m);
  const CrossSection cross = section_at(circuit, middle);
  const double ground = true_height(circuit, middle, edge(cross, stand.side));
  const double front = edge(cross, stand.side) + sign * stand.from_road_edge_m;
  const double back = front + sign * stand.depth_m;
  const double rise = (0.6 * stand.height_m - 1.0) / (kSteps - 1);
  for (int step = 0; step < kSteps; ++step) {
    const double v = front + sign * stand.depth_m * step / kSteps;
    add_block(circuit, builder, object, stand.u_begin_m, stand.u_end_m, v,
              front + sign * stand.depth_m * (step + 1) / kSteps, ground - 3.0,
              ground + 1.0 + rise * step);
  }
  add_block(circuit, builder, object, stand.u_begin_m, stand.u_end_m,
            front - sign * stand.roof_overhang_m, back, ground + stand.height_m,
            ground + stand.height_m + 0.3);
}

void add_gantry(const Circuit& circuit, const Gantry& gantry, int number, MeshBuilder& builder) {
  const std::uint32_t object = builder.object(Part::gantry, Side::left, number);
  const double u0 = gantry.u_m;
  const double u1 = gantry.u_m + gantry.length_m;
  double highest = -1e30;
  double right = 0.0;
  double left = 0.0;
  for (const double u : {u0, 0.5 * (u0 + u1), u1}) {
    const CrossSection cross = section_at(circuit, u);
    right = std::min(right, cross.outer_right_m);
    left = std::max(left, cross.outer_left_m);
    for (int k = 0; k <= 8; ++k) {
      const double v = cross.outer_right_m + k / 8.0 * (cross.outer_left_m - cross.outer_right_m);
      highest = std::max(highest, true_height(circuit, u, v));
    }
  }
  const double underside = highest + gantry.clearance_m;
  add_block(circuit, builder, object, u0, u1, right - 1.0, left + 1.0, underside,
            underside + gantry.height_m);
  for (const Side side : {Side::left, Side::right}) {
    const double v = (side == Side::left ? left : right) + outwards(side) * 0.5;
    const double ground = true_height(circuit, u0, outer(section_at(circuit, u0), side));
    add_block(circuit, builder, object, u0, u1, v, v + outwards(side) * 0.4, ground - 2.0,
              underside);
  }
}

}  // namespace

Terrain::Terrain(const Circuit& circuit) : hill_m_(circuit.design().terrain.hill_m) {
  const auto count = static_cast<std::size_t>(std::ceil(circuit.length_m() / kTerrainSampleM)) + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double u = circuit.length_m() * static_cast<double>(i) / static_cast<double>(count);
    const ReferencePoint point = reference_at(circuit, u);
    const CrossSection cross = section_at(circuit, u);
    const double z =
        std::min({true_height(circuit, u, cross.outer_left_m), true_height(circuit, u, 0.0),
                  true_height(circuit, u, cross.outer_right_m)});
    samples_.push_back({point.x_m, point.y_m, z});
    reach_m_ = std::max({reach_m_, cross.outer_left_m, -cross.outer_right_m});
  }
  // A cell that touches the surface has all its nodes within this distance of a sample.
  reach_m_ += std::numbers::sqrt2 * circuit.design().terrain.cell_m + kTerrainSampleM;
}

double Terrain::height_m(double x_m, double y_m) const {
  double lowest = 1e30;
  for (const Sample& sample : samples_) {
    const double distance = std::hypot(x_m - sample.x_m, y_m - sample.y_m) - reach_m_;
    double rise = 0.0;
    if (distance > 0.0 && hill_m_ > 0.0) {
      rise = hill_m_ * (1.0 - std::exp(-kTerrainRise * distance / hill_m_));
    }
    lowest = std::min(lowest, sample.z_m - kTerrainDepthM + rise);
  }
  return lowest;
}

void add_scenery(const Circuit& circuit, const std::vector<Ring>& rings, double chunk_m,
                 MeshBuilder& builder) {
  const CircuitDesign& design = circuit.design();
  int number = 0;
  for (const BridgeDesign& bridge : design.bridges) {
    add_bridge(rings, bridge, chunk_m, number++, builder);
  }
  for (const BarrierDesign& barrier : design.barriers) {
    add_barrier(circuit, rings, barrier, chunk_m, builder);
  }
  number = 0;
  for (const Gantry& gantry : design.gantries) add_gantry(circuit, gantry, number++, builder);
  number = 0;
  for (const Grandstand& stand : design.grandstands)
    add_grandstand(circuit, stand, number++, builder);
  base::Random random(design.seed);
  number = 0;
  for (const TreeRow& row : design.trees) add_trees(circuit, row, number++, random, builder);
  if (design.terrain.present) {
    const Terrain terrain(circuit);
    add_skirts(circuit, rings, terrain, chunk_m, builder);
    add_terrain(circuit, rings, terrain, builder);
  }
}

}  // namespace road
