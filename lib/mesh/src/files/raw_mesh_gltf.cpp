// What assimp does not know of glTF: extensions, integers for coordinates, sparse accessors.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "base/one_line.h"
#include "base/text_lines.h"
#include "gltf_file.h"
#include "mesh/error.h"
#include "raw_mesh.h"

namespace road {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
// What tells nothing of where a surface lies, or is read here.
constexpr std::string_view kFine[] = {"KHR_draco_mesh_compression",
                                      "KHR_mesh_quantization",
                                      kInstancing,
                                      "KHR_animation_pointer",
                                      "KHR_binary_glTF",
                                      "KHR_techniques_webgl",
                                      "KHR_xmp",
                                      "KHR_xmp_json_ld",
                                      "FB_ngon_encoding",
                                      "MSFT_lod"};
constexpr std::string_view kFineKinds[] = {"_materials_", "_texture_", "_lights_",
                                           "_packing_",   "_metadata", "_features"};
// Before the name of a node that NodePlacements know; then its number, and again.
constexpr char kMark = '\x01';

bool is_fine(std::string_view extension) {
  return std::find(std::begin(kFine), std::end(kFine), extension) != std::end(kFine) ||
         std::any_of(std::begin(kFineKinds), std::end(kFineKinds), [&](std::string_view kind) {
           return extension.find(kind) != std::string_view::npos;
         });
}

/// A file that needs more than is read would be read wrongly.
void check_required(const GltfFile& file) {
  const auto required = file.root().find("extensionsRequired");
  if (required == file.root().end() || !required->is_array()) return;
  std::string names;
  bool is_meshopt = false;
  for (const GltfJson& name : *required) {
    if (!name.is_string() || is_fine(name.get_ref<const std::string&>())) continue;
    const auto& text = name.get_ref<const std::string&>();
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", text.substr(0, 80));
    is_meshopt = is_meshopt || text.find("_meshopt_compression") != std::string::npos;
  }
  if (names.empty()) return;
  throw Error(fmt::format(
      "{}: this glTF requires {}, which is not read; export it again without that extension{}",
      file.path(), names, is_meshopt ? " (gltfpack: without -c and -cc)" : ""));
}

class PlainMeshes {
 public:
  explicit PlainMeshes(GltfFile& file) : file_(file) {}

  /// Of a primitive. Throws UnusableGltf, or an exception of GltfJson.
  void make_plain(GltfJson& primitive) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->contains("POSITION")) return;
    const std::uint64_t positions = gltf_whole(*attributes, "POSITION");
    const GltfComponent type = gltf_component(file_.root().at("accessors").at(positions));
    bool is_plain = type == GltfComponent::float32;
    for (const auto& [name, number] : attributes->items())
      is_plain = is_plain && lies_in_a_view(gltf_whole(*attributes, name.c_str()));
    if (!is_plain) {
      if (type != GltfComponent::float32)
        step_ = std::max(step_, gltf_step(file_.root().at("accessors").at(positions)));
      // Normals and places on textures go: nobody asks for them.
      primitive.erase("targets");
      const std::uint64_t plain = plain_positions(positions);
      primitive["attributes"] = {{"POSITION", plain}};
      changed_ = true;
    }
    if (!primitive.contains("indices")) return;
    const std::uint64_t indices = gltf_whole(primitive, "indices");
    if (lies_in_a_view(indices)) return;
    primitive["indices"] = plain_indices(indices);
    changed_ = true;
  }

  /// The coarsest step of the coordinates since the last call, 0 for float32.
  double take_step() { return std::exchange(step_, 0.0); }
  bool changed() const { return changed_; }

 private:
  bool lies_in_a_view(std::uint64_t number) const {
    const GltfJson& accessor = file_.root().at("accessors").at(number);
    return accessor.contains("bufferView") && !accessor.contains("sparse");
  }
  std::uint64_t plain_positions(std::uint64_t number) {
    const auto [known, is_new] = positions_.try_emplace(number);
    if (is_new)
      known->second = add(gltf_floats(file_, number, 3), GltfComponent::float32, "VEC3", 3);
    return known->second;
  }
  std::uint64_t plain_indices(std::uint64_t number) {
    const auto [known, is_new] = indices_.try_emplace(number);
    if (is_new)
      known->second = add(gltf_indices(file_, number), GltfComponent::uint32, "SCALAR", 1);
    return known->second;
  }
  template <class T>
  std::uint64_t add(const std::vector<T>& values, GltfComponent component, const char* type,
                    std::size_t components) {
    return file_.add_accessor(
        {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)}, component,
        values.size() / components, type);
  }

  GltfFile& file_;
  std::map<std::uint64_t, std::uint64_t> positions_, indices_;  ///< accessor -> the plain one
  double step_ = 0.0;
  bool changed_ = false;
};

/// Where a node shows its mesh, in its own frame.
std::vector<Eigen::Matrix4d> instances_of(GltfFile& file, const GltfJson& extension) {
  const GltfJson& attributes = extension.at("attributes");
  std::optional<std::uint64_t> count;
  for (const auto& [name, number] : attributes.items()) {
    const std::uint64_t its =
        gltf_whole(file.root().at("accessors").at(gltf_whole(attributes, name.c_str())), "count");
    if (count && *count != its)
      throw UnusableGltf(fmt::format("{} instances by one attribute, {} by another", *count, its));
    count = its;
  }
  if (!count) throw UnusableGltf("no attribute says how many");
  file.declare(*count, "instances");
  std::vector<Eigen::Matrix4d> out(*count, Eigen::Matrix4d::Identity());
  const auto numbers = [&](const char* name, std::size_t components) {
    return attributes.contains(name) ? gltf_floats(file, gltf_whole(attributes, name), components)
                                     : std::vector<float>();
  };
  const std::vector<float> places = numbers("TRANSLATION", 3), turns = numbers("ROTATION", 4),
                           scales = numbers("SCALE", 3);
  for (std::size_t i = 0; i < out.size(); ++i) {
    auto linear = out[i].topLeftCorner<3, 3>();
    if (!turns.empty()) {
      const float* q = &turns[4 * i];  // x, y, z, w
      linear = Eigen::Quaternionf(q[3], q[0], q[1], q[2]).cast<double>().normalized().matrix();
    }
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t k = 3 * i + static_cast<std::size_t>(axis);
      if (!scales.empty()) linear.col(axis) *= static_cast<double>(scales[k]);
      if (!places.empty()) out[i](axis, 3) = static_cast<double>(places[k]);
    }
  }
  return out;
}

