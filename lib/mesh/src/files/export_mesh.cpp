#include "mesh/export_mesh.h"

#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Exporter.hpp>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/ending.h"
#include "base/write_file.h"
#include "mesh/error.h"

namespace road {
namespace {

constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();

/// In file axes and units, origin added; objects with empty names merged into one.
Mesh in_file_frame(const Mesh& mesh, const MeshExportOptions& options) {
  Mesh result = mesh;
  result.origin_m.setZero();
  const double scale = 1.0 / metres_per(options.unit);
  for (Eigen::Vector3d& vertex : result.vertices_m) {
    vertex = turned_from_z(scale * (mesh.origin_m + vertex), options.up);
  }
  if (result.objects.empty()) result.objects.emplace_back();
  if (result.object_of_triangle.empty()) result.object_of_triangle.assign(mesh.triangles.size(), 0);
  const bool nameless = std::all_of(result.objects.begin(), result.objects.end(),
                                    [](const MeshObject& o) { return o.name.empty(); });
  if (nameless) {
    result.objects.resize(1);
    std::fill(result.object_of_triangle.begin(), result.object_of_triangle.end(), 0U);
  }
  return result;
}

std::vector<std::vector<std::uint32_t>> triangles_by_object(const Mesh& mesh) {
  std::vector<std::vector<std::uint32_t>> result(mesh.objects.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    result[mesh.object_of_triangle[t]].push_back(static_cast<std::uint32_t>(t));
  }
  return result;
}

/// Calls add(vertex) for each vertex of the object when first met and returns its triangles over
/// the numbers so given. `number` is scratch, all kUnseen before and after.
template <class Add>
std::vector<std::array<std::uint32_t, 3>> renumber(const Mesh& mesh,
                                                   const std::vector<std::uint32_t>& triangles,
                                                   std::vector<std::uint32_t>& number, Add add) {
  std::vector<std::array<std::uint32_t, 3>> result;
  result.reserve(triangles.size());
  std::uint32_t next = 0;
  for (const std::uint32_t t : triangles) {
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[t][k];
      if (number[vertex] == kUnseen) {
        number[vertex] = next++;
        add(vertex);
      }
      corners[k] = number[vertex];
    }
    result.push_back(corners);
  }
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t vertex : mesh.triangles[t]) number[vertex] = kUnseen;
  }
  return result;
}

