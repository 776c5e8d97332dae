#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <pugixml.hpp>
#include <sstream>

#include "cubic_profile.h"
#include "inspect/export_road.h"
#include "inspect/height_map.h"
#include "inspect/track_widths.h"
#include "mesh/error.h"
#include "road/projection.h"

namespace road {
namespace {

using Eigen::Vector2d;

/// One piece of the reference line in the frame of its beginning.
struct PlanPiece {
  double heading_rad = 0.0, length_m = 0.0;
  Cubic along, left;
};

/// A step of a jagged line points elsewhere than the lateral cuts at its ends: where the edges
/// would feel that, the piece follows the cuts, if it then ends no more than kWithin_m beside the
/// next.
PlanPiece plan_piece(const crg::ReferenceLine& line, const std::vector<double>& heading_rad,
                     const std::vector<double>& reach_m, std::size_t begin, std::size_t end) {
  PlanPiece piece;
  piece.heading_rad = heading_rad[begin];
  piece.length_m = static_cast<double>(end - begin) * line.u_step_m;
  const double c = std::cos(piece.heading_rad), s = std::sin(piece.heading_rad);
  const double dx = line.x_m[end] - line.x_m[begin], dy = line.y_m[end] - line.y_m[begin];
  const double turn_rad = heading_rad[end] - heading_rad[begin], chord_m = std::hypot(dx, dy);
  Vector2d to(c * dx + s * dy, c * dy - s * dx);
  const Vector2d by_cuts = chord_m * Vector2d(std::cos(0.5 * turn_rad), std::sin(0.5 * turn_rad));
  if (end == begin + 1 && (by_cuts - to).norm() < kWithin_m &&
      std::abs(std::atan2(to.y(), to.x()) - 0.5 * turn_rad) * reach_m[begin] > kWithin_m)
    to = by_cuts;
  piece.along = hermite(0.0, 1.0, to.x(), std::cos(turn_rad), piece.length_m);
  piece.left = hermite(0.0, 0.0, to.y(), std::sin(turn_rad), piece.length_m);
  return piece;
}

/// Whether the nodes lie on the piece, and what is `reach_m` beside them where it turns them to.
bool plan_fits(const crg::ReferenceLine& line, const std::vector<double>& heading_rad,
               const std::vector<double>& reach_m, std::size_t begin, std::size_t end) {
  const PlanPiece piece = plan_piece(line, heading_rad, reach_m, begin, end);
  const double c = std::cos(piece.heading_rad), s = std::sin(piece.heading_rad);
  for (std::size_t i = begin + 1; i < end; ++i) {
    const double p = static_cast<double>(i - begin) * line.u_step_m;
    const double along = piece.along(p), left = piece.left(p);
    const double x = line.x_m[begin] + c * along - s * left;
    const double y = line.y_m[begin] + s * along + c * left;
    if (std::hypot(x - line.x_m[i], y - line.y_m[i]) > kWithin_m) return false;
    const double turn_rad = std::atan2(piece.left.slope(p), piece.along.slope(p));
    const double off_rad = turn_rad - (heading_rad[i] - piece.heading_rad);
    if (std::abs(off_rad) * reach_m[i] > kWithin_m) return false;
  }
  return true;
}

/// At the nodes: across the mitres, so that t points where v does. Goes on beyond half a turn.
std::vector<double> node_headings(const crg::ReferenceLine& line) {
  std::vector<double> heading_rad;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const crg::Point2 left = crg::node_position(line, i, 1.0);
    const double now_rad = std::atan2(line.x_m[i] - left.x_m, left.y_m - line.y_m[i]);
    const double before_rad = heading_rad.empty() ? now_rad : heading_rad.back();
    heading_rad.push_back(before_rad +
                          std::remainder(now_rad - before_rad, 2.0 * std::numbers::pi));
  }
  return heading_rad;
}

/// Stations between a row and the next: a surface between straight rows is curved along its edges.
constexpr std::size_t kParts = 8;

/// What a station becomes: the straight line through both edges of the road, and the lanes to them
/// in the plane that leans as it does.
struct CrossSections {
  std::vector<double> height_m, lean_rad, left_m, right_m;  ///< kParts per row
  std::vector<double> reach_m;                              ///< of the rows
  double rms_m = 0.0, worst_m = 0.0;                        ///< of the surface about the rows'
};

/// Between the columns; a column without height next to an edge is not asked.
double height_at(const HeightMap& map, std::size_t row, double v_m) {
  const auto after = std::upper_bound(map.v_m.begin(), map.v_m.end(), v_m);
  const auto j = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(after - map.v_m.begin(), 1, map.v_m.end() - map.v_m.begin() - 1));
  const double share = (v_m - map.v_m[j - 1]) / (map.v_m[j] - map.v_m[j - 1]);
  if (share <= 0.0) return map.z_base_m + map.at(row, j - 1);
  if (share >= 1.0) return map.z_base_m + map.at(row, j);
  return map.z_base_m + (1.0 - share) * map.at(row, j - 1) + share * map.at(row, j);
}