std::string described(const GltfJson& node, std::size_t number) {
  const auto name = node.find("name");
  return name == node.end() || !name->is_string()
             ? fmt::format("node {}", number)
             : fmt::format("node {} ('{}')", number,
                           name->get_ref<const std::string&>().substr(0, 80));
}

/// Gives the coarsest step of the coordinates of each mesh, 0 for float32.
std::vector<double> make_meshes_plain(GltfFile& file, bool& changed) {
  PlainMeshes plain(file);
  GltfJson& meshes = file.root()["meshes"];
  std::vector<double> steps(meshes.size(), 0.0);
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    if (!meshes[m].is_object()) continue;
    const auto primitives = meshes[m].find("primitives");
    if (primitives == meshes[m].end() || !primitives->is_array()) continue;
    for (GltfJson& primitive : *primitives) {
      if (!primitive.is_object()) continue;
      const bool is_packed = has_draco(primitive);
      const auto fail = [&](const char* why) {
        throw Error(fmt::format("{}: mesh {} {}cannot be read: {}; export it again{}", file.path(),
                                m, is_packed ? "is compressed by Draco and " : "",
                                base::one_line(why), is_packed ? ", or without compression" : ""));
      };
      try {
        if (is_packed) unpack_draco(file, primitive), changed = true;
        plain.make_plain(primitive);
      } catch (const GltfJson::exception& error) {
        fail(error.what());
      } catch (const UnusableGltf& error) {
        fail(error.what());
      }
    }
    steps[m] = plain.take_step();
  }
  changed = changed || plain.changed();
  return steps;
}

/// Names those nodes anew of which more is to be known than assimp keeps.
std::vector<NodePlacement> placements_of(GltfFile& file, const std::vector<double>& steps) {
  std::vector<NodePlacement> placements;
  const auto nodes = file.root().find("nodes");
  if (nodes == file.root().end() || !nodes->is_array()) return placements;
  for (std::size_t n = 0; n < nodes->size(); ++n) {
    GltfJson& node = (*nodes)[n];
    if (!node.is_object() || !node.contains("mesh")) continue;
    const auto fail = [&](const char* why) {
      throw Error(fmt::format(
          "{}: {} shows its mesh many times ({}), but where cannot be read: {}; export it again, "
          "or with every copy as a mesh of its own",
          file.path(), described(node, n), kInstancing, base::one_line(why)));
    };
    try {
      NodePlacement placement;
      const auto extensions = node.find("extensions");
      const bool is_shown_often = extensions != node.end() && extensions->contains(kInstancing);
      if (is_shown_often) placement.instances = instances_of(file, (*extensions)[kInstancing]);
      const std::uint64_t mesh =
          node["mesh"].is_number_unsigned() ? gltf_whole(node, "mesh") : steps.size();
      if (mesh < steps.size()) placement.step = steps[mesh];
      if (!is_shown_often && placement.step == 0.0) continue;
      const std::string name = node.value("name", std::string());
      node["name"] = fmt::format("{}{}{}{}", kMark, placements.size(), kMark, name);
      placements.push_back(std::move(placement));
    } catch (const GltfJson::exception& error) {
      fail(error.what());
    } catch (const UnusableGltf& error) {
      fail(error.what());
    }
  }
  return placements;
}

/// The extensions are not in it any more.
void forget_extensions(GltfJson& root) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    const auto names = root.find(list);
    if (names == root.end() || !names->is_array()) continue;
    std::erase(names->get_ref<GltfJson::array_t&>(), "KHR_draco_mesh_compression");
    if (names->empty()) root.erase(names);  // the standard allows no empty one
  }
}

}  // namespace

std::optional<PlainGltf> plain_gltf(std::string_view bytes, const std::string& path,
                                    const BufferFile& buffer_file) {
  GltfFile file(bytes, path, buffer_file);
  if (!file.root().is_object()) return std::nullopt;
  check_required(file);
  const auto meshes = file.root().find("meshes");
  if (meshes == file.root().end() || !meshes->is_array()) return std::nullopt;  // glTF 1 has names
  bool changed = false;
  const std::vector<double> steps = make_meshes_plain(file, changed);
  std::vector<NodePlacement> placements = placements_of(file, steps);
  if (!changed && placements.empty()) return std::nullopt;
  forget_extensions(file.root());
  return PlainGltf{file.written(), std::move(placements)};
}

const NodePlacement* take_placement(const std::vector<NodePlacement>& placements,
                                    std::string& name) {
  if (placements.empty() || name.empty() || name[0] != kMark) return nullptr;
  const std::size_t end = name.find(kMark, 1);
  const auto number = base::to_number<std::size_t>(std::string_view(name).substr(1, end - 1));
  if (end == std::string::npos || !number || *number >= placements.size()) return nullptr;
  name.erase(0, end + 1);
  return &placements[*number];
}

}  // namespace road
