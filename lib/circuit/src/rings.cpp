#include "rings.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace road {
namespace {

// Rings and columns on bumps are close enough that the facets stay this near to the bump.
constexpr double kBumpErrorM = 0.0003;

constexpr double kRunoffStepFactor = 2.0;

double bump_step(const BumpDesign& bump, double extent_m) {
  // Largest second derivative of h (1 + cos(2 pi x / l)) / 2 is h/2 (2 pi / l)^2; the flanks of a
  // plateau are half as long, which makes it four times that. A chord of length d leaves by f'' d^2
  // / 8.
  const double flank = bump.shape == BumpDesign::Shape::plateau ? 0.5 : 1.0;
  const double wave = 2.0 * std::numbers::pi / (flank * extent_m);
  return std::sqrt(8.0 * kBumpErrorM / (0.5 * std::abs(bump.height_m) * wave * wave));
}

bool on_bump(const Circuit& circuit, const BumpDesign& bump, double u_m) {
  return std::abs(along_circuit(circuit, bump.u_m, u_m)) < 0.5 * bump.length_m + 1e-9;
}

/// Offsets from the road edge outwards: kerb corners, then run-off. The first is 0.
std::vector<double> side_offsets(const KerbDesign* kerb, double room_m, std::size_t strips,
                                 std::size_t& kerb_vertices) {
  std::vector<double> offsets = {0.0};
  kerb_vertices = 0;
  if (kerb) {
    for (std::size_t i = 1; i < kerb->profile.t.size(); ++i) {
      offsets.push_back(kerb->profile.t[i] * kerb->width_m);
    }
    kerb_vertices = kerb->profile.t.size() - 1;
  }
  const double begin = offsets.back();
  if (room_m - begin > 1e-6) {
    for (std::size_t i = 1; i <= strips; ++i) {
      offsets.push_back(i == strips ? room_m
                                    : begin + (room_m - begin) * static_cast<double>(i) /
                                                  static_cast<double>(strips));
    }
  }
  return offsets;
}

}  // namespace

double along_circuit(const Circuit& circuit, double from_u_m, double to_u_m) {
  const double distance = to_u_m - from_u_m;
  return circuit.design().closed ? std::remainder(distance, circuit.length_m()) : distance;
}

std::vector<double> place_rings(const Circuit& circuit, const SynthOptions& options,
                                double chunk_m) {
  const CircuitDesign& design = circuit.design();
  const double length = circuit.length_m();
  std::vector<double> fixed = {0.0, length};
  const auto fix = [&](double u) {
    if (design.closed) {
      u = std::fmod(u, length);
      if (u < 0.0) u += length;
    }
    if (u > 0.0 && u < length) fixed.push_back(u);
  };
  for (int k = 1; k * chunk_m < length; ++k) fix(k * chunk_m);
  for (const KerbDesign& kerb : design.kerbs) {
    for (const double u : {kerb.u_begin_m, kerb.u_begin_m + kerb.taper_m,
                           kerb.u_end_m - kerb.taper_m, kerb.u_end_m}) {
      fix(u);
    }
  }
  for (const BumpDesign& bump : design.bumps) {
    for (const double share : {-0.5, -0.25, 0.0, 0.25, 0.5}) fix(bump.u_m + share * bump.length_m);
  }
  for (const BridgeDesign& bridge : design.bridges) fix(bridge.u_begin_m), fix(bridge.u_end_m);
  for (const StartStrip& strip : design.start_strips) fix(strip.u_begin_m), fix(strip.u_end_m);
  std::sort(fixed.begin(), fixed.end());
  // Features that begin where others end give one ring; a ring a hair beside another would only
  // make slivers. Rounding differences stay far below this.
  fixed.erase(
      std::unique(fixed.begin(), fixed.end(), [](double a, double b) { return b - a < 1e-7; }),
      fixed.end());

  std::vector<double> rings;
  for (std::size_t i = 0; i + 1 < fixed.size(); ++i) {
    constexpr double kPieceM = 5.0;  // the step follows the bends
    const double span = fixed[i + 1] - fixed[i];
    const auto pieces = static_cast<int>(std::ceil(span / std::max(kPieceM, options.ring_step_m)));
    for (int piece = 0; piece < pieces; ++piece) {
      const double begin = fixed[i] + span * piece / pieces;
      const double end = fixed[i] + span * (piece + 1) / pieces;
      double bend = 0.0;
      for (int k = 0; k <= 4; ++k) {
        const double u = std::min(begin + (end - begin) * k / 4.0, std::nextafter(length, 0.0));
        bend = std::max(bend, std::abs(reference_at(circuit, u).curvature_1pm));
      }
      double step = options.ring_step_m;
      if (bend > 0.0) step = std::min(step, std::sqrt(8.0 * options.max_sagitta_m / bend));
      for (const BumpDesign& bump : design.bumps) {
        if (on_bump(circuit, bump, 0.5 * (begin + end)) && bump.height_m != 0.0) {
          step = std::min(step, bump_step(bump, bump.length_m));
        }
      }
      const auto count = static_cast<int>(std::ceil((end - begin) / step - 1e-9));
      for (int k = 0; k < count; ++k) rings.push_back(begin + (end - begin) * k / count);
    }
  }
  if (!design.closed) rings.push_back(length);
  return rings;
}

