#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/text_lines.h"
#include "mesh/error.h"
#include "raw_mesh.h"

// PLY as of Turk, "The PLY Polygon File Format" (1994): a text header that lists elements and their
// properties, then the elements as text or binary of either byte order. Read here and not by assimp
// because assimp turns double coordinates into float.

namespace road {
namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Type> type_named(std::string_view name) {
  if (name == "char" || name == "int8") return Type::i8;
  if (name == "uchar" || name == "uint8") return Type::u8;
  if (name == "short" || name == "int16") return Type::i16;
  if (name == "ushort" || name == "uint16") return Type::u16;
  if (name == "int" || name == "int32") return Type::i32;
  if (name == "uint" || name == "uint32") return Type::u32;
  if (name == "float" || name == "float32") return Type::f32;
  if (name == "double" || name == "float64") return Type::f64;
  return std::nullopt;
}

std::size_t size_of(Type type) {
  switch (type) {
    case Type::i8:
    case Type::u8:
      return 1;
    case Type::i16:
    case Type::u16:
      return 2;
    case Type::i32:
    case Type::u32:
    case Type::f32:
      return 4;
    case Type::f64:
      return 8;
  }
  return 0;
}

struct Property {
  std::string name;
  Type type = Type::f32;
  std::optional<Type> count_type;  ///< set for lists
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

/// Numbers one after the other from the body, in whatever form the header announced.
class Body {
 public:
  Body(std::string_view bytes, bool text, bool swap) : rest_(bytes), text_(text), swap_(swap) {}

  /// False at the end of the file.
  bool next(Type type, double& value) {
    if (text_) {
      const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
      if (begin == std::string_view::npos) return false;
      const std::size_t end = std::min(rest_.find_first_of(" \t\r\n", begin), rest_.size());
      const auto number = base::to_number<double>(rest_.substr(begin, end - begin));
      rest_.remove_prefix(end);
      if (!number) return false;
      value = *number;
      return true;
    }
    const std::size_t size = size_of(type);
    if (rest_.size() < size) return false;
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), rest_.data(), size);
    if (swap_) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    rest_.remove_prefix(size);
    switch (type) {
      case Type::i8:
        value = as<std::int8_t>(raw);
        break;
      case Type::u8:
        value = as<std::uint8_t>(raw);
        break;
      case Type::i16:
        value = as<std::int16_t>(raw);
        break;
      case Type::u16:
        value = as<std::uint16_t>(raw);
        break;
      case Type::i32:
        value = as<std::int32_t>(raw);
        break;
      case Type::u32:
        value = as<std::uint32_t>(raw);
        break;
      case Type::f32:
        value = static_cast<double>(as<float>(raw));
        break;
      case Type::f64:
        value = as<double>(raw);
        break;
    }
    return true;
  }
  std::size_t left() const { return rest_.size(); }

 private:
  template <class T>
  static T as(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }
  std::string_view rest_;
  bool text_;
  bool swap_;
};

struct Header {
  std::vector<Element> elements;
  bool text = false;
  bool big_endian = false;
  /// "comment origin_m X Y Z", as lidar2mesh writes it: to be added to every vertex.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::string_view body;
};

Header read_header(std::string_view bytes, const std::string& path) {
  Header header;
  base::Lines lines(bytes);
  std::string_view line;
  const auto fail = [&](std::string_view wanted) {
    throw Error(fmt::format("{}:{}: '{}': wanted {}; export the mesh again", path, lines.number(),
                            line.substr(0, 60), wanted));
  };
  if (!lines.next(line) || line != "ply") fail("'ply' in the first line of a .ply file");
  bool has_format = false;
  while (true) {
    if (!lines.next(line)) {
      throw Error(fmt::format(
          "{}: the file is truncated inside its header; copy or export it again", path));
    }
    std::string_view rest = line;
    const std::string_view word = base::take_word(rest);
    if (word == "end_header") break;
    if (word == "format") {
      const std::string_view format = base::take_word(rest);
      if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian") {
        fail("ascii, binary_little_endian or binary_big_endian");
      }
      header.text = format == "ascii";
      header.big_endian = format == "binary_big_endian";
      has_format = true;
    } else if (word == "element") {
      Element element;
      element.name = base::take_word(rest);
      const auto count = base::to_number<std::uint64_t>(base::take_word(rest));
      if (!count) fail("'element NAME COUNT'");
      element.count = *count;
      header.elements.push_back(element);
    } else if (word == "property") {
      if (header.elements.empty()) fail("an element before its properties");
      Property property;
      std::string_view type = base::take_word(rest);
      if (type == "list") {
        property.count_type = type_named(base::take_word(rest));
        if (!property.count_type) fail("'property list COUNT_TYPE TYPE NAME'");
        type = base::take_word(rest);
      }
      const auto known = type_named(type);
      if (!known) fail("a type of char, uchar, short, ushort, int, uint, float, double");
      property.type = *known;
      property.name = base::take_word(rest);
      header.elements.back().properties.push_back(property);
    } else if (word == "comment" && base::take_word(rest) == "origin_m") {
      for (double& value : header.origin) {
        const auto number = base::to_number<double>(base::take_word(rest));
        if (!number || !std::isfinite(*number)) fail("'comment origin_m X Y Z', three numbers");
        value = *number;
      }
    } else if (!word.empty() && word != "comment" && word != "obj_info") {
      fail("format, element, property, comment or end_header");
    }
  }
  if (!has_format)
    throw Error(fmt::format("{}: the header has no format line; export the mesh again", path));
  header.body = lines.rest();
  return header;
}

