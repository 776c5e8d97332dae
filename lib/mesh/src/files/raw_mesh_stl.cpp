#include <fmt/format.h>

#include <cstring>

#include "base/text_lines.h"
#include "mesh/error.h"
#include "raw_mesh.h"

// STL has a binary and a text form and no mark that tells them apart: binary files exist whose
// 80 free header bytes begin with "solid". The size decides, since it follows from the count.

namespace road {
namespace {

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kTriangleBytes = 50;

RawMesh read_binary(std::string_view bytes, std::size_t count) {
  RawMesh mesh;
  mesh.stored_as_float32 = true;
  mesh.objects.emplace_back();
  mesh.vertices.reserve(3 * count);
  mesh.triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 9> corner;
    std::memcpy(corner.data(), bytes.data() + kHeaderBytes + kTriangleBytes * i + 12,
                sizeof corner);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.vertices.emplace_back(corner[3 * k], corner[3 * k + 1], corner[3 * k + 2]);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  mesh.object_of_triangle.assign(count, 0);
  return mesh;
}

RawMesh read_text(std::string_view bytes, const std::string& path) {
  RawMesh mesh;
  base::Lines lines(bytes);
  std::string_view line;
  bool in_solid = false;
  std::size_t corners = 0;
  while (lines.next(line)) {
    std::string_view rest = line;
    const std::string_view word = base::take_word(rest);
    if (word.empty() || word == "facet" || word == "outer" || word == "endloop") continue;
    if (word == "solid") {
      in_solid = true;
      const std::size_t begin = rest.find_first_not_of(" \t");
      mesh.objects.push_back(
          {begin == std::string_view::npos ? "" : std::string(rest.substr(begin)), "", ""});
    } else if (word == "endsolid") {
      in_solid = false;
    } else if (word == "vertex" && in_solid) {
      Eigen::Vector3d vertex;
      for (int axis = 0; axis < 3; ++axis) {
        const auto value = base::to_number<double>(base::take_word(rest));
        if (!value) {
          throw Error(fmt::format("{}:{}: '{}': wanted 'vertex x y z'; export the mesh again", path,
                                  lines.number(), line.substr(0, 60)));
        }
        vertex[axis] = *value;
      }
      mesh.vertices.push_back(vertex);
      ++corners;
    } else if (word == "endfacet" && in_solid) {
      if (corners < 3) {
        throw Error(fmt::format("{}:{}: a facet with {} vertices; wanted 3; export the mesh again",
                                path, lines.number(), corners));
      }
      const auto end = static_cast<std::uint32_t>(mesh.vertices.size());
      for (std::uint32_t k = 2; k < corners; ++k) {
        const std::uint32_t first = end - static_cast<std::uint32_t>(corners);
        mesh.triangles.push_back({first, first + k - 1, first + k});
        mesh.object_of_triangle.push_back(static_cast<std::uint32_t>(mesh.objects.size() - 1));
      }
      corners = 0;
    } else {
      throw Error(
          fmt::format("{}:{}: '{}': this is no STL text (wanted solid, facet, vertex ...); "
                      "give a mesh file",
                      path, lines.number(), line.substr(0, 60)));
    }
  }
  if (in_solid || corners > 0) {
    throw Error(
        fmt::format("{}:{}: the file is truncated: it ends after {} triangles without 'endsolid'; "
                    "copy or export it again",
                    path, lines.number(), mesh.triangles.size()));
  }
  return mesh;
}

}  // namespace

RawMesh read_stl(std::string_view bytes, const std::string& path) {
  const bool says_solid = bytes.starts_with("solid");
  if (bytes.size() >= kHeaderBytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    const std::size_t wanted = kHeaderBytes + kTriangleBytes * static_cast<std::size_t>(count);
    const bool binary = bytes.size() == wanted || !says_solid ||
                        bytes.substr(0, 512).find('\0') != std::string_view::npos;
    if (binary && bytes.size() < wanted) {
      throw Error(fmt::format(
          "{}: the file is truncated: its header promises {} triangles ({} bytes), it has "
          "{} bytes; copy or export it again",
          path, count, wanted, bytes.size()));
    }
    if (binary) {
      RawMesh mesh = read_binary(bytes, count);
      if (bytes.size() > wanted) {
        mesh.remarks.push_back(
            fmt::format("{} bytes after the last triangle were ignored", bytes.size() - wanted));
      }
      return mesh;
    }
  }
  if (!says_solid) {
    throw Error(fmt::format(
        "{}: no STL file ({} bytes, wanted at least {} or text that begins with 'solid'); "
        "give a mesh file",
        path, bytes.size(), kHeaderBytes));
  }
  return read_text(bytes, path);
}

}  // namespace road
