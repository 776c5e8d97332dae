#include "gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "mesh/error.h"

namespace road {
namespace {

// A flat grid of equal squares takes next to nothing; meshes as they are take a byte or more for
// each triangle.
constexpr std::uint64_t kDeclared = 1'000'000, kDeclaredPerByte = 20;
// The standard allows 252.
constexpr std::uint64_t kLargestStride = 1'000'000;

[[noreturn]] void refuse_gltf(const std::string& why) { throw UnusableGltf(why); }

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Three bytes as four characters, and back.
constexpr std::string_view kBase64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string to_base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kBase64[three >> (18 - 6 * k) & 63u] : '=');
  }
  return text;
}

std::string from_base64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t held = 0;
  int bits = 0;
  for (const char c : text) {
    const std::size_t value = kBase64.find(c);
    if (value == std::string_view::npos) break;
    held = held << 6 | static_cast<std::uint32_t>(value);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<char>(held >> bits & 255u));
  }
  return bytes;
}

GltfJson parsed(std::string_view text) {
  GltfJson root = GltfJson::parse(text, nullptr, false);
  if (!root.is_discarded()) return root;
  std::string ascii(text);  // names in other encodings than UTF-8
  std::replace_if(
      ascii.begin(), ascii.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; },
      '?');
  return GltfJson::parse(ascii, nullptr, false);
}

template <class T>
double as_stored(const char* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double component_at(const char* at, GltfComponent type) {
  switch (type) {
    case GltfComponent::int8:
      return as_stored<std::int8_t>(at);
    case GltfComponent::uint8:
      return as_stored<std::uint8_t>(at);
    case GltfComponent::int16:
      return as_stored<std::int16_t>(at);
    case GltfComponent::uint16:
      return as_stored<std::uint16_t>(at);
    case GltfComponent::uint32:
      return as_stored<std::uint32_t>(at);
    case GltfComponent::float32:
      return as_stored<float>(at);
  }
  return 0.0;
}

std::size_t size_of(GltfComponent type) {
  switch (type) {
    case GltfComponent::int8:
    case GltfComponent::uint8:
      return 1;
    case GltfComponent::int16:
    case GltfComponent::uint16:
      return 2;
    case GltfComponent::uint32:
    case GltfComponent::float32:
      return 4;
  }
  return 0;
}

/// Elements of `components` numbers in a view, `count` of them at least.
class Elements {
 public:
  Elements(GltfFile& file, const GltfJson& object, GltfComponent type, std::size_t components,
           std::uint64_t count, bool packed)
      : type_(type), size_(size_of(type)), stride_(size_ * components) {
    const std::uint64_t view = gltf_whole(object, "bufferView");
    bytes_ = file.view(view);
    const std::uint64_t begin = gltf_whole_or_0(object, "byteOffset");
    const GltfJson& views = file.root().at("bufferViews");
    const std::uint64_t stride = packed ? 0 : gltf_whole_or_0(views.at(view), "byteStride");
    const std::size_t element = stride_;
    if (stride != 0) stride_ = stride;
    if (stride > kLargestStride || begin > bytes_.size() ||
        (count > 0 && (bytes_.size() - begin < element ||
                       (bytes_.size() - begin - element) / stride_ < count - 1)))
      refuse_gltf(fmt::format("{} elements, {} bytes apart, from byte {} on, do not fit into {}",
                              count, stride_, begin, bytes_.size()));
    bytes_.remove_prefix(begin);
  }
  double at(std::uint64_t element, std::size_t component) const {
    return component_at(bytes_.data() + element * stride_ + component * size_, type_);
  }

 private:
  GltfComponent type_;
  std::size_t size_, stride_;
  std::string_view bytes_;
};

/// What the integer 1.0 is, or 0: the numbers are meant as they are.
double whole_of(const GltfJson& accessor, GltfComponent type) {
  const auto normalised = accessor.find("normalized");
  if (normalised == accessor.end() || !normalised->is_boolean() || !normalised->get<bool>() ||
      type == GltfComponent::float32)
    return 0.0;
  const bool is_signed = type == GltfComponent::int8 || type == GltfComponent::int16;
  return std::exp2(8.0 * static_cast<double>(size_of(type)) - (is_signed ? 1.0 : 0.0)) - 1.0;
}

template <class T>
std::vector<T> numbers_of(GltfFile& file, std::uint64_t number, std::size_t components) {
  const GltfJson accessor = file.root().at("accessors").at(number);
  constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  if (accessor.at("type") != kTypes[components - 1])
    refuse_gltf(fmt::format("accessor {} is no {}", number, kTypes[components - 1]));
  const GltfComponent type = gltf_component(accessor);
  const std::uint64_t count = gltf_whole(accessor, "count");
  file.declare(count, "vertices");
  const double whole = whole_of(accessor, type);
  std::vector<T> out(count * components);
  const auto take = [&](const Elements& from, std::uint64_t element, std::uint64_t to) {
    for (std::size_t c = 0; c < components; ++c) {
      const double value = from.at(element, c);
      out[to * components + c] =
          static_cast<T>(whole > 0.0 ? std::max(value / whole, -1.0) : value);
    }
  };
  if (accessor.contains("bufferView")) {
    const Elements stored(file, accessor, type, components, count, false);
    for (std::uint64_t i = 0; i < count; ++i) take(stored, i, i);
  }
  const auto sparse = accessor.find("sparse");
  if (sparse == accessor.end()) return out;
  const std::uint64_t changed = gltf_whole(*sparse, "count");
  if (changed > count)
    refuse_gltf(fmt::format("accessor {} changes {} of {} elements", number, changed, count));
  const GltfJson& places = sparse->at("indices");
  const Elements where(file, places, gltf_component(places), 1, changed, true);
  const Elements what(file, sparse->at("values"), type, components, changed, true);
  for (std::uint64_t i = 0; i < changed; ++i) {
    const double place = where.at(i, 0);
    if (!(place >= 0.0 && place < static_cast<double>(count)))
      refuse_gltf(fmt::format("accessor {} changes element {} of {}", number, place, count));
    take(what, i, static_cast<std::uint64_t>(place));
  }
  return out;
}

}  // namespace

