#include "support/torcs_track.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace support {

namespace {

using Values = std::map<std::string, std::string>;

/// Attributes of the sections below "Main Track": its own, and those of each track segment in
/// order.
void scan(const std::string& xml, Values& main, std::vector<Values>& segments) {
  static const std::regex tag("<!--|<(/?)(section|attnum|attstr)\\b([^>]*)>");
  static const std::regex field("([a-z]+)\\s*=\\s*\"([^\"]*)\"");
  std::vector<std::string> path;
  for (auto at = xml.cbegin(); at != xml.cend();) {
    std::smatch match;
    if (!std::regex_search(at, xml.cend(), match, tag)) break;
    if (match[0] == "<!--") {  // std::regex would recurse through a long comment
      const auto end = xml.find("-->", static_cast<std::size_t>(match[0].second - xml.cbegin()));
      at = end == std::string::npos ? xml.cend()
                                    : xml.cbegin() + static_cast<std::ptrdiff_t>(end) + 3;
      continue;
    }
    at = match[0].second;
    const std::string what = match[2], inside = match[3];
    if (match[1].length() > 0) {
      if (what == "section" && !path.empty()) path.pop_back();
      continue;
    }
    Values fields;
    for (std::sregex_iterator i(inside.begin(), inside.end(), field), end; i != end; ++i)
      fields[(*i)[1]] = (*i)[2];
    if (what == "section") {
      if (!inside.empty() && inside.back() == '/') continue;
      path.push_back(fields["name"]);
      if (path.size() == 3 && path[0] == "Main Track" &&
          (path[1] == "Track Segments" || path[1] == "segments"))
        segments.emplace_back();
      continue;
    }
    std::string value = fields["val"];
    if (fields["unit"] == "ft")
      value = std::to_string(std::strtod(value.c_str(), nullptr) * 0.304801);  // TORCS's foot
    if (fields["unit"] == "deg")
      value = std::to_string(std::strtod(value.c_str(), nullptr) * std::numbers::pi / 180.0);
    if (path.size() == 1 && path[0] == "Main Track") main[fields["name"]] = value;
    if (path.size() == 3 && !segments.empty() && path[0] == "Main Track" &&
        (path[1] == "Track Segments" || path[1] == "segments"))
      segments.back()[fields["name"]] = value;
  }
}

double number(const Values& values, const std::string& name, double otherwise) {
  const auto found = values.find(name);
  return found == values.end() ? otherwise : std::strtod(found->second.c_str(), nullptr);
}

}  // namespace

TorcsTrack read_torcs_track(const std::string& xml_path) {
  std::ifstream in(xml_path, std::ios::binary);
  if (!in) throw std::runtime_error(xml_path + ": cannot be opened");
  std::ostringstream text;
  text << in.rdbuf();
  Values main;
  std::vector<Values> segments;
  scan(text.str(), main, segments);
  if (segments.empty()) throw std::runtime_error(xml_path + ": no track segments");

  TorcsTrack track;
  track.width_m = number(main, "width", 15.0);
  const double main_step_m = number(main, "profil steps length", 0.0);
  double heading = 0.0;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  const auto go = [&](double length_m, double curvature_1pm) {
    const auto pieces = std::max(1.0, std::ceil(length_m));
    for (int k = 0; k < static_cast<int>(pieces); ++k) {
      track.centre_m.push_back(at);
      const double step = length_m / pieces, turn = step * curvature_1pm;
      // The chord of an arc.
      const double chord =
          std::abs(turn) > 1e-9 ? 2.0 / curvature_1pm * std::sin(0.5 * turn) : step;
      at += chord * Eigen::Vector2d(std::cos(heading + 0.5 * turn), std::sin(heading + 0.5 * turn));
      heading += turn;
    }
    track.length_m += length_m;
  };
  for (const Values& segment : segments) {
    const auto type = segment.find("type");
    if (type == segment.end()) continue;
    if (type->second == "str") {
      go(number(segment, "lg", 0.0), 0.0);
      continue;
    }
    const double side = type->second == "lft" ? 1.0 : -1.0;
    const double radius = number(segment, "radius", 0.0),
                 end_radius = number(segment, "end radius", radius),
                 arc = number(segment, "arc", 0.0);
    const double length = 0.5 * (radius + end_radius) * arc;
    double steps = number(segment, "profil steps", 1.0);
    const double step_m = number(segment, "profil steps length", main_step_m);
    if (steps == 1.0 && step_m > 0.0) steps = std::max(1.0, std::floor(length / step_m) + 1.0);
    if (radius == end_radius || steps == 1.0) {
      go(radius * arc, side / radius);
      continue;
    }
    double turned = 0.0;
    for (int k = 0; k < static_cast<int>(steps); ++k)
      turned += length / steps / (radius + (end_radius - radius) * k / (steps - 1.0));
    const double piece = length / steps * arc / turned;
    for (int k = 0; k < static_cast<int>(steps); ++k)
      go(piece, side / (radius + (end_radius - radius) * k / (steps - 1.0)));
  }
  track.closing_gap_m = at.norm();
  return track;
}

road::Mesh drivable_by_name(const road::Mesh& mesh) {
  static const std::regex kDrivable("^([tx](kmn|k[lr]s|[0-9][lr]b)|object801$)", std::regex::icase);
  road::Mesh result = mesh;
  result.triangles.clear();
  result.object_of_triangle.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!std::regex_search(mesh.objects[mesh.object_of_triangle[t]].name, kDrivable)) continue;
    result.triangles.push_back(mesh.triangles[t]);
    result.object_of_triangle.push_back(mesh.object_of_triangle[t]);
  }
  return result;
}

}  // namespace support
