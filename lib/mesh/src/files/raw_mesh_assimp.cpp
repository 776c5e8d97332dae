// Reads by assimp what no reader of our own reads.
#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <filesystem>
#include <new>

#include "base/ending.h"
#include "mesh/error.h"
#include "raw_mesh.h"
#include "raw_mesh_companions.h"

namespace road {
namespace {

namespace fs = std::filesystem;

// Vertices and faces of what is shown again and again: a forest along a track.
constexpr std::uint64_t kMostCopied = 40'000'000;
constexpr double kNotableStep_m = 1e-3;

/// Bytes that live as long as the stream that assimp reads them from.
struct OwnedBytes {
  std::string bytes;
};
class CompanionStream : private OwnedBytes, public Assimp::MemoryIOStream {
 public:
  explicit CompanionStream(std::string content)
      : OwnedBytes{std::move(content)},
        MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()) {}
};

/// Hands assimp the main file from memory and its companions (.bin) from disk: the only way
/// by which it comes to a file.
class MemoryFirst : public Assimp::DefaultIOSystem {
 public:
  MemoryFirst(std::string path, std::string_view bytes, Companions& companions)
      : path_(std::move(path)), bytes_(bytes), companions_(companions) {}
  bool Exists(const char* file) const override { return path_ == file || companions_.exists(file); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (mode == nullptr || *mode != 'r') return nullptr;
    if (path_ == file) {
      return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                        bytes_.size());
    }
    auto content = companions_.read(file);
    return content ? new CompanionStream(std::move(*content)) : nullptr;
  }

 private:
  std::string path_;
  std::string_view bytes_;
  Companions& companions_;
};

std::string material_name(const aiMaterial& material) {
  aiString name;
  if (material.Get(AI_MATKEY_NAME, name) != aiReturn_SUCCESS) return {};
  const std::string text = name.C_Str();
  return text == AI_DEFAULT_MATERIAL_NAME ? std::string() : text;
}

BaseLook look_of(const aiMaterial& material) {
  BaseLook look;
  aiString file;
  for (const aiTextureType type : {aiTextureType_DIFFUSE, aiTextureType_BASE_COLOR}) {
    if (material.GetTexture(type, 0, &file) == aiReturn_SUCCESS) {
      look.picture = file.C_Str();
      break;
    }
  }
  aiColor4D stated;
  const bool is_linear = material.Get(AI_MATKEY_BASE_COLOR, stated) == aiReturn_SUCCESS;  // glTF
  if (is_linear || material.Get(AI_MATKEY_COLOR_DIFFUSE, stated) == aiReturn_SUCCESS)
    look.colour = base_colour({static_cast<double>(stated.r), static_cast<double>(stated.g),
                               static_cast<double>(stated.b)},
                              is_linear);
  return look;
}

Eigen::Matrix4d to_eigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d out;
  for (unsigned int row = 0; row < 4; ++row) {
    for (unsigned int column = 0; column < 4; ++column)
      out(row, column) = static_cast<double>(m[row][column]);
  }
  return out;
}

std::string object_name(const aiNode& node) {
  std::string name = node.mName.C_Str();
  // assimp numbers nameless AC3D objects; a made-up name must not look like the author's.
  for (const char* made_up : {"ACPoly_", "ACLight_", "ACGroup_", "ACWorld_"}) {
    if (name.starts_with(made_up)) return {};
  }
  return name;
}

/// Of the vertices, without the places of their objects.
struct Reach {
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = -lowest;
};

