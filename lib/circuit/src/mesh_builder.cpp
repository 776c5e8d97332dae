#include "mesh_builder.h"

#include <fmt/format.h>

#include <string>

namespace road {
namespace {

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

}  // namespace road
