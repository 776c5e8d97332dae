// A small road with a wall as the bytes of a file, in the formats that simulators export.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "mesh/mesh.h"

namespace support {

/// A 200 m x 12 m road of 20 quads, rising 2 %, with a 3 m high wall along its left side.
inline road::Mesh small_road() {
  road::Mesh mesh;
  mesh.objects = {{"road", "asphalt", "asphalt.png"}, {"wall", "concrete", "wall.png"}};
  for (int i = 0; i <= 20; ++i) {
    const double x = 10.0 * i;
    mesh.vertices_m.emplace_back(x, -6.0, 0.02 * x);
    mesh.vertices_m.emplace_back(x, 6.0, 0.02 * x);
    mesh.vertices_m.emplace_back(x, 6.0, 0.02 * x + 3.0);
  }
  for (std::uint32_t i = 0; i < 20; ++i) {
    const std::uint32_t a = 3 * i;
    for (const std::array<std::uint32_t, 3>& t :
         {std::array<std::uint32_t, 3>{a, a + 3, a + 1}, {a + 1, a + 3, a + 4}}) {
      mesh.triangles.push_back(t);
      mesh.object_of_triangle.push_back(0);
    }
    for (const std::array<std::uint32_t, 3>& t :
         {std::array<std::uint32_t, 3>{a + 1, a + 4, a + 2}, {a + 2, a + 4, a + 5}}) {
      mesh.triangles.push_back(t);
      mesh.object_of_triangle.push_back(1);
    }
  }
  return mesh;
}

inline Eigen::Vector3d to_file(const Eigen::Vector3d& v, char up) {
  return up == 'z' ? v : Eigen::Vector3d(v.x(), v.z(), -v.y());
}

inline std::string as_obj(const road::Mesh& mesh, char up = 'z',
                          const Eigen::Vector3d& offset = Eigen::Vector3d::Zero(),
                          double scale = 1.0) {
  std::string text;
  for (const auto& v : mesh.vertices_m) {
    const Eigen::Vector3d p = to_file(scale * (v + offset), up);
    text += fmt::format("v {:.6f} {:.6f} {:.6f}\n", p.x(), p.y(), p.z());
  }
  for (std::uint32_t object = 0; object < mesh.objects.size(); ++object) {
    text +=
        fmt::format("o {}\nusemtl {}\n", mesh.objects[object].name, mesh.objects[object].material);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& t = mesh.triangles[i];
      if (mesh.object_of_triangle[i] == object)
        text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
  }
  return text;
}

/// The layout that TORCS uses: groups around groups, several texture lines, strips of triangles.
inline std::string as_acc(const road::Mesh& mesh,
                          const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  std::string text =
      "AC3Db\nMATERIAL \"\" rgb 0.4 0.4 0.4 amb 0.8 0.8 0.8 emis 0.4 0.4 0.4 spec 0.5 0.5 0.5 shi "
      "50 trans 0\n"
      "OBJECT world\nkids 1\nOBJECT group\nname \"TKMN1_g\"\nkids " +
      std::to_string(mesh.objects.size()) + "\n";
  for (std::uint32_t object = 0; object < mesh.objects.size(); ++object) {
    text += fmt::format(
        "OBJECT poly\nname \"{}\"\ntexture \"{}\" base\ntexture \"shadow.rgb\" tiled\n"
        "texture empty_texture_no_mapping skids\ntexture empty_texture_no_mapping shad\nnumvert "
        "{}\n",
        mesh.objects[object].name, mesh.objects[object].texture, mesh.vertices_m.size());
    for (const auto& v : mesh.vertices_m) {
      const Eigen::Vector3d p = to_file(v + offset, 'y');
      text += fmt::format("{:.6f} {:.6f} {:.6f} 0 1 0\n", p.x(), p.y(), p.z());
    }
    const auto count =
        std::count(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), object);
    text += fmt::format("numsurf {}\n", count);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (mesh.object_of_triangle[i] != object) continue;
      text += "SURF 0x10\nmat 0\nrefs 3\n";
      for (const std::uint32_t v : mesh.triangles[i])
        text += fmt::format("{} 0.5 0.5 0.1 0.1\n", v);
    }
    text += "kids 0\n";
  }
  return text;
}

template <class T>
inline void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string as_stl(const road::Mesh& mesh,
                          const Eigen::Vector3d& offset = Eigen::Vector3d::Zero(),
                          const char* header = "exported") {
  std::string bytes(header);
  bytes.resize(80, '\0');
  append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) append(bytes, 0.0f);
    for (int c = 0; c < 3; ++c) {
      for (const double value : Eigen::Vector3d(mesh.vertex(i, c) + offset))
        append(bytes, static_cast<float>(value));
    }
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