/// Adds a part of the last object of the mesh.
void add_part(const aiMesh& part, const Eigen::Matrix4d& T_world_node,
              const Eigen::Vector3d& origin, const std::string& name, const std::string& path,
              RawMesh& mesh, Reach& bounds) {
  const std::size_t base = mesh.vertices.size();
  if (base + part.mNumVertices > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(fmt::format("{}: more than 4,294,967,295 vertices; reduce the mesh", path));
  }
  const Eigen::Matrix3d rotation = T_world_node.topLeftCorner<3, 3>();
  const Eigen::Vector3d translation = T_world_node.topRightCorner<3, 1>();
  const bool mirrors = rotation.determinant() < 0.0;
  for (unsigned int i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D& v = part.mVertices[i];
    const Eigen::Vector3d local(static_cast<double>(v.x), static_cast<double>(v.y),
                                static_cast<double>(v.z));
    bounds.lowest = bounds.lowest.cwiseMin(rotation * local);
    bounds.highest = bounds.highest.cwiseMax(rotation * local);
    mesh.vertices.emplace_back(rotation * local + translation + origin);
  }
  std::vector<std::uint32_t> polygon;
  for (unsigned int i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    polygon.clear();
    for (unsigned int c = 0; c < face.mNumIndices; ++c) {
      if (face.mIndices[c] >= part.mNumVertices) {
        throw Error(fmt::format(
            "{}: object '{}': face {} refers to vertex {}, but there are {}; export the mesh "
            "again",
            path, name, i, face.mIndices[c], part.mNumVertices));
      }
      polygon.push_back(static_cast<std::uint32_t>(base) + face.mIndices[c]);
    }
    const std::size_t first = mesh.triangles.size();
    triangulate(mesh.vertices, polygon, mesh.triangles);
    // A mirrored object turns its faces over; formats with such objects mean the other side.
    if (mirrors)
      for (std::size_t t = first; t < mesh.triangles.size(); ++t)
        std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    mesh.object_of_triangle.resize(mesh.triangles.size(),
                                   static_cast<std::uint32_t>(mesh.objects.size() - 1));
  }
}

/// Counts the copies of a part that a few bytes can ask for, before memory is taken for them.
void check_copies(const aiMesh& part, std::size_t copies, const std::string& name,
                  const std::string& path, std::uint64_t& placed) {
  placed += copies * (std::uint64_t{part.mNumVertices} + part.mNumFaces);
  if (placed > kMostCopied)
    throw Error(fmt::format(
        "{}: object '{}' is shown {} times; all copies together have more than {} vertices and "
        "faces; leave out what is no road",
        path, name, copies, kMostCopied));
}

/// Coordinates that are farther apart than anybody expects of float32.
struct CoarseSteps {
  double largest = 0.0;
  std::string object;

  void add(double step, const Eigen::Matrix4d& T_world_mesh, const std::string& name) {
    step *= T_world_mesh.topLeftCorner<3, 3>().colwise().norm().maxCoeff();
    if (step > largest) largest = step, object = name;
  }
  void remark(double metres_per_unit, std::vector<std::string>& remarks) const {
    if (metres_per_unit * largest > kNotableStep_m)
      remarks.push_back(fmt::format(
          "coordinates were stored as integers and snap to {:.1f} mm at most (object '{}'); export "
          "without quantization (gltfpack: -noq) where heights look like stairs",
          1000.0 * metres_per_unit * largest, object));
  }
};

