#include "make/preview.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/parallel.h"
#include "make/place.h"
#include "mesh/read_mesh.h"
#include "road/clean.h"

namespace road {
namespace {

constexpr const char* kUnknown = "unknown";

struct Colour {
  const char* surface_class;
  std::array<double, 3> rgb;
};
/// Linear, as glTF has them; told apart also by who sees no red.
constexpr Colour kColours[] = {{"road", {0.10, 0.11, 0.12}},    {"kerb", {0.65, 0.10, 0.06}},
                               {"runoff", {0.13, 0.28, 0.08}},  {"barrier", {0.55, 0.42, 0.05}},
                               {"scenery", {0.30, 0.34, 0.40}}, {kUnknown, {0.40, 0.40, 0.40}}};

/// Vertices of these triangles that lie at the same place become one.
void index(const Mesh& mesh, const std::vector<std::uint32_t>& triangles, PreviewPart& part) {
  std::vector<float> corners;
  corners.reserve(9 * triangles.size());
  for (const std::uint32_t t : triangles)
    for (int k = 0; k < 3; ++k)
      for (const double value : mesh.vertex(t, k)) corners.push_back(static_cast<float>(value));
  const std::size_t count = 3 * triangles.size(), stride = 3 * sizeof(float);
  std::vector<unsigned> remap(count);
  const std::size_t vertices =
      meshopt_generateVertexRemap(remap.data(), nullptr, count, corners.data(), count, stride);
  part.indices.resize(count);
  meshopt_remapIndexBuffer(part.indices.data(), nullptr, count, remap.data());
  part.positions_m.resize(3 * vertices);
  meshopt_remapVertexBuffer(part.positions_m.data(), corners.data(), count, stride, remap.data());
}

/// As the mesh shares its vertices; false where they lie too far from one another in its list.
bool index_as_shared(const Mesh& mesh, const std::vector<std::uint32_t>& triangles,
                     PreviewPart& part) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  constexpr std::size_t kMostPerTriangle = 8;
  std::uint32_t low = kNone, high = 0;
  for (const std::uint32_t t : triangles)
    for (const std::uint32_t corner : mesh.triangles[t])
      low = std::min(low, corner), high = std::max(high, corner);
  const std::size_t span = std::size_t{high} - low + 1;
  if (span > kMostPerTriangle * triangles.size()) return false;
  std::vector<std::uint32_t> place(span, kNone);
  part.indices.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles)
    for (const std::uint32_t corner : mesh.triangles[t]) {
      std::uint32_t& at = place[corner - low];
      if (at == kNone) {
        at = static_cast<std::uint32_t>(part.positions_m.size() / 3);
        for (const double value : mesh.vertices_m[corner])
          part.positions_m.push_back(static_cast<float>(value));
      }
      part.indices.push_back(at);
    }
  return true;
}

constexpr std::size_t kStride = 3 * sizeof(float);
constexpr float kAnyError = std::numeric_limits<float>::max();

/// Leaves at most about `wanted` corners by merging along edges, as far as there are any.
std::vector<std::uint32_t> merged(const PreviewPart& part,
                                  const std::vector<std::uint32_t>& indices, std::size_t wanted) {
  std::vector<std::uint32_t> fewer(indices.size());
  fewer.resize(meshopt_simplify(fewer.data(), indices.data(), indices.size(),
                                part.positions_m.data(), part.positions_m.size() / 3, kStride,
                                wanted, kAnyError, 0, nullptr));
  return fewer;
}

/// Leaves at most `wanted` corners by cells; may leave none.
std::vector<std::uint32_t> merged_by_cells(const PreviewPart& part, std::size_t wanted) {
  std::vector<std::uint32_t> fewer(part.indices.size());
  fewer.resize(meshopt_simplifySloppy(fewer.data(), part.indices.data(), part.indices.size(),
                                      part.positions_m.data(), part.positions_m.size() / 3, kStride,
                                      std::max<std::size_t>(wanted, 3), kAnyError, nullptr));
  return fewer;
}

/// Leaves about this share of the triangles, at least one; vertices that none uses any more go.
/// `quickly`: cells first, a tenth of the time.
void thin(PreviewPart& part, double share, bool quickly) {
  // Of long narrow triangles cells leave some times fewer than asked for.
  constexpr std::size_t kMoreByCells = 4;
  const std::size_t wanted =
      3 * static_cast<std::size_t>(
              std::max(1.0, std::floor(share * static_cast<double>(part.indices.size() / 3))));
  std::vector<std::uint32_t> fewer =
      quickly ? merged_by_cells(part, kMoreByCells * wanted) : merged(part, part.indices, wanted);
  if (quickly && fewer.size() > 2 * wanted) fewer = merged(part, fewer, wanted);
  // Triangles that share no edges cannot be merged along them.
  if (fewer.size() > 2 * wanted) fewer = merged_by_cells(part, wanted);
  if (fewer.empty())  // nothing but slivers: the first ones stand for all
    fewer.assign(part.indices.begin(), part.indices.begin() + static_cast<std::ptrdiff_t>(std::min(
                                                                  wanted, part.indices.size())));
  std::vector<float> kept(part.positions_m.size());
  const std::size_t used =
      meshopt_optimizeVertexFetch(kept.data(), fewer.data(), fewer.size(), part.positions_m.data(),
                                  part.positions_m.size() / 3, kStride);
  kept.resize(3 * used);
  part.indices = std::move(fewer);
  part.positions_m = std::move(kept);
}

