#include "clean_cache.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <limits>
#include <type_traits>

#include "base/error.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/write_file.h"

namespace road {

namespace {

constexpr std::size_t kLargestCache = 4'000'000'000;
constexpr std::size_t kHashDigits = 64;

/// Puts values one behind the other.
struct Writer {
  std::string bytes;

  template <typename T>
  requires std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>
  void operator()(const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void operator()(const std::optional<double>& value) {
    (*this)(value.has_value()), (*this)(value.value_or(0.0));
  }
  void operator()(const std::string& text) { (*this)(text.size()), bytes += text; }
  void operator()(const Eigen::Vector3d& v) {
    bytes.append(reinterpret_cast<const char*>(v.data()), 3 * sizeof(double));
  }
  void operator()(const MeshObject& object) {
    (*this)(object.name), (*this)(object.material), (*this)(object.texture);
    (*this)(object.colour.has_value());
    for (const float part : object.colour.value_or(LinearColour{})) (*this)(part);
  }
  void operator()(const std::optional<Guide>& guide) {
    (*this)(guide.has_value());
    if (guide) (*this)(guide->points_m), (*this)(guide->closed);
  }
  template <typename T>
  void operator()(const std::vector<T>& values) {
    (*this)(values.size());
    for (const T& value : values) (*this)(value);
  }
  void operator()(const std::map<std::string, std::size_t>& counts) {
    (*this)(counts.size());
    for (const auto& [name, count] : counts) (*this)(name), (*this)(count);
  }
};

/// Takes them off again; `good` turns false, and values stay what they are, where bytes are
/// missing.
struct Reader {
  std::string_view bytes;
  bool good = true;

  void take(void* to, std::size_t count) {
    good = good && bytes.size() >= count;
    if (!good) return;
    std::memcpy(to, bytes.data(), count);
    bytes.remove_prefix(count);
  }
  template <typename T>
  requires std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>
  void operator()(T& value) { take(&value, sizeof value); }
  void operator()(std::optional<double>& value) {
    bool has_value = false;
    double number = 0.0;
    (*this)(has_value), (*this)(number);
    value = has_value ? std::optional(number) : std::nullopt;
  }
  /// A count of things that take at least one byte each: never more than there are bytes.
  std::size_t count() {
    std::size_t n = 0;
    (*this)(n);
    good = good && n <= bytes.size();
    return good ? n : 0;
  }
  void operator()(std::string& text) {
    text.resize(count());
    take(text.data(), text.size());
  }
  void operator()(Eigen::Vector3d& v) { take(v.data(), 3 * sizeof(double)); }
  void operator()(MeshObject& object) {
    (*this)(object.name), (*this)(object.material), (*this)(object.texture);
    bool has_colour = false;
    LinearColour colour{};
    (*this)(has_colour);
    for (float& part : colour) (*this)(part);
    object.colour = has_colour ? std::optional(colour) : std::nullopt;
  }
  void operator()(std::optional<Guide>& guide) {
    bool has_guide = false;
    (*this)(has_guide);
    if (!has_guide) return guide.reset();
    guide.emplace();
    (*this)(guide->points_m), (*this)(guide->closed);
  }
  template <typename T>
  void operator()(std::vector<T>& values) {
    const std::size_t n = count();
    values.clear();
    for (std::size_t i = 0; i < n && good; ++i) (*this)(values.emplace_back());
  }
  void operator()(std::map<std::string, std::size_t>& counts) {
    const std::size_t n = count();
    for (std::size_t i = 0; i < n && good; ++i) {
      std::string name;
      (*this)(name);
      (*this)(counts[name]);
    }
  }
};

/// Every value of a cleaned mesh, for both directions.
template <typename Archive, typename Value>
void each(Archive& a, Value& cleaned) {
  auto& [road, r] = cleaned;
  a(road.mesh.origin_m), a(road.mesh.vertices_m), a(road.mesh.triangles),
      a(road.mesh.object_of_triangle), a(road.mesh.objects);
  a(road.class_of_triangle), a(road.guide);
  a(r.triangles_in), a(r.triangles_kept), a(r.dropped), a(r.kept), a(r.vertices_welded),
      a(r.weld_tolerance_m), a(r.vertices_snapped);
  a(r.snap_tolerance_m), a(r.faces_turned), a(r.bridging_triangles), a(r.bridged_m),
      a(r.holes_closed), a(r.holes_closed_m2), a(r.non_manifold_edges), a(r.boundary_loops),
      a(r.components);
  a(r.by_names), a(r.by_colour), a(r.by_guide), a(r.doubts), a(r.road_agreement),
      a(r.class_of_triangle), a(r.remarks);
}

bool is_whole(const Mesh& mesh, const std::vector<SurfaceClass>& class_of_triangle) {
  if (mesh.object_of_triangle.size() != mesh.triangles.size() ||
      class_of_triangle.size() != mesh.triangles.size())
    return false;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle)
      if (corner >= mesh.vertices_m.size()) return false;
  for (const std::uint32_t object : mesh.object_of_triangle)
    if (object >= mesh.objects.size()) return false;
  return true;
}

}  // namespace

std::string clean_key(const Recipe& recipe, const std::optional<Guide>& guide,
                      const TiltAndScale& tilt_and_scale, const std::string& program,
                      const std::vector<InputFile>& mesh_files) {
  std::string key = program + "\n";
  for (const InputFile& file : mesh_files)
    key += fmt::format("{} {} {}\n", file.role, file.path, file.sha256);
  if (guide) {
    key += guide->closed ? "closed guide" : "open guide";
    for (const Eigen::Vector3d& p : guide->points_m)
      key += fmt::format(" {},{},{}", p.x(), p.y(), p.z());
    key += "\n";
  }
  if (!tilt_and_scale.is_identity()) {
    for (const double value : tilt_and_scale.about_m) key += fmt::format("about {}\n", value);
    for (const double value : tilt_and_scale.linear.reshaped())
      key += fmt::format("linear {}\n", value);
  }
  for (const RecipeKey& k : recipe_keys())
    if (k.stage == "read" || k.stage == "clean")
      key += fmt::format("{} {}\n", k.name, k.show(recipe));
  for (const NameRule& rule : recipe.clean.name_rules)
    key += fmt::format("rule {} {} {} {}\n", static_cast<int>(rule.field), rule.pattern,
                       to_string(rule.surface_class), rule.convention);
  return key;
}

void write_clean_cache(const Cleaned& cleaned, const std::string& key, const std::string& path) {
  Writer writer;
  writer(key);
  each(writer, cleaned);
  const std::string hash = base::sha256(writer.bytes);
  writer.bytes += hash;
  base::write_file(path, writer.bytes);
}

std::optional<Cleaned> read_clean_cache(const std::string& key, const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const auto file = base::try_read_file(path, kLargestCache);
  if (!file) return std::nullopt;  // it can be made again
  const std::string& bytes = *file;
  if (bytes.size() < kHashDigits) return std::nullopt;
  const std::string_view body = std::string_view(bytes).substr(0, bytes.size() - kHashDigits);
  if (bytes.substr(body.size()) != base::sha256(body)) return std::nullopt;
  Reader reader{body};
  std::string key_there;
  reader(key_there);
  if (!reader.good || key_there != key) return std::nullopt;
  Cleaned cleaned;
  each(reader, cleaned);
  if (!reader.good || !reader.bytes.empty() ||
      !is_whole(cleaned.road.mesh, cleaned.road.class_of_triangle))
    return std::nullopt;
  return cleaned;
}

}  // namespace road
