#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "base/text_lines.h"
#include "mesh/error.h"
#include "raw_mesh.h"
#include "text_vertices.h"

namespace road {
namespace {

// Grammar of AC3D: "AC3Dx", MATERIAL lines, then OBJECTs. An OBJECT ends with "kids N" and N
// OBJECTs follow.
void append_line(std::string& text, std::string_view line) {
  text.append(line);
  text.push_back('\n');
}

/// Checks a file line by line and keeps what its mesh needs.
class Ac3dReader {
 public:
  Ac3dReader(std::string_view bytes, const std::string& path) : path_(path), lines_(bytes) {
    text_.reserve(bytes.size());
  }

  void read() {
    if (!lines_.next(line_) || !line_.starts_with("AC3D")) {
      throw Error(fmt::format(
          "{}:1: '{}': wanted 'AC3D...' in the first line of an .ac or .acc file; give a mesh file",
          path_, line_.substr(0, 60)));
    }
    append_line(text_, line_);
    while (lines_.next(line_)) {
      std::string_view rest = line_;
      const std::string_view word = base::take_word(rest);
      if (in_surface_ && (word == "SURF" || word == "kids" || word == "OBJECT"))
        throw malformed("'refs COUNT' of the surface before it");
      if (word == "texture")
        take_texture(rest);
      else if (word == "data")
        pass_data(rest);
      else if (word == "numvert")
        take_vertices(rest);
      else if (word == "refs")
        take_corners(rest);
      else {
        if (word == "OBJECT") begin_object();
        if (word == "loc" || word == "rot") check_place(word, rest);
        if (word == "SURF") in_surface_ = true;
        if (word == "kids") end_object(rest);
        append_line(text_, line_);
      }
    }
    if (in_object_) throw truncated("an OBJECT");
  }

  /// The text with the vertices about an origin near them.
  LocalText localised() {
    LocalText local;
    // Exporters in use count the kids of nested groups wrongly, so this alone is no truncation.
    if (!kids_left_.empty()) {
      local.remarks.push_back(
          fmt::format("a group announces {} objects more than the file holds", kids_left_.back()));
    }
    local.float32_quantised = bounds_.float32_quantised();
    if (!transformed_) local.origin = local_origin(bounds_.lowest, bounds_.highest);
    if (local.origin.isZero()) {
      local.text = std::move(text_);
      return local;
    }
    shift_vertices(local);
    return local;
  }

 private:
  Error truncated(std::string_view where) const {
    return Error(
        fmt::format("{}:{}: the file is truncated: it ends inside {}; copy or export it again",
                    path_, lines_.number(), where));
  }
  Error malformed(std::string_view wanted) const {
    return Error(fmt::format("{}:{}: '{}': wanted {}; copy or export the mesh again", path_,
                             lines_.number(), line_.substr(0, 60), wanted));
  }
  std::uint64_t count_after(std::string_view rest, std::string_view wanted) const {
    const auto count = base::to_number<std::uint64_t>(base::take_word(rest));
    if (!count) throw malformed(wanted);
    return *count;
  }

  void begin_object() {
    if (in_object_) throw malformed("'kids N' before the next OBJECT");
    if (kids_left_.size() >= kMaxDepth) throw malformed("groups nested less than 256 deep");
    in_object_ = true;
    has_texture_ = false;
    vertices_ = 0;
  }

  void take_texture(std::string_view rest) {
    // "NAME" base | "NAME" alone | "NAME" tiled|skids|shad: only the base layer says what the
    // object is.
    const std::size_t quote = rest.rfind('"');
    std::string_view suffix = quote == std::string_view::npos ? rest : rest.substr(quote + 1);
    if (quote == std::string_view::npos) base::take_word(suffix);
    const std::string_view layer = base::take_word(suffix);
    if (has_texture_ || (!layer.empty() && layer != "base")) return;
    has_texture_ = true;
    if (quote == std::string_view::npos) {
      append_line(text_, line_);
    } else {
      append_line(text_, line_.substr(0, line_.size() - (rest.size() - quote - 1)));
    }
  }

