#include "road/read_mesh.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "files/read_file.h"
#include "files/sha256.h"
#include "raw_mesh.h"
#include "road/error.h"

namespace road {
namespace {

// A race track is between a kart track and the Nordschleife with the hills around it.
constexpr double kSmallestMesh_m = 10.0;
constexpr double kLargestMesh_m = 40e3;
constexpr double kLargestCoordinate_m = 1e7;
// Coordinates that snap to more than this ruin a 10 cm grid; below 1 mm nobody needs to know.
constexpr double kWorstResolution_m = 0.1;
constexpr double kNotableResolution_m = 1e-3;
// The flat faces of a track (road, terrain) outweigh its walls and trees; a clear verdict is 2 : 1.
constexpr double kClearVerdict = 2.0;
// A mesh of 100 million triangles, or the buffer of one, in the most wasteful format.
constexpr std::size_t kLargestFile = 16'000'000'000;

std::string load(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw Error(
        fmt::format("{}: is a folder; give a mesh file (.obj .glb .ply .stl .acc ...)", path));
  }
  std::string bytes = files::read_file(path, kLargestFile);
  if (bytes.empty())
    throw Error(fmt::format("{}: the file is empty; copy or export the mesh again", path));
  return bytes;
}

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// What assimp wants beside the mesh: seen while it reads.
struct Companions {
  std::vector<MeshFile> files;
  std::vector<std::string> problems;  ///< one sentence for each that is there and could not be read

  void add(const std::string& path, const std::string& sha256) {
    const auto known = std::find_if(files.begin(), files.end(),
                                    [&](const MeshFile& file) { return file.path == path; });
    if (known == files.end()) files.push_back({path, sha256});
  }
};

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

/// Hands assimp the main file from memory and its companions (.mtl, .bin) from disk: the only way
/// by which it comes to a file.
class MemoryFirst : public Assimp::DefaultIOSystem {
 public:
  MemoryFirst(std::string path, std::string_view bytes, Companions& companions)
      : path_(std::move(path)), bytes_(bytes), companions_(companions) {}
  bool Exists(const char* file) const override {
    if (path_ == file) return true;
    std::error_code error;
    if (std::filesystem::exists(file, error)) return true;
    companions_.add(file, {});
    return false;
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (mode == nullptr || *mode != 'r') return nullptr;
    if (path_ == file) {
      return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                        bytes_.size());
    }
    if (!Exists(file)) return nullptr;
    try {
      std::string content = files::read_file(file, kLargestFile);
      companions_.add(file, files::sha256(content));
      return new CompanionStream(std::move(content));
    } catch (const Error& error) {
      companions_.add(file, {});
      companions_.problems.emplace_back(error.what());
      return nullptr;
    }
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

std::string texture_name(const aiMaterial& material) {
  aiString file;
  for (const aiTextureType type : {aiTextureType_DIFFUSE, aiTextureType_BASE_COLOR}) {
    if (material.GetTexture(type, 0, &file) == aiReturn_SUCCESS) {
      const std::string text = file.C_Str();
      return text.substr(text.find_last_of("/\\") + 1);
    }
  }
  return {};
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

/// Cuts a polygon into triangles by ears; points and lines give none. assimp's own step for this
/// ends the program on some damaged files.
void triangulate(const std::vector<Eigen::Vector3d>& vertices, std::vector<std::uint32_t>& polygon,
                 std::vector<std::array<std::uint32_t, 3>>& triangles) {
  // Polygons with many corners are terrain borders; beyond this the quadratic search is no use.
  constexpr std::size_t kMostEars = 2000;
  if (polygon.size() > 3 && polygon.size() <= kMostEars) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // Newell's
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      normal += (vertices[polygon[i]] - vertices[polygon[0]])
                    .cross(vertices[polygon[(i + 1) % polygon.size()]] - vertices[polygon[0]]);
    }
    const auto left = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      return normal.dot((vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]));
    };
    for (std::size_t i = 0, refused = 0; polygon.size() > 3 && refused < polygon.size();) {
      const std::size_t n = polygon.size();
      const std::uint32_t a = polygon[(i + n - 1) % n], b = polygon[i % n],
                          c = polygon[(i + 1) % n];
      bool ear = left(a, b, c) > 0.0;
      for (std::size_t k = 0; k < n && ear; ++k) {
        const std::uint32_t p = polygon[k];
        if (p == a || p == b || p == c) continue;
        ear = !(left(a, b, p) >= 0.0 && left(b, c, p) >= 0.0 && left(c, a, p) >= 0.0);
      }
      if (ear) {
        triangles.push_back({a, b, c});
        polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(i % n));
        refused = 0;
      } else {
        ++refused;
        ++i;
      }
      i %= polygon.size();
    }
  }
  // The last ear, or what no ear could be cut from (folded polygons): a fan.
  for (std::size_t k = 2; k < polygon.size(); ++k)
    triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
}