std::uint64_t gltf_whole(const GltfJson& object, const char* key) {
  const GltfJson& value = object.at(key);
  if (!value.is_number_unsigned()) refuse_gltf(fmt::format("'{}' is no whole number", key));
  return value.get<std::uint64_t>();
}

std::uint64_t gltf_whole_or_0(const GltfJson& object, const char* key) {
  return object.contains(key) ? gltf_whole(object, key) : 0;
}

GltfComponent gltf_component(const GltfJson& accessor) {
  const std::uint64_t type = gltf_whole(accessor, "componentType");
  for (const GltfComponent known :
       {GltfComponent::int8, GltfComponent::uint8, GltfComponent::int16, GltfComponent::uint16,
        GltfComponent::uint32, GltfComponent::float32})
    if (type == static_cast<std::uint64_t>(known)) return known;
  refuse_gltf(fmt::format("componentType {}; wanted 5120 to 5126", type));
}

double gltf_step(const GltfJson& accessor) {
  const double whole = whole_of(accessor, gltf_component(accessor));
  return whole > 0.0 ? 1.0 / whole : 1.0;
}

std::vector<float> gltf_floats(GltfFile& file, std::uint64_t accessor, std::size_t components) {
  return numbers_of<float>(file, accessor, components);
}

std::vector<std::uint32_t> gltf_indices(GltfFile& file, std::uint64_t accessor) {
  switch (gltf_component(file.root().at("accessors").at(accessor))) {
    case GltfComponent::uint8:
    case GltfComponent::uint16:
    case GltfComponent::uint32:
      return numbers_of<std::uint32_t>(file, accessor, 1);
    default:
      refuse_gltf(fmt::format("accessor {} has no whole numbers from 0 on", accessor));
  }
}

