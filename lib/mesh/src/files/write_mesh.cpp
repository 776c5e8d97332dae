#include <fmt/format.h>

#include <Eigen/Geometry>
#include <bit>
#include <iterator>

#include "base/ending.h"
#include "base/write_file.h"
#include "mesh/error.h"
#include "mesh/read_mesh.h"

namespace road {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary files are written in the machine's byte order");

template <class T>
void append_raw(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string to_stl(const Mesh& mesh, const std::string& note) {
  std::string bytes(80, ' ');
  const std::string head = ("kerbstone " + note).substr(0, bytes.size());
  bytes.replace(0, head.size(), head);  // not "solid": readers take that for the text form
  append_raw(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  bytes.reserve(bytes.size() + 50 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3d& a = mesh.vertex(i, 0);
    Eigen::Vector3d normal = (mesh.vertex(i, 1) - a).cross(mesh.vertex(i, 2) - a);
    const double length = normal.norm();
    if (length > 0.0) normal /= length;
    for (const double value : normal) append_raw(bytes, static_cast<float>(value));
    for (int corner = 0; corner < 3; ++corner) {
      for (const double value : mesh.origin_m + mesh.vertex(i, corner))
        append_raw(bytes, static_cast<float>(value));
    }
    append_raw(bytes, static_cast<std::uint16_t>(
                          mesh.object_of_triangle.empty() ? 0 : mesh.object_of_triangle[i]));
  }
  return bytes;
}

std::string to_ply(const Mesh& mesh, const std::string& note) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment kerbstone {}\nelement vertex {}\nproperty "
      "double x\n"
      "property double y\nproperty double z\nelement face {}\nproperty list uchar uint "
      "vertex_indices\nend_header\n",
      note, mesh.vertices_m.size(), mesh.triangles.size());
  bytes.reserve(bytes.size() + 24 * mesh.vertices_m.size() + 13 * mesh.triangles.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    for (const double value : mesh.origin_m + vertex) append_raw(bytes, value);
  }
  for (const auto& triangle : mesh.triangles) {
    append_raw(bytes, std::uint8_t{3});
    for (const std::uint32_t index : triangle) append_raw(bytes, index);
  }
  return bytes;
}

/// A name as .obj carries it: one line, no leading or trailing blanks.
std::string obj_name(const std::string& name, std::size_t number) {
  std::string clean;
  for (const char c : name) clean += static_cast<unsigned char>(c) < ' ' ? '_' : c;
  const std::size_t begin = clean.find_first_not_of(' ');
  if (begin == std::string::npos) return fmt::format("object{}", number);
  return clean.substr(begin, clean.find_last_not_of(' ') - begin + 1);
}

std::string to_obj(const Mesh& mesh, const std::string& note) {
  std::string text = "# kerbstone " + note + "\n";
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    const Eigen::Vector3d map = mesh.origin_m + vertex;
    fmt::format_to(std::back_inserter(text), "v {:.6f} {:.6f} {:.6f}\n", map.x(), map.y(), map.z());
  }
  std::uint32_t open = std::numeric_limits<std::uint32_t>::max();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t object = mesh.object_of_triangle.empty() ? 0 : mesh.object_of_triangle[i];
    if (object != open && object < mesh.objects.size()) {
      open = object;
      fmt::format_to(std::back_inserter(text), "o {}\n",
                     obj_name(mesh.objects[object].name, object));
      if (!mesh.objects[object].material.empty()) {
        fmt::format_to(std::back_inserter(text), "usemtl {}\n",
                       obj_name(mesh.objects[object].material, object));
      }
    }
    const auto& t = mesh.triangles[i];
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  return text;
}

}  // namespace

void write_mesh(const Mesh& mesh, const std::string& path, const std::string& note) {
  const std::string extension = base::ending_of(path);
  if (extension == ".stl") {
    base::write_file(path, to_stl(mesh, note));
  } else if (extension == ".ply") {
    base::write_file(path, to_ply(mesh, note));
  } else if (extension == ".obj" || path == "-") {
    base::write_file(path, to_obj(mesh, note));
  } else {
    throw Error(fmt::format(
        "{}: '{}' is no format to write a mesh in; give a name that ends in .stl, .ply or .obj",
        path, extension));
  }
}

}  // namespace road