/// What float32 had to carry are the coordinates before this.
void add_origin(const Eigen::Vector3d& origin, RawMesh& mesh) {
  if (origin.isZero() || mesh.vertices.empty()) return;
  Eigen::Vector3d low = mesh.vertices.front(), high = low;
  for (Eigen::Vector3d& vertex : mesh.vertices) {
    low = low.cwiseMin(vertex), high = high.cwiseMax(vertex);
    vertex += origin;
  }
  mesh.local_magnitude = std::max(1.0, (0.5 * (low + high)).cwiseAbs().maxCoeff());
}

void begin_vertices(const Element& element, bool text, const std::string& path, RawMesh& mesh) {
  std::array<bool, 3> seen{};
  for (const Property& property : element.properties) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (property.count_type || property.name != std::string(1, static_cast<char>('x' + axis)))
        continue;
      seen[axis] = true;
      mesh.stored_as_float32 = mesh.stored_as_float32 || property.type == Type::f32;
    }
  }
  if (!seen[0] || !seen[1] || !seen[2]) {
    throw Error(fmt::format("{}: the vertices lack x, y or z; export the mesh again", path));
  }
  mesh.vertices.reserve(element.count);
  // A text file may carry more than the declared float; what it carries counts.
  if (text) mesh.stored_as_float32 = false;
}

/// Reads the elements of one kind into the mesh; those that are neither vertices nor faces are
/// passed over.
void read_element(const Element& element, const Header& header, const std::string& path, Body& body,
                  RawMesh& mesh) {
  // Bound the count by what can follow, so that a forged header cannot ask for memory.
  std::uint64_t least_bytes = 0;
  for (const Property& property : element.properties) {
    least_bytes += header.text ? 1 : size_of(property.count_type.value_or(property.type));
  }
  const auto truncated = [&](std::uint64_t read) {
    return Error(fmt::format(
        "{}: the file is truncated or damaged: its header promises {} of '{}', it holds {}; "
        "copy or export it again",
        path, element.count, element.name, read));
  };
  if (element.properties.empty() && element.count > 0) {
    throw Error(fmt::format("{}: element '{}' has no properties; export the mesh again", path,
                            element.name));
  }
  if (least_bytes > 0 && element.count > body.left() / least_bytes + 1)
    throw truncated(body.left() / least_bytes);

  const bool vertices = element.name == "vertex";
  const bool faces = element.name == "face";
  if (vertices) begin_vertices(element, header.text, path, mesh);
  std::vector<std::uint32_t> polygon;
  const auto read_list = [&](const Property& property, std::uint64_t i) {
    double value = 0.0;
    double count = 0.0;
    if (!body.next(*property.count_type, count)) throw truncated(i);
    const double most =
        static_cast<double>(header.text ? body.left() : body.left() / size_of(property.type));
    if (!(count >= 0.0 && count <= most)) throw truncated(i);
    const bool corners =
        faces && (property.name == "vertex_indices" || property.name == "vertex_index");
    polygon.clear();
    for (double k = 0.0; k < count; ++k) {
      if (!body.next(property.type, value)) throw truncated(i);
      if (!corners) continue;
      if (!(value >= 0.0 && value < static_cast<double>(mesh.vertices.size())) ||
          value != std::floor(value)) {
        throw Error(
            fmt::format("{}: face {} refers to vertex {}, but there are {}; export the mesh again",
                        path, i, value, mesh.vertices.size()));
      }
      polygon.push_back(static_cast<std::uint32_t>(value));
    }
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
    }
  };
  for (std::uint64_t i = 0; i < element.count; ++i) {
    Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
    for (const Property& property : element.properties) {
      double value = 0.0;
      if (!property.count_type) {
        if (!body.next(property.type, value)) throw truncated(i);
        if (vertices && property.name.size() == 1 && property.name[0] >= 'x' &&
            property.name[0] <= 'z') {
          vertex[property.name[0] - 'x'] = value;
        }
        continue;
      }
      read_list(property, i);
    }
    if (vertices) mesh.vertices.push_back(vertex);
  }
}

}  // namespace

RawMesh read_ply(std::string_view bytes, const std::string& path) {
  const Header header = read_header(bytes, path);
  const bool swap = header.big_endian != (std::endian::native == std::endian::big);
  Body body(header.body, header.text, swap);
  RawMesh mesh;
  mesh.objects.emplace_back();
  for (const Element& element : header.elements) read_element(element, header, path, body, mesh);
  add_origin(header.origin, mesh);
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  return mesh;
}

}  // namespace road