double area_m2(const Mesh& mesh, std::uint32_t triangle) {
  const Eigen::Vector3d& a = mesh.vertex(triangle, 0);
  return 0.5 * (mesh.vertex(triangle, 1) - a).cross(mesh.vertex(triangle, 2) - a).norm();
}

/// Triangles of one object and one class; -1: of no class.
struct Group {
  std::uint32_t object = 0;
  int surface_class = -1;
  std::vector<std::uint32_t> triangles;
};

/// By object, then by class. `classes`: of each triangle; null: none are known.
std::vector<Group> groups_of(const Mesh& mesh, const std::vector<SurfaceClass>* classes) {
  std::map<std::pair<std::uint32_t, int>, std::vector<std::uint32_t>> groups;
  auto last = groups.end();
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::pair which{mesh.object_of_triangle[t],
                          classes != nullptr ? static_cast<int>((*classes)[t]) : -1};
    if (last == groups.end() || last->first != which) last = groups.try_emplace(which).first;
    last->second.push_back(t);
  }
  std::vector<Group> out;
  out.reserve(groups.size());
  for (auto& [which, triangles] : groups)
    out.push_back({which.first, which.second, std::move(triangles)});
  return out;
}

PreviewPart part_of(const Mesh& mesh, const Group& group, double share, bool quickly) {
  PreviewPart part;
  part.object = group.object;
  part.surface_class = group.surface_class < 0
                           ? kUnknown
                           : to_string(static_cast<SurfaceClass>(group.surface_class));
  part.triangles = group.triangles.size();
  for (const std::uint32_t t : group.triangles) part.area_m2 += area_m2(mesh, t);
  if (!quickly || !index_as_shared(mesh, group.triangles, part)) index(mesh, group.triangles, part);
  if (share < 1.0) thin(part, share, quickly);
  return part;
}

nlohmann::ordered_json three(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void append(std::string& bytes, std::uint32_t number) {
  for (int k = 0; k < 4; ++k) bytes.push_back(static_cast<char>(number >> (8 * k) & 0xff));
}

void append_chunk(std::string& glb, const char* kind, std::string bytes, char padding) {
  while (bytes.size() % 4 != 0) bytes.push_back(padding);
  append(glb, static_cast<std::uint32_t>(bytes.size()));
  glb.append(kind, 4);
  glb += bytes;
}

/// Of a mesh that is refused: empty, and the reason in `out`.
CleanReport cleaned_by(const Recipe& recipe, const Mesh& mesh, Preview& out) {
  auto report = report_of_cleaning(recipe, mesh);
  if (!report) {
    out.refusal = report.refusal().message;
    return {};
  }
  out.told_by = told_by(*report);
  return *std::move(report);
}

}  // namespace

Preview preview(const Recipe& given, std::size_t most, PreviewClasses classes) {
  Preview out;
  MeshReadReport read;
  const Mesh mesh = read_mesh(
      given.mesh_path,
      classes == PreviewClasses::none ? given.read : read_to_clean(given.read, given.clean), &read);
  CleanReport cleaned;
  if (classes == PreviewClasses::cleaned) cleaned = cleaned_by(given, mesh, out);
  out.origin_m = mesh.origin_m;
  out.objects = mesh.objects;
  out.triangles_in = mesh.triangles.size();
  out.up = read.up;
  out.unit = read.unit;
  out.remarks = read.remarks;
  out.remarks.insert(out.remarks.end(), cleaned.remarks.begin(), cleaned.remarks.end());

  const bool told = cleaned.class_of_triangle.size() == mesh.triangles.size();
  const std::vector<Group> groups = groups_of(mesh, told ? &cleaned.class_of_triangle : nullptr);
  const double share = static_cast<double>(most) / static_cast<double>(mesh.triangles.size());
  const bool quickly = classes == PreviewClasses::none;
  out.parts.resize(groups.size());
  base::parallel_for(groups.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      out.parts[k] = part_of(mesh, groups[k], share, quickly);
  });
  for (const PreviewPart& part : out.parts) out.triangles_shown += part.indices.size() / 3;
  return out;
}