/// Along x, y or z (0, 1, 2) with its sign; nothing where it is not stated.
std::optional<Eigen::Vector3d> stated_axis(const aiMetadata& meta, const std::string& name) {
  std::int32_t line = -1, sign = 1;
  if (!meta.Get(name, line) || line < 0 || line > 2) return std::nullopt;
  meta.Get(name + "Sign", sign);
  return Eigen::Vector3d((sign < 0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(line));
}

/// FBX states its axes: up, to the front and to the right. assimp turns nothing.
void put_stated_axes(const aiMetadata& meta, RawMesh& mesh) {
  const auto up = stated_axis(meta, "UpAxis"), front = stated_axis(meta, "FrontAxis"),
             right = stated_axis(meta, "CoordAxis");
  if (!up) return;
  int line = 0;
  up->cwiseAbs().maxCoeff(&line);
  mesh.up = up_along(line, (*up)[line] < 0.0);
  if (!front || !right || right->cross(*up).dot(*front) > -0.5) return;
  mesh.left_handed = true;
  mesh.remarks.emplace_back(
      "the file states axes of the left hand: its plan was mirrored; if that is wrong, give "
      "--mirror");
}

/// FBX states centimetres per unit; assimp does not apply them.
void put_stated_unit(const aiMetadata& meta, RawMesh& mesh) {
  float scale = 0.0f;
  double scale_double = 0.0;
  if (meta.Get("UnitScaleFactor", scale) && scale > 0.0f) {
    mesh.metres_per_unit = 0.01 * static_cast<double>(scale);
  } else if (meta.Get("UnitScaleFactor", scale_double) && scale_double > 0.0) {
    mesh.metres_per_unit = 0.01 * scale_double;
  }
}

/// `placements` as plain_gltf() gave them.
RawMesh flatten(const aiScene& scene, const Eigen::Vector3d& origin, const std::string& path,
                const std::vector<NodePlacement>& placements, CoarseSteps& steps,
                const std::function<void(std::size_t)>& opened) {
  RawMesh mesh;
  mesh.stored_as_float32 = true;
  Reach bounds;
  std::vector<std::string> materials, textures;
  mesh.looks.emplace_back();  // of parts without material
  for (unsigned int i = 0; i < scene.mNumMaterials; ++i) {
    materials.push_back(material_name(*scene.mMaterials[i]));
    mesh.looks.push_back(look_of(*scene.mMaterials[i]));
    const std::string& picture = mesh.looks.back().picture;
    textures.push_back(picture.substr(picture.find_last_of("/\\") + 1));
  }
  struct Visit {
    const aiNode* node;
    Eigen::Matrix4d T_world_node;
  };
  std::uint64_t copied = 0;
  std::vector<Visit> open{{scene.mRootNode, to_eigen(scene.mRootNode->mTransformation)}};
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    for (unsigned int k = visit.node->mNumChildren; k-- > 0;) {
      const aiNode* child = visit.node->mChildren[k];
      open.push_back({child, visit.T_world_node * to_eigen(child->mTransformation)});
    }
    std::string node_name = object_name(*visit.node);
    static const NodePlacement kAsItLies;
    const NodePlacement* known = take_placement(placements, node_name);
    const NodePlacement& placement = known != nullptr ? *known : kAsItLies;
    for (unsigned int k = 0; k < visit.node->mNumMeshes; ++k) {
      if (visit.node->mMeshes[k] >= scene.mNumMeshes ||
          scene.mMeshes[visit.node->mMeshes[k]] == nullptr)
        throw Error(fmt::format(
            "{}: object '{}' refers to a part that the file does not hold; export the mesh again",
            path, node_name));
      const aiMesh& part = *scene.mMeshes[visit.node->mMeshes[k]];
      std::string name = node_name;
      if (name.empty() || visit.node == scene.mRootNode)
        name = part.mName.length > 0 ? part.mName.C_Str() : name;
      const bool has_material = part.mMaterialIndex < scene.mNumMaterials;
      mesh.objects.push_back({name, has_material ? materials[part.mMaterialIndex] : "",
                              has_material ? textures[part.mMaterialIndex] : ""});
      mesh.look_of_object.push_back(has_material ? part.mMaterialIndex + 1 : 0);
      if (placement.instances.size() > 1) {
        check_copies(part, placement.instances.size(), name, path, copied);
        if (opened) opened(placement.instances.size() * part.mNumVertices);
      }
      for (const Eigen::Matrix4d& T_node_mesh : placement.instances) {
        const Eigen::Matrix4d T_world_mesh = visit.T_world_node * T_node_mesh;
        add_part(part, T_world_mesh, origin, name, path, mesh, bounds);
        steps.add(placement.step, T_world_mesh, name);
      }
    }
  }
  if (!mesh.vertices.empty())
    mesh.local_magnitude = ((bounds.lowest + bounds.highest) / 2).cwiseAbs().maxCoeff();
  if (scene.mMetaData) {
    put_stated_unit(*scene.mMetaData, mesh);
    put_stated_axes(*scene.mMetaData, mesh);
  }
  return mesh;
}

