#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "base/text_lines.h"
#include "raw_mesh.h"
#include "road/error.h"
#include "text_vertices.h"

namespace road {
namespace {

void append_line(std::string& text, std::string_view line) {
  text.append(line);
  text.push_back('\n');
}

}  // namespace

Eigen::Vector3d local_origin(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest) {
  const double largest = std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff());
  if (!(largest > 1000.0)) return Eigen::Vector3d::Zero();
  return ((lowest + highest) / 20.0).array().round() * 10.0;
}

LocalText localise_ac3d(std::string_view bytes, const std::string& path) {
  // Grammar: "AC3Dx", MATERIAL lines, then OBJECTs. An OBJECT ends with "kids N" and N OBJECTs
  // follow.
  constexpr std::size_t kMaxDepth = 256;
  base::Lines lines(bytes);
  std::string_view line;
  if (!lines.next(line) || !line.starts_with("AC3D")) {
    throw Error(fmt::format(
        "{}:1: '{}': wanted 'AC3D...' in the first line of an .ac or .acc file; give a mesh file",
        path, line.substr(0, 60)));
  }
  const auto truncated = [&](std::string_view where) {
    return Error(
        fmt::format("{}:{}: the file is truncated: it ends inside {}; copy or export it again",
                    path, lines.number(), where));
  };
  const auto malformed = [&](std::string_view wanted) {
    return Error(fmt::format("{}:{}: '{}': wanted {}; copy or export the mesh again", path,
                             lines.number(), line.substr(0, 60), wanted));
  };
  const auto count_after = [&](std::string_view rest, std::string_view wanted) {
    const auto count = base::to_number<std::uint64_t>(base::take_word(rest));
    if (!count) throw malformed(wanted);
    return *count;
  };

  TextBounds bounds;
  bool transformed = false;  // loc or rot: an origin cannot be subtracted from the vertices alone
  std::string text;
  text.reserve(bytes.size());
  append_line(text, line);
  std::vector<std::uint64_t> kids_left;  // per open object
  bool in_object = false;
  bool in_surface =
      false;  // its corners are to come; assimp leaves memory unset for a surface without any
  bool has_texture = false;
  std::uint64_t vertices = 0;
  while (lines.next(line)) {
    std::string_view rest = line;
    const std::string_view word = base::take_word(rest);
    if (in_surface && (word == "SURF" || word == "kids" || word == "OBJECT"))
      throw malformed("'refs COUNT' of the surface before it");
    if (word == "OBJECT") {
      if (in_object) throw malformed("'kids N' before the next OBJECT");
      if (kids_left.size() >= kMaxDepth) throw malformed("groups nested less than 256 deep");
      in_object = true;
      has_texture = false;
      vertices = 0;
    } else if (word == "texture") {
      // "NAME" base | "NAME" alone | "NAME" tiled|skids|shad: only the base layer says what the
      // object is.
      const std::size_t quote = rest.rfind('"');
      std::string_view suffix = quote == std::string_view::npos ? rest : rest.substr(quote + 1);
      if (quote == std::string_view::npos) base::take_word(suffix);
      const std::string_view layer = base::take_word(suffix);
      if (has_texture || (!layer.empty() && layer != "base")) continue;
      has_texture = true;
      if (quote == std::string_view::npos) {
        append_line(text, line);
      } else {
        append_line(text, line.substr(0, line.size() - (rest.size() - quote - 1)));
      }
      continue;
    } else if (word == "data") {
      // A free text of N bytes follows; nothing here needs it.
      std::uint64_t left = count_after(rest, "'data BYTES'");
      while (true) {
        if (!lines.next(line)) throw truncated("a 'data' text");
        if (left <= line.size() + 1) break;
        left -= line.size() + 1;
      }
      continue;
    } else if (word == "loc" || word == "rot") {
      const bool location = word == "loc";
      for (int i = 0; i < (location ? 3 : 9); ++i) {
        const auto value = base::to_number<double>(base::take_word(rest));
        if (!value || !std::isfinite(*value))
          throw malformed(location ? "'loc x y z'" : "'rot' and nine numbers");
        const double identity = !location && i % 4 == 0 ? 1.0 : 0.0;
        transformed = transformed || *value != identity;
      }
    } else if (word == "numvert") {
      vertices = count_after(rest, "'numvert COUNT'");
      append_line(text, line);
      for (std::uint64_t i = 0; i < vertices; ++i) {
        if (!lines.next(line))
          throw truncated(fmt::format("{} vertices of which it holds {}", vertices, i));
        rest = line;
        bounds.add(take_vertex(rest, path, lines.number(), line));
        append_line(text, line);
      }
      continue;
    } else if (word == "SURF") {
      in_surface = true;
    } else if (word == "refs") {
      const std::uint64_t refs = count_after(rest, "'refs COUNT'");
      if (refs == 0) throw malformed("a surface of at least one corner");
      in_surface = false;
      append_line(text, line);
      for (std::uint64_t i = 0; i < refs; ++i) {
        if (!lines.next(line))
          throw truncated(fmt::format("a surface of {} corners of which it holds {}", refs, i));
        rest = line;
        const auto index = base::to_number<std::uint64_t>(base::take_word(rest));
        if (!index || *index >= vertices) {
          throw malformed(fmt::format("the number of one of the object's {} vertices", vertices));
        }
        append_line(text, line);
      }
      continue;
    } else if (word == "kids") {
      if (!in_object) throw malformed("an OBJECT before 'kids'");
      in_object = false;
      kids_left.push_back(count_after(rest, "'kids COUNT'"));
      while (!kids_left.empty() && kids_left.back() == 0) {
        kids_left.pop_back();
        if (!kids_left.empty()) --kids_left.back();
      }
    }
    append_line(text, line);
  }
  if (in_object) throw truncated("an OBJECT");

  LocalText local;
  // Exporters in use count the kids of nested groups wrongly, so this alone is no truncation.
  if (!kids_left.empty()) {
    local.remarks.push_back(
        fmt::format("a group announces {} objects more than the file holds", kids_left.back()));
  }
  local.float32_quantised = bounds.float32_quantised();
  if (!transformed) local.origin = local_origin(bounds.lowest, bounds.highest);
  if (local.origin.isZero()) {
    local.text = std::move(text);
    return local;
  }
  base::Lines kept(text);
  local.text.reserve(text.size());
  while (kept.next(line)) {
    append_line(local.text, line);
    std::string_view rest = line;
    if (base::take_word(rest) != "numvert") continue;
    const std::uint64_t count = base::to_number<std::uint64_t>(base::take_word(rest)).value_or(0);
    for (std::uint64_t i = 0; i < count && kept.next(line); ++i) {
      rest = line;
      const Eigen::Vector3d vertex = take_vertex(rest, path, 0, line) - local.origin;
      fmt::format_to(std::back_inserter(local.text), "{:.9f} {:.9f} {:.9f}{}\n", vertex.x(),
                     vertex.y(), vertex.z(), rest);
    }
  }
  return local;
}

}  // namespace road
