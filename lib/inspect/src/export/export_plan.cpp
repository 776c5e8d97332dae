#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "inspect/export_road.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "mesh/error.h"
#include "road/projection.h"

namespace road {
namespace {

using Way = std::vector<crg::Point2>;

constexpr double kStep_m = 2.0;  ///< between the points of a drawn line

struct Plan {
  Way middle, left, right, start;
  std::vector<Way> kerbs;  ///< along the edge towards the road
  bool closed = false;
};

Plan plan_of(const crg::Surface& road) {
  const HeightMap map = height_map(road);
  const std::vector<RowExtent> extents = row_extents(map);
  const auto every =
      static_cast<std::size_t>(std::max(1.0, std::round(kStep_m / map.line.u_step_m)));
  Plan plan;
  plan.closed = map.line.closed;
  const auto add = [&](std::size_t row) {
    plan.middle.push_back({map.line.x_m[row], map.line.y_m[row]});
    if (extents[row].empty()) return;
    plan.right.push_back(crg::node_position(map.line, row, map.v_m[extents[row].first]));
    plan.left.push_back(crg::node_position(map.line, row, map.v_m[extents[row].last]));
  };
  for (std::size_t row = 0; row + 1 < map.rows(); row += every) add(row);
  add(map.rows() - 1);
  if (!extents[0].empty())
    plan.start = {crg::node_position(map.line, 0, map.v_m[extents[0].first]),
                  crg::node_position(map.line, 0, map.v_m[extents[0].last])};
  for (const std::vector<KerbRow>& rows : find_kerb_strips(map).rows) {
    Way kerb;
    double last_u_m = -std::numeric_limits<double>::infinity();
    for (const KerbRow& row : rows) {
      if (std::isnan(row.v_begin_m) || map.u_of(row.row) - last_u_m < 0.99 * kStep_m) continue;
      kerb.push_back(crg::node_position(map.line, row.row, row.v_begin_m));
      last_u_m = map.u_of(row.row);
    }
    if (kerb.size() > 1) plan.kerbs.push_back(std::move(kerb));
  }
  return plan;
}

Projection projection_of(const crg::Surface& road, const char* format) {
  const Projection projection = read_projection(road.file());
  if (projection.kind == Projection::Kind::none)
    throw Error(fmt::format(
        "the file does not say where on the Earth it lies (PROJ_NM of $ROAD_CRG_MPRO: UTM_nnN, "
        "UTM_nnS or TM), and {} is in latitude and longitude; align the road (crgbuild build "
        "--control-points or --trajectory), or draw its plan in metres (crgbuild export -o "
        "NAME.svg)",
        format));
  return projection;
}

/// "lon,lat" of each point with something between; 1e-8 degrees are 1 mm.
std::string degrees(const Way& way, const Projection& projection, const char* form,
                    const char* between) {
  std::string text;
  for (const crg::Point2& p : way) {
    const Eigen::Vector2d at = unproject(projection, {p.x_m, p.y_m});
    if (!text.empty()) text += between;
    text += fmt::format(fmt::runtime(form), at.y(), at.x());
  }
  return text;
}

/// Every line of the plan with what it is.
template <class Each>
void each_line(const Plan& plan, const Each& each) {
  each("reference line", plan.middle);
  each("left border", plan.left);
  each("right border", plan.right);
  each("start", plan.start);
  for (const Way& kerb : plan.kerbs) each("kerb", kerb);
}

std::vector<std::string> lost_of_a_plan() {
  return {"heights, banking and everything between the borders",
          fmt::format("what the lines do within {} m", kStep_m)};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

}  // namespace

Exported plan_geojson(const crg::Surface& road) {
  const Projection projection = projection_of(road, "GeoJSON");
  std::string features;
  each_line(plan_of(road), [&](const char* kind, const Way& way) {
    if (way.size() < 2) return;
    features += fmt::format(
        "{}\n{{\"type\":\"Feature\",\"properties\":{{\"kind\":\"{}\"}},\"geometry\":{{\"type\":"
        "\"LineString\",\"coordinates\":[{}]}}}}",
        features.empty() ? "" : ",", kind, degrees(way, projection, "[{:.8f},{:.8f}]", ","));
  });
  return {"{\"type\":\"FeatureCollection\",\"features\":[" + features + "\n]}\n", lost_of_a_plan()};
}

Exported plan_kml(const crg::Surface& road, const std::string& name) {
  const Projection projection = projection_of(road, "KML");
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml "
      "xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{}</name>\n",
      escaped(name));
  each_line(plan_of(road), [&](const char* kind, const Way& way) {
    if (way.size() < 2) return;
    text += fmt::format(
        "<Placemark><name>{}</name><LineString><tessellate>1</tessellate><coordinates>{}"
        "</coordinates></LineString></Placemark>\n",
        kind, degrees(way, projection, "{:.8f},{:.8f}", " "));
  });
  return {text + "</Document>\n</kml>\n", lost_of_a_plan()};
}

Exported plan_svg(const crg::Surface& road) {
  const Plan plan = plan_of(road);
  double west = 1e300, east = -1e300, south = 1e300, north = -1e300;
  each_line(plan, [&](const char*, const Way& way) {
    for (const crg::Point2& p : way) {
      west = std::min(west, p.x_m), east = std::max(east, p.x_m);
      south = std::min(south, p.y_m), north = std::max(north, p.y_m);
    }
  });
  constexpr double kMargin_m = 20.0;
  west -= kMargin_m, north += kMargin_m;
  const double width_m = east + kMargin_m - west, height_m = north - south + kMargin_m;
  const auto points = [&](const Way& way) {
    std::string text;
    for (const crg::Point2& p : way)
      text += fmt::format("{}{:.3f},{:.3f}", text.empty() ? "" : " ", p.x_m - west, north - p.y_m);
    return text;
  };
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.3f} {1:.3f}\">\n<title>road, 1 "
      "unit is 1 m, north is up, (0, 0) is map ({2:.3f}, {3:.3f})</title>\n<rect width=\"100%\" "
      "height=\"100%\" fill=\"#fff\"/>\n",
      width_m, height_m, west, north);
  Way surface = plan.left;
  surface.insert(surface.end(), plan.right.rbegin(), plan.right.rend());
  text += fmt::format("<polygon fill=\"#d6d9de\" points=\"{}\"/>\n", points(surface));
  each_line(plan, [&](const char* kind, const Way& way) {
    const std::string_view what = kind;
    const auto [colour, wide_m] = what == "kerb"             ? std::pair("#c8102e", 1.5)
                                  : what == "start"          ? std::pair("#000", 1.5)
                                  : what == "reference line" ? std::pair("#2860c0", 0.5)
                                                             : std::pair("#444", 0.5);
    if (way.size() > 1)
      text += fmt::format(
          "<polyline class=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" "
          "points=\"{}\"/>\n",
          kind, colour, wide_m, points(way));
  });
  return {text + "</svg>\n", lost_of_a_plan()};
}

}  // namespace road