/// The edge between two rows, `t` from the one: v and height of the surface there. Where one row
/// has none, straight from edge to edge.
Vector2d edge_between(const HeightMap& map, std::size_t row, double v_m, std::size_t next,
                      double next_v_m, double t) {
  const double at_m = std::lerp(v_m, next_v_m, t);
  const double z_m = std::lerp(height_at(map, row, at_m), height_at(map, next, at_m), t);
  if (std::isfinite(z_m)) return {at_m, z_m};
  return {at_m, std::lerp(height_at(map, row, v_m), height_at(map, next, next_v_m), t)};
}

/// Map metres from the line to v = 1, per row.
Vector2d normal_of(const crg::ReferenceLine& line, std::size_t row) {
  const crg::Point2 left = crg::node_position(line, row, 1.0);
  return {left.x_m - line.x_m[row], left.y_m - line.y_m[row]};
}

/// How far the surface lies from the straight line between the edges, over all rows.
void compare_with_surface(const HeightMap& map, const std::vector<TrackWidth>& widths,
                          CrossSections& out) {
  double square = 0.0, count = 0.0;
  for (std::size_t row = 0; row < map.rows(); ++row) {
    const TrackWidth& width = widths[row % widths.size()];
    const double all_m = width.left_v_m - width.right_v_m;
    if (all_m <= 0.0) continue;
    const double right_m = height_at(map, row, width.right_v_m);
    const double slope = (height_at(map, row, width.left_v_m) - right_m) / all_m;
    for (std::size_t j = 0; j < map.columns(); ++j) {
      const double v_m = map.v_m[j];
      if (v_m < width.right_v_m || v_m > width.left_v_m) continue;
      const double off_m =
          map.z_base_m + map.at(row, j) - right_m - slope * (v_m - width.right_v_m);
      // Fine columns at a kerb count no more than the road that they take.
      const double weight =
          0.5 * (map.v_m[std::min(j + 1, map.columns() - 1)] - map.v_m[j > 0 ? j - 1 : 0]);
      out.worst_m = std::max(out.worst_m, std::abs(off_m));
      square += weight * off_m * off_m;
      count += weight;
    }
  }
  out.rms_m = std::sqrt(square / std::max(count, 1e-12));
}

CrossSections cross_sections(const HeightMap& map, const std::vector<TrackWidth>& widths) {
  CrossSections out;
  const auto width_of = [&](std::size_t row) -> const TrackWidth& {
    return widths[row % widths.size()];
  };
  for (std::size_t row = 0; row < map.rows(); ++row) {
    const std::size_t next = std::min(row + 1, map.rows() - 1);
    const TrackWidth &a = width_of(row), &b = width_of(next);
    const Vector2d from = normal_of(map.line, row), to = normal_of(map.line, next);
    out.reach_m.push_back(std::max(a.left_m, a.right_m));
    for (std::size_t part = 0; part < (row < next ? kParts : 1); ++part) {
      const double t = static_cast<double>(part) / kParts;
      const Vector2d left = edge_between(map, row, a.left_v_m, next, b.left_v_m, t);
      const Vector2d right = edge_between(map, row, a.right_v_m, next, b.right_v_m, t);
      const double stretch = (from + t * (to - from)).norm(), all_v_m = left.x() - right.x();
      const double slope = all_v_m > 0.0 ? (left.y() - right.y()) / (all_v_m * stretch) : 0.0;
      const double slant = std::hypot(1.0, slope) * stretch;
      out.height_m.push_back(left.y() - slope * stretch * left.x());
      out.lean_rad.push_back(std::atan(slope));
      out.left_m.push_back(left.x() * slant);
      out.right_m.push_back(-right.x() * slant);
    }
  }
  compare_with_surface(map, widths, out);
  return out;
}