namespace {

using nlohmann::ordered_json;

/// The lists of a glTF file while it is made, and its binary part.
struct Glb {
  ordered_json nodes = ordered_json::array(), meshes = nodes, accessors = nodes, views = nodes,
               children = nodes;
  std::string buffer;
};

ordered_json materials_of_classes() {
  ordered_json materials = ordered_json::array();
  for (const Colour& colour : kColours)
    materials.push_back({{"name", colour.surface_class},
                         {"doubleSided", true},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {colour.rgb[0], colour.rgb[1], colour.rgb[2], 1.0}},
                           {"metallicFactor", 0.0},
                           {"roughnessFactor", 0.9}}}});
  return materials;
}

std::size_t add_view(const void* data, std::size_t bytes, int target, Glb& glb) {
  glb.views.push_back({{"buffer", 0},
                       {"byteOffset", glb.buffer.size()},
                       {"byteLength", bytes},
                       {"target", target}});
  glb.buffer.append(static_cast<const char*>(data), bytes);
  return glb.views.size() - 1;
}

/// The positions and the indices of a part, in this order.
void add_accessors(const PreviewPart& part, Glb& glb) {
  constexpr int kFloat = 5126, kUint32 = 5125, kVertices = 34962, kIndices = 34963;
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (std::size_t k = 0; k < part.positions_m.size(); ++k) {
    low[k % 3] = std::min(low[k % 3], part.positions_m[k]);
    high[k % 3] = std::max(high[k % 3], part.positions_m[k]);
  }
  glb.accessors.push_back(
      {{"bufferView",
        add_view(part.positions_m.data(), part.positions_m.size() * sizeof(float), kVertices, glb)},
       {"componentType", kFloat},
       {"count", part.positions_m.size() / 3},
       {"type", "VEC3"},
       {"min", low},
       {"max", high}});
  glb.accessors.push_back(
      {{"bufferView",
        add_view(part.indices.data(), part.indices.size() * sizeof(std::uint32_t), kIndices, glb)},
       {"componentType", kUint32},
       {"count", part.indices.size()},
       {"type", "SCALAR"}});
}

void add_part(const PreviewPart& part, const Preview& preview, Glb& glb) {
  add_accessors(part, glb);
  const MeshObject& object = preview.objects[part.object];
  const auto* const colour =
      std::find_if(std::begin(kColours), std::end(kColours),
                   [&](const Colour& c) { return part.surface_class == c.surface_class; });
  const ordered_json primitive = {
      {"attributes", ordered_json::object({{"POSITION", glb.accessors.size() - 2}})},
      {"indices", glb.accessors.size() - 1},
      {"material", colour - std::begin(kColours)}};
  glb.meshes.push_back(ordered_json::object({{"primitives", ordered_json::array({primitive})}}));
  glb.nodes.push_back({{"name", part.surface_class + ":" + object.name},
                       {"mesh", glb.meshes.size() - 1},
                       {"extras",
                        {{"object", part.object},
                         {"class", part.surface_class},
                         {"triangles", part.triangles},
                         {"area_m2", part.area_m2}}}});
  glb.children.push_back(glb.nodes.size() - 1);
}

ordered_json facts_of(const Preview& preview) {
  ordered_json objects = ordered_json::array();
  for (const MeshObject& object : preview.objects)
    objects.push_back(
        {{"name", object.name}, {"material", object.material}, {"texture", object.texture}});
  return {{"origin_m", three(preview.origin_m)},
          {"objects", objects},
          {"triangles_in", preview.triangles_in},
          {"triangles_shown", preview.triangles_shown},
          {"up", preview.up},
          {"unit", preview.unit},
          {"told_by", preview.told_by},
          {"refusal", preview.refusal},
          {"remarks", preview.remarks}};
}

}  // namespace

std::string glb_of(const Preview& preview) {
  Glb glb;
  for (const PreviewPart& part : preview.parts) add_part(part, preview, glb);
  const double half = std::sqrt(0.5);
  glb.nodes.push_back(
      {{"name", "z up"}, {"rotation", {-half, 0.0, 0.0, half}}, {"children", glb.children}});
  const ordered_json scene = {{"nodes", ordered_json::array({glb.nodes.size() - 1})},
                              {"extras", facts_of(preview)}};
  const ordered_json root = {
      {"asset", {{"version", "2.0"}, {"generator", "Kerbstone"}}},
      {"scene", 0},
      {"scenes", ordered_json::array({scene})},
      {"nodes", glb.nodes},
      {"meshes", glb.meshes},
      {"materials", materials_of_classes()},
      {"accessors", glb.accessors},
      {"bufferViews", glb.views},
      {"buffers",
       ordered_json::array({ordered_json::object({{"byteLength", glb.buffer.size()}})})}};
  std::string chunks;
  append_chunk(chunks, "JSON", base::dump_json(root), ' ');
  append_chunk(chunks, std::string("BIN\0", 4).data(), std::move(glb.buffer), '\0');
  std::string file = "glTF";
  append(file, 2);
  append(file, static_cast<std::uint32_t>(12 + chunks.size()));
  return file + chunks;
}

}  // namespace road
