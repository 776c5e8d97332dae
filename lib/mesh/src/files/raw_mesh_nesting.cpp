// How deep a file is nested, found without going down.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "base/ending.h"
#include "base/json_text.h"
#include "mesh/error.h"
#include "raw_mesh.h"

namespace road {
namespace {

// Groups in groups as people make them: a dozen; chains of joints: some hundred.
constexpr std::size_t kMaxDepth = 1000;
// Parts that are shown again and again, each of parts that are: a billion costs a few hundred
// bytes.
constexpr std::uint64_t kMaxVisits = 10'000'000;

[[noreturn]] void refuse_depth(const std::string& path, std::string_view what) {
  throw Error(fmt::format(
      "{}: {} more than {} deep; such a file is damaged or was made to do harm: export it again",
      path, what, kMaxDepth));
}

/// `open` and `close` outside of "quoted" texts, in which `escape` takes the next character along.
void check_brackets(std::string_view text, std::string_view open, std::string_view close,
                    char escape, const std::string& path, std::string_view what) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted) {
      if (c == escape) ++i;
      continue;
    }
    if (open.find(c) != std::string_view::npos && ++depth > kMaxDepth) refuse_depth(path, what);
    if (close.find(c) != std::string_view::npos && depth > 0) --depth;
  }
}

void check_xml(std::string_view text, const std::string& path) {
  std::size_t depth = 0;
  const auto skip_to = [&](std::string_view end) {
    const std::size_t at = text.find(end);
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + end.size());
  };
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<')) {
    text.remove_prefix(at);
    if (text.starts_with("<!--")) {
      skip_to("-->");
    } else if (text.starts_with("<![CDATA[")) {
      skip_to("]]>");
    } else if (text.starts_with("<?")) {
      skip_to("?>");
    } else if (text.starts_with("</")) {
      if (depth > 0) --depth;
      skip_to(">");
    } else if (text.starts_with("<!")) {
      skip_to(">");
    } else {
      char quote = 0;
      std::size_t end = 1;
      for (; end < text.size() && (quote != 0 || text[end] != '>'); ++end) {
        if (quote != 0) {
          if (text[end] == quote) quote = 0;
        } else if (text[end] == '"' || text[end] == '\'') {
          quote = text[end];
        }
      }
      if (text[end - 1] != '/' && ++depth > kMaxDepth) refuse_depth(path, "elements are nested");
      text.remove_prefix(std::min(end + 1, text.size()));
    }
  }
}

/// The nodes of a glTF form trees; a chain of them is as good as nested brackets, and a node with
/// two parents (which the standard forbids) is visited twice.
void check_gltf_nodes(const nlohmann::json& root, const std::string& path) {
  using Json = nlohmann::json;
  if (!root.is_object() || !root.contains("nodes")) return;
  const Json& nodes = root["nodes"];
  std::vector<const Json*> all;
  std::unordered_map<std::string, std::size_t>
      by_name;  // glTF 1 names its nodes, glTF 2 numbers them
  for (const auto& [name, node] : nodes.items()) {
    if (nodes.is_object()) by_name.emplace(name, all.size());
    all.push_back(&node);
  }
  const auto index_of = [&](const Json& reference) {
    if (reference.is_number_unsigned())
      return static_cast<std::size_t>(
          std::min<std::uint64_t>(reference.get<std::uint64_t>(), all.size()));
    const auto found =
        reference.is_string() ? by_name.find(reference.get<std::string>()) : by_name.end();
    return found == by_name.end() ? all.size() : found->second;
  };
  const auto children_of = [&](std::size_t node) -> const Json::array_t& {
    static const Json::array_t none;
    if (!all[node]->is_object()) return none;
    const auto found = all[node]->find("children");
    return found == all[node]->end() || !found->is_array() ? none
                                                           : found->get_ref<const Json::array_t&>();
  };
  enum class State : std::uint8_t { unseen, open, done };
  struct Seen {
    State state = State::unseen;
    std::size_t depth = 1;
    std::uint64_t visits = 1;
  };
  std::vector<Seen> seen(all.size());
  struct Step {
    std::size_t node, next_child;
  };
  std::vector<Step> stack;
  for (std::size_t start = 0; start < all.size(); ++start) {
    if (seen[start].state != State::unseen) continue;
    stack.push_back({start, 0});
    while (!stack.empty()) {
      Step& step = stack.back();
      Seen& here = seen[step.node];
      here.state = State::open;
      const auto& children = children_of(step.node);
      if (step.next_child == children.size()) {
        here.state = State::done;
        stack.pop_back();
        continue;
      }
      const std::size_t child = index_of(children[step.next_child]);
      if (child >= all.size()) {
        ++step.next_child;
      } else if (seen[child].state == State::open) {
        throw Error(
            fmt::format("{}: node {} is a child of itself; export the mesh again", path, child));
      } else if (seen[child].state == State::unseen) {
        stack.push_back({child, 0});
      } else {
        here.depth = std::max(here.depth, seen[child].depth + 1);
        here.visits += seen[child].visits;
        ++step.next_child;
        if (here.depth > kMaxDepth) refuse_depth(path, "nodes are nested");
        if (here.visits > kMaxVisits)
          throw Error(fmt::format(
              "{}: nodes that are children of several make more than {} of them; export "
              "the mesh again",
              path, kMaxVisits));
      }
    }
  }
}

void check_gltf(std::string_view text, const std::string& path) {
  check_brackets(text, "[{", "]}", '\\', path, "arrays and objects are nested");
  // Names in other encodings than UTF-8 are no reason to refuse a mesh.
  std::string ascii(text);
  std::replace_if(
      ascii.begin(), ascii.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; },
      '?');
  const auto root = base::parse_json<nlohmann::json>(ascii, false);
  if (!root.is_discarded()) check_gltf_nodes(root, path);
}

}  // namespace

void check_nesting(std::string_view bytes, const std::string& path) {
  const std::string extension = base::ending_of(path);
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  if (bytes.starts_with("glTF") && bytes.size() >= 20) {
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, sizeof length);
    check_gltf(bytes.substr(20, length), path);
    return;
  }
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return;
  if (extension == ".gltf" || extension == ".glb") {
    check_gltf(bytes, path);
  } else if (bytes[first] == '<') {
    check_xml(bytes, path);
  } else if (bytes.substr(0, 1000).find('\0') == std::string_view::npos &&
             (extension == ".x" || extension == ".fbx" || extension == ".ase" ||
              extension == ".wrl")) {
    check_brackets(bytes, "{", "}", '\0', path, "blocks are nested");
  }
}

}  // namespace road