RawMesh flatten(const aiScene& scene, const Eigen::Vector3d& origin, const std::string& path) {
  RawMesh mesh;
  mesh.stored_as_float32 = true;
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = -lowest;
  std::vector<std::string> materials, textures;
  std::vector<std::uint32_t> polygon;
  for (unsigned int i = 0; i < scene.mNumMaterials; ++i) {
    materials.push_back(material_name(*scene.mMaterials[i]));
    textures.push_back(texture_name(*scene.mMaterials[i]));
  }
  struct Visit {
    const aiNode* node;
    Eigen::Matrix4d T_world_node;
  };
  std::vector<Visit> open{{scene.mRootNode, to_eigen(scene.mRootNode->mTransformation)}};
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    for (unsigned int k = visit.node->mNumChildren; k-- > 0;) {
      const aiNode* child = visit.node->mChildren[k];
      open.push_back({child, visit.T_world_node * to_eigen(child->mTransformation)});
    }
    for (unsigned int k = 0; k < visit.node->mNumMeshes; ++k) {
      if (visit.node->mMeshes[k] >= scene.mNumMeshes || scene.mMeshes[visit.node->mMeshes[k]] == nullptr)
        throw Error(fmt::format("{}: object '{}' refers to a part that the file does not hold; export the mesh again", path, object_name(*visit.node)));
      const aiMesh& part = *scene.mMeshes[visit.node->mMeshes[k]];
      std::string name = object_name(*visit.node);
      if (name.empty() || visit.node == scene.mRootNode)
        name = part.mName.length > 0 ? part.mName.C_Str() : name;
      const bool has_material = part.mMaterialIndex < scene.mNumMaterials;
      mesh.objects.push_back({name, has_material ? materials[part.mMaterialIndex] : "",
                              has_material ? textures[part.mMaterialIndex] : ""});
      const std::size_t base = mesh.vertices.size();
      if (base + part.mNumVertices > std::numeric_limits<std::uint32_t>::max()) {
        throw Error(fmt::format("{}: more than 4,294,967,295 vertices; reduce the mesh", path));
      }
      const Eigen::Matrix3d rotation = visit.T_world_node.topLeftCorner<3, 3>();
      const Eigen::Vector3d translation = visit.T_world_node.topRightCorner<3, 1>();
      for (unsigned int i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& v = part.mVertices[i];
        const Eigen::Vector3d local(static_cast<double>(v.x), static_cast<double>(v.y),
                                    static_cast<double>(v.z));
        lowest = lowest.cwiseMin(rotation * local);
        highest = highest.cwiseMax(rotation * local);
        mesh.vertices.emplace_back(rotation * local + translation + origin);
      }
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
        triangulate(mesh.vertices, polygon, mesh.triangles);
        mesh.object_of_triangle.resize(mesh.triangles.size(),
                                       static_cast<std::uint32_t>(mesh.objects.size() - 1));
      }
    }
  }
  if (!mesh.vertices.empty()) mesh.local_magnitude = ((lowest + highest) / 2).cwiseAbs().maxCoeff();
  if (scene.mMetaData) {
    float scale = 0.0f;
    double scale_double = 0.0;
    std::int32_t up_axis = -1;
    // FBX states centimetres per unit and its up axis; assimp applies neither.
    if (scene.mMetaData->Get("UnitScaleFactor", scale) && scale > 0.0f) {
      mesh.metres_per_unit = 0.01 * static_cast<double>(scale);
    } else if (scene.mMetaData->Get("UnitScaleFactor", scale_double) && scale_double > 0.0) {
      mesh.metres_per_unit = 0.01 * scale_double;
    }
    if (scene.mMetaData->Get("UpAxis", up_axis) && (up_axis == 1 || up_axis == 2))
      mesh.up = up_axis == 1 ? 'y' : 'z';
  }
  return mesh;
}