std::string one_word(std::string name) {
  for (char& c : name) {
    if (std::isspace(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
}

void export_obj(const Mesh& mesh, const std::filesystem::path& path, Unit unit) {
  const int decimals = unit == Unit::mm ? 2 : unit == Unit::cm ? 3 : 5;
  std::string materials = "# materials\n";
  // One material of the file for each pair of material and texture; a second texture gets a number.
  std::map<std::pair<std::string, std::string>, std::string> known;
  std::set<std::string> names;
  for (const MeshObject& object : mesh.objects) {
    if (object.material.empty() || known.contains({object.material, object.texture})) continue;
    std::string name = one_word(object.material);
    for (std::size_t n = 2; !names.insert(name).second; ++n)
      name = fmt::format("{}.{}", one_word(object.material), n);
    materials += fmt::format("newmtl {}\nKd 0.8 0.8 0.8\n", name);
    if (!object.texture.empty()) materials += fmt::format("map_Kd {}\n", object.texture);
    known[{object.material, object.texture}] = std::move(name);
  }
  std::filesystem::path material_path = path;
  material_path.replace_extension(".mtl");
  std::string text;
  if (!known.empty()) {
    text += fmt::format("mtllib {}\n", one_word(material_path.filename().string()));
  }
  const auto groups = triangles_by_object(mesh);
  std::vector<std::uint32_t> number(mesh.vertices_m.size(), kUnseen);
  std::uint32_t written = 0;
  for (std::size_t o = 0; o < mesh.objects.size(); ++o) {
    if (groups[o].empty()) continue;
    if (!mesh.objects[o].name.empty())
      text += fmt::format("o {}\n", one_word(mesh.objects[o].name));
    std::uint32_t count = 0;
    const auto triangles = renumber(mesh, groups[o], number, [&](std::uint32_t vertex) {
      const Eigen::Vector3d& p = mesh.vertices_m[vertex];
      fmt::format_to(std::back_inserter(text), "v {:.{}f} {:.{}f} {:.{}f}\n", p.x(), decimals,
                     p.y(), decimals, p.z(), decimals);
      ++count;
    });
    if (!mesh.objects[o].material.empty()) {
      text +=
          fmt::format("usemtl {}\n", known.at({mesh.objects[o].material, mesh.objects[o].texture}));
    }
    for (const auto& t : triangles) {
      fmt::format_to(std::back_inserter(text), "f {} {} {}\n", written + t[0] + 1,
                     written + t[1] + 1, written + t[2] + 1);
    }
    written += count;
  }
  // The mesh last: whoever sees it finds its materials.
  if (!known.empty()) base::write_file(material_path.string(), materials);
  base::write_file(path.string(), text);
}

/// Of each vertex, the mean of the faces around it by their area: smooth across objects, too.
std::vector<Eigen::Vector3d> vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices_m.size(), Eigen::Vector3d::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d& a = mesh.vertex(t, 0);
    const Eigen::Vector3d area = (mesh.vertex(t, 1) - a).cross(mesh.vertex(t, 2) - a);
    for (const std::uint32_t vertex : mesh.triangles[t]) normals[vertex] += area;
  }
  for (Eigen::Vector3d& normal : normals) {
    const double length = normal.norm();
    normal = length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::UnitY();
  }
  return normals;
}

aiVector3D to_assimp(const Eigen::Vector3d& v) {
  return {static_cast<ai_real>(v.x()), static_cast<ai_real>(v.y()), static_cast<ai_real>(v.z())};
}

std::unique_ptr<aiMesh> to_assimp(const Mesh& mesh, const std::vector<Eigen::Vector3d>& normals,
                                  const std::vector<std::uint32_t>& triangles,
                                  std::vector<std::uint32_t>& number) {
  std::vector<aiVector3D> vertices, facing;
  const auto faces = renumber(mesh, triangles, number, [&](std::uint32_t vertex) {
    vertices.push_back(to_assimp(mesh.vertices_m[vertex]));
    facing.push_back(to_assimp(normals[vertex]));
  });
  auto result = std::make_unique<aiMesh>();
  result->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  result->mNumVertices = static_cast<unsigned>(vertices.size());
  result->mVertices = new aiVector3D[vertices.size()];
  std::copy(vertices.begin(), vertices.end(), result->mVertices);
  result->mNormals = new aiVector3D[facing.size()];
  std::copy(facing.begin(), facing.end(), result->mNormals);
  result->mNumFaces = static_cast<unsigned>(faces.size());
  result->mFaces = new aiFace[faces.size()];
  for (std::size_t i = 0; i < faces.size(); ++i) {
    result->mFaces[i].mNumIndices = 3;
    result->mFaces[i].mIndices = new unsigned[3]{faces[i][0], faces[i][1], faces[i][2]};
  }
  return result;
}

// The exporter wants one node per object and owns everything it is given.
void export_glb(const Mesh& mesh, const std::string& path) {
  const auto groups = triangles_by_object(mesh);
  aiScene scene;
  scene.mRootNode = new aiNode("scene");
  const std::vector<Eigen::Vector3d> normals = vertex_normals(mesh);
  std::vector<std::string> materials;
  std::vector<std::optional<LinearColour>> colours;
  std::vector<std::unique_ptr<aiMesh>> meshes;
  std::vector<aiNode*> nodes;
  std::vector<std::uint32_t> number(mesh.vertices_m.size(), kUnseen);
  for (std::size_t o = 0; o < mesh.objects.size(); ++o) {
    if (groups[o].empty()) continue;
    auto item = to_assimp(mesh, normals, groups[o], number);
    const std::string& material = mesh.objects[o].material;
    const auto known = std::find(materials.begin(), materials.end(), material);
    item->mMaterialIndex = static_cast<unsigned>(known - materials.begin());
    if (known == materials.end()) {
      materials.push_back(material);
      colours.push_back(mesh.objects[o].colour);
    }
    item->mName = mesh.objects[o].name;
    auto* node = new aiNode(mesh.objects[o].name);
    node->mNumMeshes = 1;
    node->mMeshes = new unsigned[1]{static_cast<unsigned>(meshes.size())};
    nodes.push_back(node);
    meshes.push_back(std::move(item));
  }
  scene.mNumMaterials = static_cast<unsigned>(materials.size());
  scene.mMaterials = new aiMaterial*[materials.size()];
  for (std::size_t i = 0; i < materials.size(); ++i) {
    scene.mMaterials[i] = new aiMaterial;
    const aiString name(materials[i]);
    scene.mMaterials[i]->AddProperty(&name, AI_MATKEY_NAME);
    if (!colours[i]) continue;
    const auto& [r, g, b] = *colours[i];
    const aiColor4D base(r, g, b, 1.0F);
    scene.mMaterials[i]->AddProperty(&base, 1, AI_MATKEY_BASE_COLOR);
  }
  scene.mNumMeshes = static_cast<unsigned>(meshes.size());
  scene.mMeshes = new aiMesh*[meshes.size()];
  for (std::size_t i = 0; i < meshes.size(); ++i) scene.mMeshes[i] = meshes[i].release();
  scene.mRootNode->addChildren(static_cast<unsigned>(nodes.size()), nodes.data());

  Assimp::Exporter exporter;
  const aiExportDataBlob* blob = exporter.ExportToBlob(&scene, "glb2");
  if (!blob) {
    throw Error(
        fmt::format("{}: the mesh cannot be written as glb: {}", path, exporter.GetErrorString()));
  }
  base::write_file(path, {static_cast<const char*>(blob->data), blob->size});
}

}  // namespace

void export_mesh(const Mesh& mesh, const std::string& path, const MeshExportOptions& options) {
  if (mesh.triangles.empty()) throw Error(path + ": there are no triangles to write");
  const Mesh framed = in_file_frame(mesh, options);
  const std::string extension = base::ending_of(path);
  if (extension == ".obj") {
    export_obj(framed, path, options.unit);
  } else if (extension == ".glb") {
    export_glb(framed, path);
  } else {
    write_mesh(framed, path);  // refuses what it does not know
  }
}

}  // namespace road