void put(pugi::xml_node node, const char* name, double value) {
  node.append_attribute(name).set_value(fmt::format("{:.12g}", value).c_str());
}

void put(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(value.c_str());
}

void add_profile(pugi::xml_node parent, const char* element, const char* place,
                 const Profile& profile) {
  for (std::size_t k = 0; k < profile.cubics.size(); ++k) {
    pugi::xml_node node = parent.append_child(element);
    put(node, place, static_cast<double>(profile.ends[k]) * profile.step_m);
    put(node, "a", profile.cubics[k].a);
    put(node, "b", profile.cubics[k].b);
    put(node, "c", profile.cubics[k].c);
    put(node, "d", profile.cubics[k].d);
  }
}

void add_header(pugi::xml_node& top, const std::string& name, const crg::Crg& file,
                const crg::ReferenceLine& line) {
  pugi::xml_node header = top.append_child("header");
  put(header, "revMajor", "1");
  put(header, "revMinor", "8");
  put(header, "name", name);
  put(header, "north", *std::max_element(line.y_m.begin(), line.y_m.end()));
  put(header, "south", *std::min_element(line.y_m.begin(), line.y_m.end()));
  put(header, "east", *std::max_element(line.x_m.begin(), line.x_m.end()));
  put(header, "west", *std::min_element(line.x_m.begin(), line.x_m.end()));
  put(header, "vendor", "Kerbstone");
  const Projection projection = read_projection(file);
  if (projection.kind != Projection::Kind::none)
    header.append_child("geoReference")
        .append_child(pugi::node_cdata)
        .set_value(proj_text(projection).c_str());
}

void add_plan(pugi::xml_node& road, const crg::ReferenceLine& line,
              const std::vector<double>& reach_m) {
  const std::vector<double> heading_rad = node_headings(line);
  const std::vector<std::size_t> ends =
      pieces(line.size(), static_cast<std::size_t>(std::max(1.0, kLongest_m / line.u_step_m)),
             [&](std::size_t begin, std::size_t end) {
               return plan_fits(line, heading_rad, reach_m, begin, end);
             });
  pugi::xml_node plan = road.append_child("planView");
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const PlanPiece piece = plan_piece(line, heading_rad, reach_m, ends[k], ends[k + 1]);
    pugi::xml_node geometry = plan.append_child("geometry");
    put(geometry, "s", static_cast<double>(ends[k]) * line.u_step_m);
    put(geometry, "x", line.x_m[ends[k]]);
    put(geometry, "y", line.y_m[ends[k]]);
    put(geometry, "hdg", piece.heading_rad);
    put(geometry, "length", piece.length_m);
    pugi::xml_node cubic = geometry.append_child("paramPoly3");
    put(cubic, "pRange", "arcLength");
    const auto coefficients = [&](const Cubic& c, const char* const(&names)[4]) {
      put(cubic, names[0], c.a);
      put(cubic, names[1], c.b);
      put(cubic, names[2], c.c);
      put(cubic, names[3], c.d);
    };
    coefficients(piece.along, {"aU", "bU", "cU", "dU"});
    coefficients(piece.left, {"aV", "bV", "cV", "dV"});
  }
}

void add_lanes(pugi::xml_node& road, const CrossSections& sections,
               const crg::ReferenceLine& line) {
  pugi::xml_node section = road.append_child("lanes").append_child("laneSection");
  put(section, "s", 0.0);
  const auto lane_on = [&](const char* side, const std::string& id,
                           const std::vector<double>& width_m) {
    if (*std::max_element(width_m.begin(), width_m.end()) <= 0.0) return;
    pugi::xml_node lane = section.append_child(side).append_child("lane");
    put(lane, "id", id);
    put(lane, "type", "driving");
    put(lane, "level", "false");
    if (line.closed) {
      pugi::xml_node link = lane.append_child("link");
      put(link.append_child("predecessor"), "id", id);
      put(link.append_child("successor"), "id", id);
    }
    add_profile(lane, "width", "sOffset", fit_profile(width_m, line.u_step_m / kParts, kWithin_m));
  };
  lane_on("left", "1", sections.left_m);
  pugi::xml_node middle = section.append_child("center").append_child("lane");
  put(middle, "id", "0");
  put(middle, "type", "none");
  put(middle, "level", "false");
  lane_on("right", "-1", sections.right_m);
}

