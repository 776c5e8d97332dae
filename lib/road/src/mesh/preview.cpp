#include "road/preview.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "road/clean.h"
#include "road/error.h"
#include "road/place.h"
#include "road/read_mesh.h"

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

/// Leaves about this share of the triangles, at least one; vertices that none uses any more go.
void thin(PreviewPart& part, double share) {
  const std::size_t triangles = part.indices.size() / 3;
  const std::size_t wanted = 3 * static_cast<std::size_t>(std::max(
                                     1.0, std::floor(share * static_cast<double>(triangles))));
  const std::size_t vertices = part.positions_m.size() / 3, stride = 3 * sizeof(float);
  const float any_error = std::numeric_limits<float>::max();
  std::vector<std::uint32_t> fewer(part.indices.size());
  std::size_t left =
      meshopt_simplify(fewer.data(), part.indices.data(), part.indices.size(),
                       part.positions_m.data(), vertices, stride, wanted, any_error, 0, nullptr);
  if (left > 2 * wanted) {  // triangles that share no edges cannot be merged along them
    const std::size_t rough = meshopt_simplifySloppy(
        fewer.data(), part.indices.data(), part.indices.size(), part.positions_m.data(), vertices,
        stride, std::max<std::size_t>(wanted, 3), any_error, nullptr);
    if (rough > 0)
      left = rough;
    else  // nothing but slivers: the first ones stand for all
      std::copy_n(part.indices.begin(), left = std::min(wanted, part.indices.size()),
                  fewer.begin());
  }
  if (left == 0) std::copy_n(part.indices.begin(), left = 3, fewer.begin());
  fewer.resize(left);
  std::vector<float> kept(part.positions_m.size());
  const std::size_t used = meshopt_optimizeVertexFetch(kept.data(), fewer.data(), fewer.size(),
                                                       part.positions_m.data(), vertices, stride);
  kept.resize(3 * used);
  part.indices = std::move(fewer);
  part.positions_m = std::move(kept);
}

double area_m2(const Mesh& mesh, std::uint32_t triangle) {
  const Eigen::Vector3d& a = mesh.vertex(triangle, 0);
  return 0.5 * (mesh.vertex(triangle, 1) - a).cross(mesh.vertex(triangle, 2) - a).norm();
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
CleanReport cleaned_by(Recipe recipe, const Mesh& mesh, Preview& out) {
  CleanReport report;
  try {
    set_guide(recipe, place_mesh(recipe));
    clean(mesh, recipe.clean, &report);
    out.told_by = told_by(report);
    return report;
  } catch (const Error& refused) {
    out.refusal = refused.what();
    return {};
  }
}

}  // namespace

Preview preview(const Recipe& given, std::size_t most, PreviewClasses classes) {
  Preview out;
  MeshReadReport read;
  const Mesh mesh = read_mesh(given.mesh_path, read_to_clean(given.read, given.clean), &read);
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
  std::map<std::pair<std::uint32_t, int>, std::vector<std::uint32_t>> groups;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    groups[{mesh.object_of_triangle[t], told ? static_cast<int>(cleaned.class_of_triangle[t]) : -1}]
        .push_back(t);
  const double share = static_cast<double>(most) / static_cast<double>(mesh.triangles.size());
  for (const auto& [which, triangles] : groups) {
    PreviewPart part;
    part.object = which.first;
    part.surface_class =
        which.second < 0 ? kUnknown : to_string(static_cast<SurfaceClass>(which.second));
    part.triangles = triangles.size();
    for (const std::uint32_t t : triangles) part.area_m2 += area_m2(mesh, t);
    index(mesh, triangles, part);
    if (share < 1.0) thin(part, share);
    out.triangles_shown += part.indices.size() / 3;
    out.parts.push_back(std::move(part));
  }
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
  append_chunk(chunks, "JSON", root.dump(-1, ' ', false, ordered_json::error_handler_t::replace),
               ' ');
  append_chunk(chunks, std::string("BIN\0", 4).data(), std::move(glb.buffer), '\0');
  std::string file = "glTF";
  append(file, 2);
  append(file, static_cast<std::uint32_t>(12 + chunks.size()));
  return file + chunks;
}

}  // namespace road