inline std::string as_text_stl(const road::Mesh& mesh) {
  std::string text = "solid the road\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    text += "  facet normal 0 0 1\n    outer loop\n";
    for (int c = 0; c < 3; ++c) {
      const auto& v = mesh.vertex(i, c);
      text += fmt::format("      vertex {:e} {:e} {:e}\n", v.x(), v.y(), v.z());
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid the road\n";
}

inline std::string as_ply(const road::Mesh& mesh, const std::string& format,
                          const std::string& type,
                          const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  std::string bytes = fmt::format(
      "ply\nformat {} 1.0\ncomment made by hand\nelement vertex {}\nproperty {} x\nproperty {} y\n"
      "property {} z\nproperty uchar red\nelement face {}\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      format, mesh.vertices_m.size(), type, type, type, mesh.triangles.size());
  const bool big = format == "binary_big_endian";
  const auto number = [&](auto value) {
    std::string raw;
    append(raw, value);
    if (big) std::reverse(raw.begin(), raw.end());
    bytes += raw;
  };
  for (const auto& v : mesh.vertices_m) {
    for (const double value : Eigen::Vector3d(v + offset)) {
      if (format == "ascii") {
        bytes += fmt::format("{:.6f} ", value);
      } else if (type == "double") {
        number(value);
      } else {
        number(static_cast<float>(value));
      }
    }
    if (format == "ascii") {
      bytes += "255\n";
    } else {
      bytes += '\xff';
    }
  }
  for (const auto& t : mesh.triangles) {
    if (format == "ascii") {
      bytes += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    } else {
      bytes += '\3';
      for (const std::uint32_t index : t) number(static_cast<std::int32_t>(index));
    }
  }
  return bytes;
}

/// Binary glTF with one node per object, moved by `offset` through the node's translation. With the
/// bytes of a PNG or JPEG for each object: in its buffer, as the object's base texture.
inline std::string as_glb(const road::Mesh& mesh, const std::vector<std::string>& pictures = {}) {
  std::string buffer, nodes, meshes, accessors, views, materials, children, images, textures;
  for (std::uint32_t object = 0; object < mesh.objects.size(); ++object) {
    std::string positions;
    std::size_t count = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (mesh.object_of_triangle[i] != object) continue;
      for (int c = 0; c < 3; ++c) {
        for (const double value : to_file(mesh.vertex(i, c) - Eigen::Vector3d(0, 0, 5), 'y'))
          append(positions, static_cast<float>(value));
        ++count;
      }
    }
    const char* comma = object == 0 ? "" : ",";
    views += fmt::format("{}{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}", comma,
                         buffer.size(), positions.size());
    accessors += fmt::format(
        "{}{{\"bufferView\":{},\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":[-"
        "1000,-1000,-1000],\"max\":[1000,1000,1000]}}",
        comma, object, count);
    meshes += fmt::format(
        "{}{{\"name\":\"m{}\",\"primitives\":[{{\"attributes\":{{\"POSITION\":{}}},\"material\":{}}"
        "}]}}",
        comma, object, object, object);
    const std::string look =
        pictures.empty()
            ? ""
            : fmt::format(",\"pbrMetallicRoughness\":{{\"baseColorTexture\":{{\"index\":{}}}}}",
                          object);
    materials += fmt::format("{}{{\"name\":\"{}\"{}}}", comma, mesh.objects[object].material, look);
    nodes += fmt::format("{{\"name\":\"{}\",\"mesh\":{},\"translation\":[0,5,0]}},",
                         mesh.objects[object].name, object);
    children += fmt::format("{}{}", comma, object);
    buffer += positions;
  }
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const char* comma = k == 0 ? "" : ",";
    views += fmt::format(",{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}", buffer.size(),
                         pictures[k].size());
    images +=
        fmt::format("{}{{\"bufferView\":{},\"mimeType\":\"image/{}\"}}", comma,
                    mesh.objects.size() + k, pictures[k].starts_with("\xff") ? "jpeg" : "png");
    textures += fmt::format("{}{{\"source\":{}}}", comma, k);
    buffer += pictures[k];
    while (buffer.size() % 4 != 0) buffer += '\0';
  }
  if (!pictures.empty())
    materials += fmt::format("],\"images\":[{}],\"textures\":[{}", images, textures);
  std::string json = fmt::format(
      "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[{}]}}],\"nodes\":[{"
      "}{{\"name\":\"root\",\"children\":[{}]}}],"
      "\"meshes\":[{}],\"materials\":[{}],\"accessors\":[{}],\"bufferViews\":[{}],\"buffers\":[{{"
      "\"byteLength\":{}}}]}}",
      mesh.objects.size(), nodes, children, meshes, materials, accessors, views, buffer.size());
  while (json.size() % 4 != 0) json += ' ';
  std::string bytes = "glTF";
  append(bytes, std::uint32_t{2});
  append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.size()));
  append(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append(bytes, static_cast<std::uint32_t>(buffer.size()));
  bytes += std::string("BIN\0", 4) + buffer;
  return bytes;
}

/// The same as text and a buffer beside it, which the text calls `uri`.
struct GltfAndBin {
  std::string gltf, bin;
};
inline GltfAndBin as_gltf(const road::Mesh& mesh, const std::string& uri) {
  const std::string glb = as_glb(mesh);
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  GltfAndBin out{glb.substr(20, length), glb.substr(20 + length + 8)};
  const std::string buffer = "\"buffers\":[{";
  out.gltf.insert(out.gltf.find(buffer) + buffer.size(), "\"uri\":\"" + uri + "\",");
  return out;
}

}  // namespace support