  void pass_data(std::string_view rest) {
    // A free text of N bytes follows; nothing here needs it.
    std::uint64_t left = count_after(rest, "'data BYTES'");
    while (true) {
      if (!lines_.next(line_)) throw truncated("a 'data' text");
      if (left <= line_.size() + 1) break;
      left -= line_.size() + 1;
    }
  }

  void check_place(std::string_view word, std::string_view rest) {
    const bool location = word == "loc";
    for (int i = 0; i < (location ? 3 : 9); ++i) {
      const auto value = base::to_number<double>(base::take_word(rest));
      if (!value || !std::isfinite(*value))
        throw malformed(location ? "'loc x y z'" : "'rot' and nine numbers");
      const double identity = !location && i % 4 == 0 ? 1.0 : 0.0;
      transformed_ = transformed_ || *value != identity;
    }
  }

  void take_vertices(std::string_view rest) {
    vertices_ = count_after(rest, "'numvert COUNT'");
    append_line(text_, line_);
    for (std::uint64_t i = 0; i < vertices_; ++i) {
      if (!lines_.next(line_))
        throw truncated(fmt::format("{} vertices of which it holds {}", vertices_, i));
      rest = line_;
      bounds_.add(take_vertex(rest, path_, lines_.number(), line_));
      append_line(text_, line_);
    }
  }

  void take_corners(std::string_view rest) {
    const std::uint64_t refs = count_after(rest, "'refs COUNT'");
    if (refs == 0) throw malformed("a surface of at least one corner");
    in_surface_ = false;
    append_line(text_, line_);
    for (std::uint64_t i = 0; i < refs; ++i) {
      if (!lines_.next(line_))
        throw truncated(fmt::format("a surface of {} corners of which it holds {}", refs, i));
      rest = line_;
      const auto index = base::to_number<std::uint64_t>(base::take_word(rest));
      if (!index || *index >= vertices_) {
        throw malformed(fmt::format("the number of one of the object's {} vertices", vertices_));
      }
      append_line(text_, line_);
    }
  }

  void end_object(std::string_view rest) {
    if (!in_object_) throw malformed("an OBJECT before 'kids'");
    in_object_ = false;
    kids_left_.push_back(count_after(rest, "'kids COUNT'"));
    while (!kids_left_.empty() && kids_left_.back() == 0) {
      kids_left_.pop_back();
      if (!kids_left_.empty()) --kids_left_.back();
    }
  }

  void shift_vertices(LocalText& local) const {
    std::string_view line;
    base::Lines kept(text_);
    local.text.reserve(text_.size());
    while (kept.next(line)) {
      append_line(local.text, line);
      std::string_view rest = line;
      if (base::take_word(rest) != "numvert") continue;
      const std::uint64_t count = base::to_number<std::uint64_t>(base::take_word(rest)).value_or(0);
      for (std::uint64_t i = 0; i < count && kept.next(line); ++i) {
        rest = line;
        const Eigen::Vector3d vertex = take_vertex(rest, path_, 0, line) - local.origin;
        fmt::format_to(std::back_inserter(local.text), "{:.9f} {:.9f} {:.9f}{}\n", vertex.x(),
                       vertex.y(), vertex.z(), rest);
      }
    }
  }

  static constexpr std::size_t kMaxDepth = 256;
  const std::string& path_;
  base::Lines lines_;
  std::string_view line_;
  TextBounds bounds_;
  bool transformed_ =
      false;  ///< loc or rot: an origin cannot be subtracted from the vertices alone
  std::string text_;
  std::vector<std::uint64_t> kids_left_;  ///< per open object
  bool in_object_ = false;
  bool in_surface_ = false;  ///< its corners are to come; assimp leaves memory unset for a surface
                             ///< without any
  bool has_texture_ = false;
  std::uint64_t vertices_ = 0;
};

}  // namespace

Eigen::Vector3d local_origin(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest) {
  const double largest = std::max(lowest.cwiseAbs().maxCoeff(), highest.cwiseAbs().maxCoeff());
  if (!(largest > 1000.0)) return Eigen::Vector3d::Zero();
  return ((lowest + highest) / 20.0).array().round() * 10.0;
}

LocalText localise_ac3d(std::string_view bytes, const std::string& path) {
  Ac3dReader reader(bytes, path);
  reader.read();
  return reader.localised();
}

}  // namespace road