/// One remark for all companions that are not there. assimp looks for each in several places, which
/// it joins with two strokes.
void remark_missing(const std::string& path, const std::vector<MeshFile>& files,
                    std::vector<std::string>& remarks) {
  const std::size_t folder_length = fs::path(path).parent_path().string().size();
  std::string names;
  for (const MeshFile& file : files) {
    const auto has_its_name = [&](const MeshFile& other) {
      return !other.sha256.empty() &&
             fs::path(other.path).filename() == fs::path(file.path).filename();
    };
    if (!file.sha256.empty() || std::any_of(files.begin(), files.end(), has_its_name)) continue;
    if (file.path.find("//", folder_length) != std::string::npos) continue;
    const std::string plain = fs::path(file.path).lexically_normal().string();
    if (plain != file.path && !names.empty()) continue;  // "./road.bin" after "road.bin"
    names += (names.empty() ? "" : ", ") + file.path;
  }
  if (!names.empty()) remarks.push_back(remark_on_missing(names));
}

}  // namespace

RawMesh read_with_assimp(std::string_view bytes, const std::string& path,
                         const Eigen::Vector3d& origin, const MeshReadOptions& options,
                         const std::function<void(std::size_t)>& opened) {
  Companions companions(path, options.allow_outside, opened);
  // Where the path goes up, assimp looks for what belongs to the mesh in places that nobody named.
  const bool goes_up = path.find("..") != std::string::npos;
  const std::string own =
      goes_up ? (companions.folder() / fs::path(path).filename()).string() : path;
  const std::string extension = base::ending_of(path);
  std::optional<PlainGltf> plain;
  if (extension == ".glb" || extension == ".gltf") {
    plain = plain_gltf(bytes, path, [&](const std::string& uri) {
      auto content = companions.read((fs::path(own).parent_path() / uri).string());
      companions.remarks_on_outside();  // throws: a buffer is geometry
      if (!content && !companions.problems().empty())
        throw Error(fmt::format("{}: refers to a file that cannot be read: {}", path,
                                companions.problems().front()));
      return content;
    });
  }
  if (plain) {
    bytes = plain->bytes;
    if (opened) opened(bytes.size());
  }
  Assimp::Importer importer;
  importer.SetIOHandler(new MemoryFirst(own, bytes, companions));  // owned by the importer
  importer.SetPropertyBool(AI_CONFIG_IMPORT_AC_EVAL_SUBDIVISION, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, false);
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(own, 0);
  } catch (const std::bad_alloc&) {
    throw;  // said by who set the limit
  } catch (const std::exception& error) {
    throw Error(fmt::format("{}: no mesh can be read from it: {}; copy or export it again", path,
                            error.what()));
  }
  std::vector<std::string> remarks = companions.remarks_on_outside();
  const std::vector<std::string>& problems = companions.problems();
  if (scene == nullptr || scene->mRootNode == nullptr) {
    if (!problems.empty())
      throw Error(
          fmt::format("{}: refers to a file that cannot be read: {}", path, problems.front()));
    std::string reason = importer.GetErrorString();
    if (reason == std::bad_alloc().what()) throw std::bad_alloc();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw Error(fmt::format(
        "{}: no mesh can be read from it: {}; give a complete mesh file (.obj .glb .ply .stl .fbx "
        ".dae .3ds .ac .acc)",
        path, reason));
  }
  CoarseSteps steps;
  RawMesh mesh = flatten(*scene, origin, path,
                         plain ? plain->placements : std::vector<NodePlacement>(), steps, opened);
  mesh.remarks.insert(mesh.remarks.begin(), remarks.begin(), remarks.end());
  steps.remark(metres_per(options.unit) * options.scale, mesh.remarks);
  if (!problems.empty()) {
    mesh.remarks.push_back("refers to a file that cannot be read: " + problems.front());
  } else if (companions.outside().empty()) {
    remark_missing(own, companions.files(), mesh.remarks);
  }
  mesh.files = companions.files();
  if (options.want_colours && options.want_colours(mesh.objects)) {
    const auto embedded = [&](const std::string& name) -> std::optional<std::string_view> {
      const aiTexture* texture = scene->GetEmbeddedTexture(name.c_str());
      if (texture == nullptr || texture->mHeight != 0) return std::nullopt;  // none, or no file
      return std::string_view(reinterpret_cast<const char*>(texture->pcData), texture->mWidth);
    };
    put_colours(path, options.allow_outside, opened, embedded, mesh);
  }
  return mesh;
}

}  // namespace road
