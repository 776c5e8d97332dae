// A circuit as a designer draws it: plan, width, banking, elevation, kerbs - and its exact surface.
//
// (u, v): u is the arc length of the reference curve in metres, v the horizontal distance to its
// left. The surface is the pure function true_height(u, v); nothing here is sampled or meshed.
// yaml-cpp stays private to read_circuit.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "circuit/iso8608.h"
#include "crg/file.h"
#include "mesh/mesh.h"

namespace road {

enum class Side : std::uint8_t { left, right };

/// One piece of the plan view: curvature runs linearly from begin to end over the length
/// (straight: 0, 0; arc: equal; clothoid: different). Left turns are positive.
struct PlanSegment {
  double length_m = 0.0;
  double curvature_begin_1pm = 0.0;
  double curvature_end_1pm = 0.0;
  bool solve_length = false;  ///< a straight whose length closes the circuit
};

/// Values at ascending u. One knot = constant. Closed circuits: periodic. elevation is a natural
/// (open) or periodic C2 cubic spline; everything else a monotone C1 cubic (Fritsch & Butland
/// 1984), which never overshoots its knots.
struct Knots {
  std::vector<double> u_m;
  std::vector<double> value;
};

/// Height over the base plane across the kerb, as a polyline from the road (t = 0) outwards (t =
/// 1).
struct KerbProfile {
  std::string name;            ///< ramp, flat, sausage, or given as points
  std::vector<double> t;       ///< ascending from 0 to 1
  std::vector<double> height;  ///< share of the kerb's height, 0 at t = 0 and t = 1
};

struct KerbDesign {
  double u_begin_m = 0.0, u_end_m = 0.0;
  Side side = Side::left;
  double width_m = 1.0;
  double height_m = 0.05;
  double taper_m = 2.0;  ///< rises linearly from and falls linearly to 0 over this length
  KerbProfile profile;
};

/// A known bump (or dip, height < 0). cosine: h * (1 + cos) / 2 over the length. plateau: the same
/// flanks on the outer quarters, flat between. Across it has the same shape over width_m; width_m =
/// 0 means the whole width.
struct BumpDesign {
  enum class Shape : std::uint8_t { cosine, plateau } shape = Shape::cosine;
  double u_m = 0.0, v_m = 0.0;  ///< middle
  double length_m = 2.0, width_m = 0.0;
  double height_m = 0.02;
};

struct BarrierDesign {
  double u_begin_m = 0.0, u_end_m = 0.0;
  Side side = Side::left;
  double height_m = 0.9;
};

struct TreeRow {
  double u_begin_m = 0.0, u_end_m = 0.0;
  Side side = Side::left;
  double spacing_m = 12.0;
  double from_road_edge_m = 8.0;  ///< trunk to road edge
  double height_m = 9.0;
  double crown_width_m = 6.0;  ///< a crown wider than 2 * from_road_edge_m overhangs the road
};

struct Grandstand {
  double u_begin_m = 0.0, u_end_m = 0.0;
  Side side = Side::left;
  double from_road_edge_m = 14.0;  ///< front row
  double depth_m = 12.0, height_m = 8.0;
  double roof_overhang_m = 3.0;  ///< roof in front of the front row
};

/// A beam across the whole road on two posts.
struct Gantry {
  double u_m = 0.0;
  double clearance_m = 5.5;  ///< underside over the highest road point below it
  double length_m = 1.0;     ///< along u
  double height_m = 1.2;
};

/// A part of the track that is a bridge deck: no skirts to the terrain, but sides and an underside.
struct BridgeDesign {
  double u_begin_m = 0.0, u_end_m = 0.0;
  double thickness_m = 1.2;
  bool underside_named_as_road =
      false;  ///< as in some real exports: the underside is in the road object
};

/// A piece of road that belongs to an object of its own (start grid), as in real exports.
struct StartStrip {
  double u_begin_m = 0.0, u_end_m = 0.0;
};

struct TerrainDesign {
  bool present = true;
  double cell_m = 12.0;
  double margin_m = 60.0;  ///< beyond the track's bounding box
  double hill_m = 8.0;     ///< how high it may rise beside the track
};

/// Everything in circuit.yaml, in metres, m/m and radians.
struct CircuitDesign {
  std::string name = "circuit";
  bool closed = true;
  double start_x_m = 0.0, start_y_m = 0.0, start_heading_rad = 0.0;
  std::vector<PlanSegment> plan;
  Knots width_left_m, width_right_m;    ///< road edge from the reference curve
  Knots elevation_m;                    ///< of the reference curve
  Knots banking;                        ///< m/m of the road, rise towards +v
  Knots runoff_left_m, runoff_right_m;  ///< width beyond the road edge, kerb included
  Knots runoff_slope_left,
      runoff_slope_right;  ///< m/m added to the banking plane, rise outwards positive
  std::vector<KerbDesign> kerbs;
  std::vector<BumpDesign> bumps;
  std::optional<RoughnessOptions> roughness;
  std::vector<BarrierDesign> barriers;
  std::vector<TreeRow> trees;
  std::vector<Grandstand> grandstands;
  std::vector<Gantry> gantries;
  std::vector<BridgeDesign> bridges;
  std::vector<StartStrip> start_strips;
  TerrainDesign terrain;
  std::uint64_t seed = 1;  ///< scenery
};

/// Reference curve at one u.
struct ReferencePoint {
  double x_m, y_m;
  double heading_rad;  ///< continuous along u, not wrapped
  double curvature_1pm;
};

/// Where the parts of the surface lie across at one u; v from the right (negative) to the left.
struct CrossSection {
  double z_m;  ///< of the reference curve (elevation only)
  double banking;
  double outer_right_m, road_right_m, road_left_m, outer_left_m;
  bool cut_right, cut_left;  ///< the run-off ends early at the middle to another leg
};

struct CircuitUV {
  double u_m, v_m;
};

/// A circuit whose plan closes. Immutable and cheap to copy; safe to share between threads.
///
/// Accuracy: positions on the reference curve are within 1e-11 m of the Fresnel integrals (10-point
/// Gauss-Legendre panels of at most 0.5 rad; straights and arcs in closed form); heights are sums
/// of a few doubles.
class Circuit {
 public:
  /// Solves the straights marked solve_length so that the plan closes, builds the splines and finds
  /// where the run-off must end at the middle to a neighbouring leg (hairpins). Throws Error naming
  /// the value: closing error with its size, overlapping kerbs, knots out of order, u beyond the
  /// length, curvature jumps, road (without run-off) folding over itself.
  explicit Circuit(CircuitDesign design);