GltfFile::GltfFile(std::string_view bytes, const std::string& path, const BufferFile& buffer_file)
    : bytes_(bytes), path_(path), buffer_file_(buffer_file), json_(bytes), size_(bytes.size()) {
  if (bytes.starts_with("glTF") && bytes.size() >= 20) {
    is_glb_ = true;
    json_ = bytes.substr(20, number_at(bytes, 12));
    const std::size_t next = 20 + json_.size();
    if (bytes.size() >= next + 8 && bytes.substr(next + 4, 4) == std::string_view("BIN\0", 4))
      binary_ = bytes.substr(next + 8, number_at(bytes, next));
  }
  root_ = parsed(json_);
}

std::string_view GltfFile::buffer(std::uint64_t number) {
  const GltfJson& object = root_.at("buffers").at(number);
  const auto uri = object.find("uri");
  if (uri == object.end()) {
    if (number != 0 || !is_glb_) refuse_gltf(fmt::format("buffer {} has no bytes", number));
    return binary_;
  }
  const auto [known, is_new] = buffers_.try_emplace(number);
  if (!is_new) return known->second;
  const auto& text = uri->get_ref<const std::string&>();
  const std::size_t comma = text.starts_with("data:") ? text.find(";base64,") : std::string::npos;
  if (comma != std::string::npos) {
    known->second = from_base64(std::string_view(text).substr(comma + 8));
  } else if (auto content = buffer_file_(text)) {
    known->second = std::move(*content);
    size_ += known->second.size();
  } else {
    refuse_gltf(fmt::format("buffer '{}' is not read", text.substr(0, 60)));
  }
  return known->second;
}

std::string_view GltfFile::view(std::uint64_t number) {
  const GltfJson& object = root_.at("bufferViews").at(number);
  const std::string_view bytes = buffer(gltf_whole(object, "buffer"));
  const std::uint64_t begin = gltf_whole_or_0(object, "byteOffset");
  const std::uint64_t length = gltf_whole(object, "byteLength");
  if (begin > bytes.size() || length > bytes.size() - begin)
    refuse_gltf(
        fmt::format("bytes {} to {} of a buffer of {}", begin, begin + length, bytes.size()));
  return bytes.substr(begin, length);
}

void GltfFile::declare(std::uint64_t elements, std::string_view what) {
  const std::uint64_t most = kDeclared + kDeclaredPerByte * size_;
  declared_ = elements > most ? elements : declared_ + elements;
  if (declared_ > most)
    refuse_gltf(
        fmt::format("{} {} are declared, too many for a file of {} bytes", declared_, what, size_));
}

std::size_t GltfFile::add_accessor(std::string_view bytes, GltfComponent component,
                                   std::size_t count, const char* type) {
  GltfJson &buffers = root_["buffers"], &views = root_["bufferViews"],
           &accessors = root_["accessors"];
  accessors.push_back({{"bufferView", views.size()},
                       {"componentType", static_cast<std::uint64_t>(component)},
                       {"count", count},
                       {"type", type}});
  views.push_back({{"buffer", buffers.size()}, {"byteLength", bytes.size()}});
  buffers.push_back({{"byteLength", bytes.size()},
                     {"uri", "data:application/octet-stream;base64," + to_base64(bytes)}});
  return accessors.size() - 1;
}

std::string GltfFile::written() const {
  std::string json = root_.dump(-1, ' ', false, GltfJson::error_handler_t::replace);
  if (!is_glb_) return json;
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t size = 20 + json.size() + (binary_.empty() ? 0 : 8 + binary_.size());
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Error(
        fmt::format("{}: without its compression it has more than 4 GB; reduce the mesh", path_));
  std::string out = "glTF";
  const auto put = [&](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    out.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  put(2), put(size), put(json.size());
  out += "JSON" + json;
  if (!binary_.empty()) {
    put(binary_.size());
    out += std::string_view("BIN\0", 4);
    out += binary_;
  }
  return out;
}

}  // namespace road