void add_crg(pugi::xml_node& surface, const std::string& file, const char* purpose,
             double length_m) {
  pugi::xml_node crg = surface.append_child("CRG");
  put(crg, "file", file);
  put(crg, "sStart", 0.0);
  put(crg, "sEnd", length_m);
  put(crg, "orientation", "same");
  put(crg, "mode", "genuine");
  put(crg, "purpose", purpose);
  for (const char* offset : {"sOffset", "tOffset", "zOffset", "hOffset"}) put(crg, offset, 0.0);
  put(crg, "zScale", 1.0);
}

}  // namespace

Exported opendrive(const crg::Surface& road, const std::string& name, const NamedFiles& files,
                   const RoadEdges& edges) {
  const crg::ReferenceLine& line = road.reference_line();
  const HeightMap map = height_map(road);
  const CrossSections sections = cross_sections(map, track_widths(line, road.grid(), edges));
  const double reach_m = *std::max_element(sections.reach_m.begin(), sections.reach_m.end());
  const double step_m = line.u_step_m / kParts;
  const Profile elevation = fit_profile(sections.height_m, step_m, kWithin_m);
  const Profile lean = fit_profile(sections.lean_rad, step_m, kWithin_m / std::max(reach_m, 1.0));
  const double length_m = static_cast<double>(line.size() - 1) * line.u_step_m;

  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  put(declaration, "version", "1.0");
  put(declaration, "encoding", "UTF-8");
  pugi::xml_node top = document.append_child("OpenDRIVE");
  add_header(top, name, road.file(), line);
  pugi::xml_node node = top.append_child("road");
  put(node, "name", name);
  put(node, "length", length_m);
  put(node, "id", "1");
  put(node, "junction", "-1");
  put(node, "rule", "RHT");
  pugi::xml_node link = node.append_child("link");
  if (line.closed)
    for (const auto& [element, contact] :
         {std::pair{"predecessor", "end"}, std::pair{"successor", "start"}}) {
      pugi::xml_node neighbour = link.append_child(element);
      put(neighbour, "elementType", "road");
      put(neighbour, "elementId", "1");
      put(neighbour, "contactPoint", contact);
    }
  add_plan(node, line, sections.reach_m);
  add_profile(node.append_child("elevationProfile"), "elevation", "s", elevation);
  add_profile(node.append_child("lateralProfile"), "superelevation", "s", lean);
  add_lanes(node, sections, line);
  pugi::xml_node surface = node.append_child("surface");
  add_crg(surface, files.crg, "elevation", length_m);
  if (!files.friction_crg.empty()) add_crg(surface, files.friction_crg, "friction", length_m);

  Exported out;
  out.lost.push_back(fmt::format(
      "unevenness and kerbs stand in the CRG alone: elevation and superelevation without it are "
      "{:.1f} mm off (rms), {:.1f} mm at most",
      1e3 * sections.rms_m, 1e3 * (sections.worst_m + elevation.worst)));
  pugi::xml_node note = node.append_child("userData");
  put(note, "code", "lost");
  put(note, "value", out.lost.front());
  std::ostringstream text;
  document.save(text, "  ");
  out.text = text.str();
  out.lost.push_back("road beyond holes is in no lane");
  return out;
}

Exported road_data_file(const NamedFiles& files, double friction) {
  Exported out;
  out.text = fmt::format(
      "[MDI_HEADER]\nFILE_TYPE = 'rdf'\nFILE_VERSION = 5.0\nFILE_FORMAT = 'ASCII'\n"
      "[UNITS]\nLENGTH = 'meter'\nFORCE = 'newton'\nANGLE = 'radians'\nMASS = 'kg'\nTIME = 'sec'\n"
      "[MODEL]\nMETHOD = '2D'\nROAD_TYPE = 'crg'\n"
      "[PARAMETERS]\nMU = {}\nCRG_ROADFILE = '{}'\n",
      friction, files.crg);
  if (!files.friction_crg.empty())
    out.lost.push_back("friction along the road: the format has one MU for all of it");
  return out;
}

}  // namespace road