  const CircuitDesign& design() const noexcept;  ///< with solved lengths
  double length_m() const noexcept;
  double closing_error_m()
      const noexcept;  ///< distance of the curve's end from its start, after solving

  struct Data;
  const Data& data() const noexcept { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

/// Reads circuit.yaml (docs/circuit.md). Throws Error with file:line on unknown keys, wrong types,
/// values out of range, and what the constructor refuses.
Circuit read_circuit(const std::string& path);

/// u is wrapped on a closed circuit, clamped on an open one.
ReferencePoint reference_at(const Circuit& circuit, double u_m);
CrossSection section_at(const Circuit& circuit, double u_m);
crg::Point2 position_at(const Circuit& circuit, double u_m, double v_m);

/// z at (u, v): elevation + banking + run-off + kerbs + bumps + roughness. NaN outside the surface.
double true_height(const Circuit& circuit, double u_m, double v_m);

/// What lies at (u, v): road, kerb or runoff; nothing outside the surface.
std::optional<SurfaceClass> true_class(const Circuit& circuit, double u_m, double v_m);

/// Every (u, v) on the surface whose map position is (x, y), to 1e-9 m: none beside the track, two
/// where the track crosses itself.
std::vector<CircuitUV> uv_of_position(const Circuit& circuit, double x_m, double y_m);

/// The circuit as a CRG: rows and columns at most `step_m` apart over the whole surface, all
/// heights in the grid, the last row a repetition of the first 1 mm before it when closed.
crg::Crg truth_crg(const Circuit& circuit, double step_m = 0.1);

}  // namespace road