Columns count_columns(const Circuit& circuit, const std::vector<double>& rings,
                      const SynthOptions& options) {
  double road = 0.0;
  double left = 0.0;
  double right = 0.0;
  for (const double u : rings) {
    const CrossSection cross = section_at(circuit, u);
    road = std::max(road, cross.road_left_m - cross.road_right_m);
    left = std::max(left, cross.outer_left_m - cross.road_left_m);
    right = std::max(right, cross.road_right_m - cross.outer_right_m);
  }
  const auto strips = [](double width, double step) {
    return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(width / step - 1e-9)));
  };
  const double runoff_step = kRunoffStepFactor * options.column_step_m;
  return {strips(road, options.column_step_m), strips(left, runoff_step),
          strips(right, runoff_step)};
}

const KerbDesign* kerb_at(const Circuit& circuit, Side side, double u_m) {
  for (const KerbDesign& kerb : circuit.design().kerbs) {
    if (kerb.side == side && u_m >= kerb.u_begin_m - 1e-7 && u_m <= kerb.u_end_m + 1e-7)
      return &kerb;
  }
  return nullptr;
}

Ring make_ring(const Circuit& circuit, double u_m, const Columns& columns, MeshBuilder& builder) {
  Ring ring;
  ring.u_m = u_m;
  ring.cross = section_at(circuit, u_m);
  const CrossSection& cross = ring.cross;
  std::size_t kerb_left = 0;
  std::size_t kerb_right = 0;
  const std::vector<double> left =
      side_offsets(kerb_at(circuit, Side::left, u_m), cross.outer_left_m - cross.road_left_m,
                   columns.left, kerb_left);
  const std::vector<double> right =
      side_offsets(kerb_at(circuit, Side::right, u_m), cross.road_right_m - cross.outer_right_m,
                   columns.right, kerb_right);
  for (std::size_t i = right.size() - 1; i > 0; --i)
    ring.v_m.push_back(cross.road_right_m - right[i]);
  ring.road_right = ring.v_m.size();
  ring.kerb_right = ring.road_right - kerb_right;

  const double width = cross.road_left_m - cross.road_right_m;
  std::size_t strips = columns.road;
  for (const BumpDesign& bump : circuit.design().bumps) {
    if (bump.width_m > 0.0 && bump.height_m != 0.0 && on_bump(circuit, bump, u_m)) {
      strips = std::max(strips,
                        static_cast<std::size_t>(std::ceil(width / bump_step(bump, bump.width_m))));
    }
  }
  for (std::size_t i = 0; i <= strips; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(strips);
    ring.v_m.push_back(i == strips ? cross.road_left_m : cross.road_right_m + width * share);
  }
  ring.road_left = ring.v_m.size() - 1;
  ring.kerb_left = ring.road_left + kerb_left;
  for (std::size_t i = 1; i < left.size(); ++i) ring.v_m.push_back(cross.road_left_m + left[i]);

  const ReferencePoint point = reference_at(circuit, u_m);
  for (const double v : ring.v_m) {
    ring.vertex.push_back(builder.vertex({point.x_m - v * std::sin(point.heading_rad),
                                          point.y_m + v * std::cos(point.heading_rad),
                                          true_height(circuit, u_m, v)}));
  }
  return ring;
}

}  // namespace road