/// One remark for all companions that are not there. assimp looks for each in several places, which
/// it joins with two strokes, and for an .mtl of the mesh's own name: nobody asked for those.
void remark_missing(const std::string& path, const std::vector<MeshFile>& files,
                    std::vector<std::string>& remarks) {
  const std::filesystem::path mesh(path);
  const std::string own_mtl = std::filesystem::path(mesh).replace_extension(".mtl").string();
  std::string names;
  for (const MeshFile& file : files) {
    const auto has_its_name = [&](const MeshFile& other) {
      return !other.sha256.empty() && std::filesystem::path(other.path).filename() ==
                                          std::filesystem::path(file.path).filename();
    };
    if (!file.sha256.empty() || std::any_of(files.begin(), files.end(), has_its_name)) continue;
    if (file.path.find("//", mesh.parent_path().string().size()) != std::string::npos) continue;
    if (file.path == own_mtl && &file != &files.front()) continue;
    names += (names.empty() ? "" : ", ") + file.path;
  }
  if (!names.empty()) {
    remarks.push_back(fmt::format(
        "the mesh refers to files that are missing: {}; names of materials and textures may be too",
        names));
  }
}

RawMesh import_with_assimp(const std::string& path, std::string_view bytes,
                           const Eigen::Vector3d& origin) {
  Companions companions;
  Assimp::Importer importer;
  importer.SetIOHandler(new MemoryFirst(path, bytes, companions));  // owned by the importer
  importer.SetPropertyBool(AI_CONFIG_IMPORT_AC_EVAL_SUBDIVISION, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ANIMATIONS, false);
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(path, 0);
  } catch (const std::exception& error) {
    throw Error(fmt::format("{}: no mesh can be read from it: {}; copy or export it again", path,
                            error.what()));
  }
  if (scene == nullptr || scene->mRootNode == nullptr) {
    if (!companions.problems.empty()) throw Error(fmt::format("{}: {}", path, companions.problems.front()));
    std::string reason = importer.GetErrorString();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw Error(fmt::format(
        "{}: no mesh can be read from it: {}; give a complete mesh file (.obj .glb .ply .stl .fbx "
        ".dae .3ds .ac .acc)",
        path, reason));
  }
  RawMesh mesh = flatten(*scene, origin, path);
  if (companions.problems.empty()) remark_missing(path, companions.files, mesh.remarks);
  mesh.remarks.insert(mesh.remarks.end(), companions.problems.begin(), companions.problems.end());
  mesh.files = std::move(companions.files);
  return mesh;
}

void check_glb_length(std::string_view bytes, const std::string& path) {
  if (bytes.size() < 12 || !bytes.starts_with("glTF")) {
    throw Error(
        fmt::format("{}: no binary glTF (wanted 'glTF' at its beginning); give a mesh file", path));
  }
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, sizeof length);
  if (bytes.size() < length) {
    throw Error(
        fmt::format("{}: the file is truncated: its header promises {} bytes, it has {}; copy or "
                    "export it again",
                    path, length, bytes.size()));
  }
}

void check_3ds_length(std::string_view bytes, const std::string& path) {
  std::uint32_t length = 0;
  if (bytes.size() >= 6) std::memcpy(&length, bytes.data() + 2, sizeof length);
  if (bytes.size() < 6 || bytes.size() < length) {
    throw Error(fmt::format(
        "{}: the file is truncated: its main chunk promises {} bytes, it has {}; copy or export it "
        "again",
        path, length, bytes.size()));
  }
}

RawMesh read_raw(const std::string& path) {
  const std::string bytes = load(path);
  const std::string extension = lower_extension(path);
  if (extension == ".stl") return read_stl(bytes, path);
  if (extension == ".ply") return read_ply(bytes, path);
  if (extension == ".ac" || extension == ".acc" || extension == ".obj") {
    const LocalText local =
        extension == ".obj" ? localise_obj(bytes, path) : localise_ac3d(bytes, path);
    RawMesh mesh = import_with_assimp(path, local.text, local.origin);
    mesh.stored_as_float32 = local.float32_quantised;
    mesh.local_magnitude = 0.0;
    mesh.remarks.insert(mesh.remarks.begin(), local.remarks.begin(), local.remarks.end());
    if (extension != ".obj") {
      mesh.up = 'y';
      mesh.metres_per_unit = 0.0;
    }
    return mesh;
  }
  if (extension == ".glb") check_glb_length(bytes, path);
  if (extension == ".3ds") check_3ds_length(bytes, path);
  RawMesh mesh = import_with_assimp(path, bytes, Eigen::Vector3d::Zero());
  if (extension == ".glb" || extension == ".gltf") {
    mesh.up = 'y';
    mesh.metres_per_unit = 1.0;
  }
  // assimp turns Collada and 3DS scenes to y up and Collada lengths to metres.
  if (extension == ".dae") {
    mesh.up = 'y';
    mesh.metres_per_unit = 1.0;
  }
  return mesh;
}

