#include "circuit_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "road/error.h"

namespace road {
namespace {

// Rings and columns on bumps are close enough that the facets stay this near to the bump.
constexpr double kBumpErrorM = 0.0003;
constexpr double kRunoffStepFactor = 2.0;

struct Names {
  const char* object;  // {0} side, {1} number
  const char* material;
  const char* texture;
};

// As found in exports for each simulator: kerbs in TORCS are border strips that only their texture
// tells, its land and skirts are TERR, and the start strip never carries the road's name.
Names names_of(NameStyle style, Part part) {
  switch (style) {
    case NameStyle::torcs:
      switch (part) {
        case Part::road:
          return {"TKMN{1}", "asphalt", "tr-asphalt-base.png"};
        case Part::start_strip:
          return {"SLINE{1}", "line", "tr-start-base.png"};
        case Part::kerb:
          return {"T{1}{0}B", "kerb", "tr-kerb-base.png"};
        case Part::runoff:
          return {"TK{0}S{1}", "grass", "tr-grass-base.png"};
        case Part::barrier:
          return {"B{1}{0}T", "barrier", "tr-barrier-base.png"};
        case Part::terrain:
          return {"TERR{0}{1}", "land", "tr-land-base.png"};
        case Part::trees:
          return {"TREE{1}", "tree", "tr-tree-base.png"};
        case Part::grandstand:
          return {"TRIB{1}", "stand", "tr-stand-base.png"};
        case Part::gantry:
          return {"OBJ-GANTRY{1}", "steel", "tr-steel-base.png"};
        case Part::bridge:
          return {"OBJ-BRIDGE{1}", "concrete", "tr-concrete-base.png"};
      }
      break;
    case NameStyle::ac:
      switch (part) {
        case Part::road:
          return {"1ROAD_{1:02}", "asphalt", "asphalt.dds"};
        case Part::start_strip:
          return {"STARTLINE_{1:02}", "paint", "paint.dds"};
        case Part::kerb:
          return {"2KERB_{0}_{1:02}", "kerb", "kerb.dds"};
        case Part::runoff:
          return {"3GRASS_{0}_{1:02}", "grass", "grass.dds"};
        case Part::barrier:
          return {"4WALL_{0}_{1:02}", "armco", "armco.dds"};
        case Part::terrain:
          return {"TERRAIN_{0}_{1:02}", "land", "land.dds"};
        case Part::trees:
          return {"TREES_{1:02}", "tree", "tree.dds"};
        case Part::grandstand:
          return {"GRANDSTAND_{1:02}", "stand", "stand.dds"};
        case Part::gantry:
          return {"GANTRY_{1:02}", "steel", "steel.dds"};
        case Part::bridge:
          return {"BRIDGE_{1:02}", "concrete", "concrete.dds"};
      }
      break;
    case NameStyle::plain:
      switch (part) {
        case Part::road:
          return {"road_{1:02}", "asphalt", "asphalt.png"};
        case Part::start_strip:
          return {"start_grid_{1:02}", "white paint", "paint.png"};
        case Part::kerb:
          return {"kerb_{0}_{1:02}", "red white", "kerb.png"};
        case Part::runoff:
          return {"grass_{0}_{1:02}", "grass", "grass.png"};
        case Part::barrier:
          return {"guardrail_{0}_{1:02}", "steel", "steel.png"};
        case Part::terrain:
          return {"terrain_{0}_{1:02}", "land", "land.png"};
        case Part::trees:
          return {"trees_{1:02}", "leaves", "tree.png"};
        case Part::grandstand:
          return {"grandstand_{1:02}", "stand", "stand.png"};
        case Part::gantry:
          return {"gantry_{1:02}", "steel", "steel.png"};
        case Part::bridge:
          return {"bridge_{1:02}", "concrete", "concrete.png"};
      }
      break;
    case NameStyle::none:
      break;
  }
  return {"", "", ""};
}

std::string side_word(NameStyle style, Side side) {
  if (style == NameStyle::plain) return side == Side::left ? "left" : "right";
  return side == Side::left ? "L" : "R";
}

double bump_step(const BumpDesign& bump, double extent_m) {
  // Largest second derivative of h (1 + cos(2 pi x / l)) / 2 is h/2 (2 pi / l)^2; the flanks of a
  // plateau are half as long, which makes it four times that. A chord of length d leaves by f'' d^2
  // / 8.
  const double flank = bump.shape == BumpDesign::Shape::plateau ? 0.5 : 1.0;
  const double wave = 2.0 * std::numbers::pi / (flank * extent_m);
  return std::sqrt(8.0 * kBumpErrorM / (0.5 * std::abs(bump.height_m) * wave * wave));
}

/// Signed distance along u, the short way round when closed.
double along(const Circuit& circuit, double from_u_m, double to_u_m) {
  const double distance = to_u_m - from_u_m;
  return circuit.design().closed ? std::remainder(distance, circuit.length_m()) : distance;
}

bool on_bump(const Circuit& circuit, const BumpDesign& bump, double u_m) {
  return std::abs(along(circuit, bump.u_m, u_m)) < 0.5 * bump.length_m + 1e-9;
}

/// Where cross sections lie: at every begin and end of a feature, and between them close enough.
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

struct Columns {
  std::size_t road, left, right;  // number of strips across
};

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
  const double middle = a.u_m + 0.5 * along(circuit, a.u_m, b.u_m);
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

std::uint32_t MeshBuilder::object(Part part, Side side, int number) {
  const auto [entry, added] =
      objects_.try_emplace({part, side, number}, static_cast<std::uint32_t>(mesh_.objects.size()));
  if (added) {
    const Names names = names_of(names_, part);
    mesh_.objects.push_back(
        {fmt::format(fmt::runtime(names.object), side_word(names_, side), number), names.material,
         names.texture});
  }
  return entry->second;
}

std::uint32_t MeshBuilder::vertex(const Eigen::Vector3d& position_m) {
  mesh_.vertices_m.push_back(position_m);
  return static_cast<std::uint32_t>(mesh_.vertices_m.size() - 1);
}

void MeshBuilder::triangle(std::uint32_t object, std::uint32_t a, std::uint32_t b,
                           std::uint32_t c) {
  mesh_.triangles.push_back({a, b, c});
  mesh_.object_of_triangle.push_back(object);
}

void MeshBuilder::quad(std::uint32_t object, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                       std::uint32_t d) {
  triangle(object, a, b, c);
  triangle(object, a, c, d);
}

void MeshBuilder::quad(std::uint32_t object, const std::array<Eigen::Vector3d, 4>& corners) {
  const std::uint32_t a = vertex(corners[0]);
  const std::uint32_t b = vertex(corners[1]);
  const std::uint32_t c = vertex(corners[2]);
  quad(object, a, b, c, vertex(corners[3]));
}

void MeshBuilder::box(std::uint32_t object, const std::array<Eigen::Vector3d, 8>& corners) {
  std::array<std::uint32_t, 8> v{};
  for (std::size_t i = 0; i < 8; ++i) v[i] = vertex(corners[i]);
  quad(object, v[4], v[5], v[6], v[7]);
  quad(object, v[0], v[3], v[2], v[1]);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    quad(object, v[i], v[next], v[next + 4], v[i + 4]);
  }
}

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