double metres_per(Unit unit) {
  switch (unit) {
    case Unit::cm:
      return 0.01;
    case Unit::mm:
      return 0.001;
    case Unit::ft:
      return 0.3048;
    case Unit::automatic:
    case Unit::m:
      return 1.0;
  }
  return 1.0;
}

std::string unit_name(double metres_per_unit) {
  if (metres_per_unit == 1.0) return "m";
  if (metres_per_unit == 0.3048) return "ft";
  if (std::abs(metres_per_unit - 0.01) < 1e-9) return "cm";
  if (std::abs(metres_per_unit - 0.001) < 1e-10) return "mm";
  return fmt::format("{} m", metres_per_unit);
}

struct Facing {
  double y_area = 0.0, z_area = 0.0;  ///< area of all faces projected along y and along z
};

Facing facing(const RawMesh& mesh) {
  Facing out;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                       .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]) /
                                   2.0;
    // Squares: a slope of 45 degrees shall not count for both axes alike with a meadow.
    const double area = normal.norm();
    if (area > 0.0) {
      out.y_area += normal.y() * normal.y() / area;
      out.z_area += normal.z() * normal.z() / area;
    }
  }
  return out;
}

void check_vertices(const RawMesh& mesh, const std::string& path) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t index : mesh.triangles[i]) {
      const Eigen::Vector3d& v = mesh.vertices[index];
      if (v.allFinite() && v.cwiseAbs().maxCoeff() < 1e12) continue;
      const std::string& name = mesh.objects[mesh.object_of_triangle[i]].name;
      throw Error(
          fmt::format("{}: object '{}', vertex {}: ({:.9g}, {:.9g}, {:.9g}); wanted finite "
                      "coordinates of at most 1e7 m; "
                      "repair the object in the program that made it, or delete it",
                      path, name, index, v.x(), v.y(), v.z()));
    }
  }
}

char decide_up(const RawMesh& mesh, UpAxis wanted, const std::string& path,
               std::vector<std::string>& remarks) {
  const Facing area = facing(mesh);
  char seen = 0;
  if (area.y_area > kClearVerdict * area.z_area) seen = 'y';
  if (area.z_area > kClearVerdict * area.y_area) seen = 'z';
  const std::string figures = fmt::format(
      "faces that point along y: {:.0f}, along z: {:.0f} square units", area.y_area, area.z_area);
  if (wanted != UpAxis::automatic) {
    const char told = wanted == UpAxis::y ? 'y' : 'z';
    if (seen != 0 && seen != told) {
      throw Error(
          fmt::format("{}: told that {} is up, but the large flat faces say {} ({}); give --up {}",
                      path, told, seen, figures, seen));
    }
    return told;
  }
  if (mesh.up != 0 && seen != 0 && mesh.up != seen) {
    remarks.push_back(
        fmt::format("the format says {} is up, the large flat faces say {} ({}): took {}", mesh.up,
                    seen, figures, seen));
  }
  if (seen != 0) return seen;
  if (mesh.up != 0) return mesh.up;
  throw Error(
      fmt::format("{}: cannot tell which axis is up ({}; wanted twice as much along one); give "
                  "--up y or --up z",
                  path, figures));
}

double float32_spacing(double magnitude) {
  const auto value = static_cast<float>(magnitude);
  return static_cast<double>(std::nextafter(value, std::numeric_limits<float>::infinity()) - value);
}

}  // namespace

Mesh read_mesh(const std::string& path, const MeshReadOptions& options, MeshReadReport* report) {
  RawMesh raw = read_raw(path);
  if (raw.triangles.empty()) {
    throw Error(fmt::format(
        "{}: no triangles ({} vertices, {} objects); wanted a surface mesh; export faces, not "
        "points or curves",
        path, raw.vertices.size(), raw.objects.size()));
  }
  check_vertices(raw, path);
  std::vector<std::string> remarks = std::move(raw.remarks);

  const char up = decide_up(raw, options.up, path, remarks);
  if (up == 'y') {
    for (Eigen::Vector3d& v : raw.vertices) v = Eigen::Vector3d(v.x(), -v.z(), v.y());
  }

  // Only vertices in use count: exporters leave stray ones behind.
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = -lowest;
  for (const auto& t : raw.triangles) {
    for (const std::uint32_t index : t) {
      lowest = lowest.cwiseMin(raw.vertices[index]);
      highest = highest.cwiseMax(raw.vertices[index]);
    }
  }
  double scale = metres_per(options.unit);
  if (options.unit == Unit::automatic && raw.metres_per_unit > 0.0) scale = raw.metres_per_unit;
  const double extent = (highest - lowest).head<2>().maxCoeff();
  if (!(extent * scale >= kSmallestMesh_m && extent * scale <= kLargestMesh_m)) {
    std::string fitting;
    for (const auto& [name, factor] : {std::pair{"mm", 0.001}, {"cm", 0.01}, {"m", 1.0}}) {
      if (extent * factor >= 100.0 && extent * factor <= kLargestMesh_m) {
        fitting += fmt::format("{}--unit {} ({:.0f} m)", fitting.empty() ? "" : " or ", name,
                               extent * factor);
      }
    }
    throw Error(fmt::format("{}: the mesh is {:.6g} {} across; wanted {:.0f} m to {:.0f} km; {}",
                            path, extent, unit_name(scale), kSmallestMesh_m,
                            kLargestMesh_m / 1000.0,
                            fitting.empty() ? "check the file and its unit"
                                            : "if the unit is another, give " + fitting));
  }
  lowest *= scale;
  highest *= scale;
  if (std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff()) >
      kLargestCoordinate_m) {
    throw Error(fmt::format(
        "{}: coordinates reach ({:.6g}, {:.6g}, {:.6g}) m; wanted at most 1e7 m from the origin; "
        "move the mesh nearer to it",
        path, highest.x(), highest.y(), highest.z()));
  }

  double resolution_m = 0.0;
  if (raw.stored_as_float32) {
    const Eigen::Vector3d centre = (lowest + highest) / 2.0;
    const double magnitude =
        raw.local_magnitude > 0.0 ? raw.local_magnitude * scale : centre.cwiseAbs().maxCoeff();
    resolution_m = float32_spacing(magnitude);
    const Eigen::Vector3d origin = local_origin(lowest, highest);
    if (resolution_m > kWorstResolution_m) {
      throw Error(fmt::format(
          "{}: its coordinates (around {:.0f}, {:.0f} m) were stored as float32 and snap to {:.3g} "
          "m; wanted at most {} m; subtract ({:.0f}, {:.0f}, 0) before exporting, or export .obj "
          "or "
          ".ply in double precision",
          path, centre.x(), centre.y(), resolution_m, kWorstResolution_m, origin.x(), origin.y()));
    }
    if (resolution_m > kNotableResolution_m) {
      remarks.push_back(fmt::format(
          "the coordinates were stored as float32 far from the origin and snap to {:.1f} mm",
          1000.0 * resolution_m));
    }
  } else {
    resolution_m = std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff()) * 1.2e-16;
  }

  Mesh mesh;
  mesh.origin_m = local_origin(lowest, highest);
  mesh.vertices_m = std::move(raw.vertices);
  for (Eigen::Vector3d& v : mesh.vertices_m) v = v * scale - mesh.origin_m;
  mesh.triangles = std::move(raw.triangles);
  mesh.object_of_triangle = std::move(raw.object_of_triangle);
  mesh.objects = std::move(raw.objects);
  if (report != nullptr) {
    report->up = std::string(1, up);
    report->unit = unit_name(scale);
    report->vertices = mesh.vertices_m.size();
    report->triangles = mesh.triangles.size();
    report->objects = mesh.objects.size();
    report->coordinate_resolution_m = resolution_m;
    report->remarks = std::move(remarks);
    report->files = std::move(raw.files);
  }
  return mesh;
}

}  // namespace road
