// What is exported is read back by others: pugixml and the formulas of OpenDRIVE's standard, the
// reader of meshes (assimp for .glb), the readers of guides.
#include "inspect/export_road.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <pugixml.hpp>
#include <set>

#include "base/read_file.h"
#include "crg/file.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "mesh/ray_surface.h"
#include "mesh/read_mesh.h"
#include "road/guide.h"
#include "road/projection.h"
#include "support/temporary_folder.h"

namespace export_road_test {

using ::testing::HasSubstr;

constexpr double kTurn = 2.0 * std::numbers::pi;

crg::Point2 middle(double turn_rad) {
  const double r = 150.0 + 25.0 * std::sin(3.0 * turn_rad);
  return {r * std::cos(turn_rad), r * std::sin(turn_rad)};
}

/// A hilly circuit 12 m wide that leans by `bank`, more or less, with a kerb 50 mm high on its left
/// in one place, UTM 32 N.
crg::Crg circuit(bool on_the_earth = true, double bank = 0.0) {
  constexpr int kFine = 400000;
  std::vector<double> s_m{0.0};
  for (int k = 1; k <= kFine; ++k) {
    const crg::Point2 a = middle(kTurn * (k - 1) / kFine), b = middle(kTurn * k / kFine);
    s_m.push_back(s_m.back() + std::hypot(b.x_m - a.x_m, b.y_m - a.y_m));
  }
  const auto rows = static_cast<std::size_t>(s_m.back() / 0.25);
  crg::ReferenceLine line;
  line.u_step_m = s_m.back() / static_cast<double>(rows);
  line.closed = true;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -12; j <= 12; ++j) grid.v_m.push_back(0.5 * j);
  for (std::size_t row = 0; row <= rows; ++row) {
    const double s = std::min(static_cast<double>(row) * line.u_step_m, s_m.back());
    const auto k = std::clamp<std::ptrdiff_t>(
        std::upper_bound(s_m.begin(), s_m.end(), s) - s_m.begin() - 1, 0, kFine - 1);
    const double share = (s - s_m[static_cast<std::size_t>(k)]) /
                         (s_m[static_cast<std::size_t>(k) + 1] - s_m[static_cast<std::size_t>(k)]);
    const double turn_rad = kTurn * (static_cast<double>(k) + share) / kFine;
    const crg::Point2 p = middle(turn_rad);
    line.x_m.push_back(p.x_m + (on_the_earth ? 681000.0 : 0.0));
    line.y_m.push_back(p.y_m + (on_the_earth ? 4851000.0 : 0.0));
    for (const double v : grid.v_m) {
      const bool kerb = row > 100 && row < 300 && v > 5.1;
      grid.z_m.push_back(static_cast<float>(10.0 + 4.0 * std::sin(turn_rad) +
                                            (bank + 0.05 * std::sin(2.0 * turn_rad)) * v +
                                            (kerb ? 0.05 : 0.0)));
    }
  }
  for (std::size_t row = 0; row <= rows; ++row) {
    const std::size_t b = std::max<std::size_t>(row, 1), a = b - 1;
    const double heading_rad = std::atan2(line.y_m[b] - line.y_m[a], line.x_m[b] - line.x_m[a]);
    const double before_rad = line.heading_rad.empty() ? heading_rad : line.heading_rad.back();
    line.heading_rad.push_back(before_rad + std::remainder(heading_rad - before_rad, kTurn));
  }
  // A road's nodes lie a step apart in a straight line.
  double chords_m = 0.0;
  for (std::size_t row = 1; row <= rows; ++row)
    chords_m += std::hypot(line.x_m[row] - line.x_m[row - 1], line.y_m[row] - line.y_m[row - 1]);
  line.u_step_m = grid.u_step_m = chords_m / static_cast<double>(rows);
  crg::Crg file = crg::make_crg(line, grid);
  if (on_the_earth)
    road::write_projection(road::projection_at(road::Projection::Kind::utm, 43.79, 11.25), line,
                           file);
  return file;
}

/// The child of `parent` with the largest `place` that is not beyond s.
pugi::xml_node at(const pugi::xml_node& parent, const char* element, const char* place, double s) {
  pugi::xml_node found;
  for (const pugi::xml_node& node : parent.children(element))
    if (node.attribute(place).as_double() <= s + 1e-9) found = node;
  return found;
}

/// a + b ds + c ds^2 + d ds^3, as in OpenDRIVE 1.8 for elevation, superelevation and widths.
double cubic(const pugi::xml_node& node, const char* place, double s) {
  const double ds = s - node.attribute(place).as_double();
  return node.attribute("a").as_double() + node.attribute("b").as_double() * ds +
         node.attribute("c").as_double() * ds * ds + node.attribute("d").as_double() * ds * ds * ds;
}

/// Where the outer edge of the only lane on a side lies: the reference line, rolled about itself.
Eigen::Vector3d lane_edge(const pugi::xml_node& road, bool left, double s) {
  const pugi::xml_node geometry = at(road.child("planView"), "geometry", "s", s);
  const pugi::xml_node poly = geometry.child("paramPoly3");
  EXPECT_STREQ(poly.attribute("pRange").value(), "arcLength");
  const double p = s - geometry.attribute("s").as_double();
  const auto of = [&](const char* axis, double a, double b, double c, double d) {
    double sum = 0.0;
    for (const auto& [letter, power] : {std::pair{"a", a}, {"b", b}, {"c", c}, {"d", d}})
      sum += poly.attribute((std::string(letter) + axis).c_str()).as_double() * power;
    return sum;
  };
  const double u = of("U", 1.0, p, p * p, p * p * p), v = of("V", 1.0, p, p * p, p * p * p);
  const double du = of("U", 0.0, 1.0, 2.0 * p, 3.0 * p * p);
  const double dv = of("V", 0.0, 1.0, 2.0 * p, 3.0 * p * p);
  const double h = geometry.attribute("hdg").as_double(), h_here = h + std::atan2(dv, du);
  const double z_m = cubic(at(road.child("elevationProfile"), "elevation", "s", s), "s", s);
  const double roll_rad = cubic(at(road.child("lateralProfile"), "superelevation", "s", s), "s", s);
  const pugi::xml_node lane =
      road.child("lanes").child("laneSection").child(left ? "left" : "right").child("lane");
  const double t = (left ? 1.0 : -1.0) * cubic(at(lane, "width", "sOffset", s), "sOffset", s);
  const double across_m = t * std::cos(roll_rad);
  return {geometry.attribute("x").as_double() + std::cos(h) * u - std::sin(h) * v -
              std::sin(h_here) * across_m,
          geometry.attribute("y").as_double() + std::sin(h) * u + std::cos(h) * v +
              std::cos(h_here) * across_m,
          z_m + t * std::sin(roll_rad)};
}

TEST(ExportRoad, OpenDriveIsOneRoadThatNamesItsCrg) {
  const crg::Surface surface(circuit());
  const road::Exported made = road::opendrive(surface, "a < b", {"road.crg", "grip.crg"});
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(made.text.c_str()));
  const pugi::xml_node top = document.child("OpenDRIVE"), node = top.child("road");
  EXPECT_STREQ(top.child("header").attribute("revMinor").value(), "8");
  EXPECT_STREQ(top.child("header").child("geoReference").child_value(),
               "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs");
  EXPECT_STREQ(node.attribute("name").value(), "a < b");
  const double length_m = node.attribute("length").as_double();
  double sum_m = 0.0;
  std::size_t pieces = 0;
  for (const pugi::xml_node& geometry : node.child("planView").children()) {
    EXPECT_NEAR(geometry.attribute("s").as_double(), sum_m, 1e-6) << "no gaps";
    sum_m += geometry.attribute("length").as_double();
    ++pieces;
  }
  EXPECT_NEAR(sum_m, length_m, 1e-6);
  EXPECT_LT(pieces, 200u) << "not one for each of 4000 nodes";
  EXPECT_STREQ(node.child("link").child("successor").attribute("contactPoint").value(), "start");
  std::set<std::string> attached;
  for (const pugi::xml_node& crg : node.child("surface").children("CRG")) {
    attached.insert(std::string(crg.attribute("purpose").value()) + " " +
                    crg.attribute("file").value());
    EXPECT_STREQ(crg.attribute("mode").value(), "genuine");
    EXPECT_NEAR(crg.attribute("sEnd").as_double(), length_m, 1e-9);
  }
  EXPECT_EQ(attached, (std::set<std::string>{"elevation road.crg", "friction grip.crg"}));
  EXPECT_THAT(made.lost[0], HasSubstr("kerbs stand in the CRG alone"));
}

// At rows and between them; on the left over the foot of a kerb, from column to column and back.
TEST(ExportRoad, EachPieceOfThePlanEndsWhereTheNextBegins) {
  // Rows 5 m apart, on an arc of 40 m and with a kink of 0.02 rad at every other node.
  crg::ReferenceLine line;
  line.u_step_m = 5.0;
  double heading_rad = 0.0;
  line.x_m = line.y_m = {0.0};
  line.heading_rad = {0.0};
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  grid.v_m = {-4.0, 0.0, 4.0};
  for (int row = 1; row <= 60; ++row) {
    heading_rad += row < 20 ? 0.125 : row % 2 == 0 ? 0.02 : -0.02;
    line.x_m.push_back(line.x_m.back() + 5.0 * std::cos(heading_rad));
    line.y_m.push_back(line.y_m.back() + 5.0 * std::sin(heading_rad));
    line.heading_rad.push_back(heading_rad);
  }
  grid.z_m.assign(line.size() * grid.v_m.size(), 0.0f);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(
      road::opendrive(crg::Surface(crg::make_crg(line, grid)), "road", {"road.crg", ""})
          .text.c_str()));
  const auto ends = [](const pugi::xml_node& g) {
    const pugi::xml_node poly = g.child("paramPoly3");
    const double p = g.attribute("length").as_double(), h = g.attribute("hdg").as_double();
    const auto of = [&](const char* a, const char* b, const char* c, const char* d) {
      return poly.attribute(a).as_double() + p * poly.attribute(b).as_double() +
             p * p * poly.attribute(c).as_double() + p * p * p * poly.attribute(d).as_double();
    };
    const double u = of("aU", "bU", "cU", "dU"), v = of("aV", "bV", "cV", "dV");
    return Eigen::Vector2d(g.attribute("x").as_double() + std::cos(h) * u - std::sin(h) * v,
                           g.attribute("y").as_double() + std::sin(h) * u + std::cos(h) * v);
  };
  pugi::xml_node before;
  for (const pugi::xml_node& g : document.child("OpenDRIVE").child("road").child("planView")) {
    if (before) {
      EXPECT_LT((ends(before) -
                 Eigen::Vector2d(g.attribute("x").as_double(), g.attribute("y").as_double()))
                    .norm(),
                1e-3)
          << g.attribute("s").value();
    }
    before = g;
  }
}

TEST(ExportRoad, LanesEndAtTheEdgesOfTheRoadWhereItLies) {
  for (const double bank : {0.0, std::tan(20.0 * kTurn / 360.0)}) {
    const crg::Surface surface(circuit(true, bank));
    const crg::ReferenceLine& line = surface.reference_line();
    road::RoadEdges edges;
    for (std::size_t row = 0; row < line.size(); ++row) {
      const double turn_rad =
          kTurn * static_cast<double>(row) / static_cast<double>(line.size() - 1);
      edges.right_m.push_back(-4.0 - 0.5 * std::sin(6.0 * turn_rad));
      edges.left_m.push_back(5.1 + 0.35 * std::sin(320.0 * turn_rad));
    }
    pugi::xml_document document;
    const road::Exported made = road::opendrive(surface, "a", {}, edges);
    ASSERT_TRUE(document.load_string(made.text.c_str()));
    const pugi::xml_node node = document.child("OpenDRIVE").child("road");
    EXPECT_EQ(node.child("userData").attribute("value").value(), made.lost[0]);
    double worst_m = 0.0;
    for (std::size_t row = 0; row + 1 < line.size(); row += 97)
      for (const double part : {0.0, 0.31, 0.5, 0.87})
        for (const bool left : {true, false}) {
          const double s = (static_cast<double>(row) + part) * line.u_step_m;
          const std::vector<double>& v = left ? edges.left_m : edges.right_m;
          const double v_m = std::lerp(v[row], v[row + 1], part);
          const crg::Point2 p = surface.xy_of_uv(s, v_m);
          const Eigen::Vector3d edge = lane_edge(node, left, s);
          worst_m = std::max({worst_m, std::hypot(edge.x() - p.x_m, edge.y() - p.y_m),
                              std::abs(edge.z() - surface.z_at_uv(s, v_m))});
        }
    EXPECT_LT(worst_m, 2e-3) << "bank " << bank;
  }
}

TEST(ExportRoad, MapsComeBackAsGuides) {
  const support::TemporaryFolder folder;
  const crg::Surface surface(circuit());
  const road::Projection projection = road::read_projection(surface.file());
  const road::GuideFile json =
      road::read_guide(folder.file("a.geojson", road::plan_geojson(surface).text));
  const road::GuideFile kml =
      road::read_guide(folder.file("a.kml", road::plan_kml(surface, "a < b & c").text));
  ASSERT_EQ(json.points.size(), kml.points.size());
  ASSERT_GT(json.points.size(), 400u);
  for (std::size_t k = 0; k < json.points.size(); ++k) {
    EXPECT_EQ(json.points[k].x(), kml.points[k].x());
    // The longest line: the reference line, or a border as long.
    const Eigen::Vector2d p = road::project(projection, json.points[k].x(), json.points[k].y());
    crg::Cursor cursor;
    const double v_m = surface.uv_of_xy(p.x(), p.y(), cursor).v_m;
    EXPECT_NEAR(std::min(std::abs(v_m), std::abs(std::abs(v_m) - 6.0)), 0.0, 0.002);
  }
  const crg::Surface nowhere(circuit(false));
  EXPECT_THROW(road::plan_kml(nowhere, "a"), road::Error);
  try {
    road::plan_geojson(nowhere);
    ADD_FAILURE();
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("crgbuild export -o NAME.svg"));
  }
}

TEST(ExportRoad, TheDrawingHasTheRoadTheStartAndTheKerb) {
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(road::plan_svg(crg::Surface(circuit(false))).text.c_str()));
  std::multiset<std::string> kinds;
  for (const pugi::xml_node& line : document.child("svg").children("polyline"))
    kinds.insert(line.attribute("class").value());
  EXPECT_EQ(kinds, (std::multiset<std::string>{"reference line", "left border", "right border",
                                               "start", "kerb"}));
}

TEST(ExportRoad, TrianglesHaveTheHeightsOfTheRoad) {
  const support::TemporaryFolder folder;
  const crg::Surface surface(circuit());
  Eigen::Vector3d origin_m;
  const road::Mesh mesh = road::surface_mesh(surface, 0.25, origin_m);
  EXPECT_GT(origin_m.norm(), 1e5) << "32 bits hold no UTM";
  const std::string path = folder.path("road.glb");
  road::export_mesh(mesh, path, {road::UpAxis::y, road::Unit::m});
  EXPECT_THAT(base::read_file(path), HasSubstr("\"NORMAL\""));
  road::MeshReadOptions with_colours;
  with_colours.want_colours = [](const auto&) { return true; };
  const road::Mesh back = road::read_mesh(path, with_colours);
  std::set<std::string> names;
  for (const road::MeshObject& object : back.objects) {
    names.insert(object.name);
    ASSERT_TRUE(object.colour) << object.name;
    EXPECT_EQ((*object.colour)[0] > 2.0F * (*object.colour)[2], object.name == "kerb") << "red";
  }
  EXPECT_EQ(names, (std::set<std::string>{"road", "kerb"}));
  const road::RaySurface rays(back);
  const crg::ReferenceLine& line = surface.reference_line();
  double worst_m = 0.0;
  for (std::size_t row = 3; row + 3 < line.size(); row += 11)
    for (const double v_m : {-5.5, -2.0, 0.0, 3.0, 5.5}) {
      const crg::Point2 p = crg::node_position(line, row, v_m);
      const double z_m = surface.z_at_uv(static_cast<double>(row) * line.u_step_m, v_m);
      const auto hit = rays.nearest_hit(p.x_m - origin_m.x(), p.y_m - origin_m.y(), z_m, 1.0);
      ASSERT_TRUE(hit);
      worst_m = std::max(worst_m, std::abs(hit->z_m - z_m));
    }
  EXPECT_LT(worst_m, 1e-3) << "at the nodes";
  crg::Crg empty = circuit(false);
  for (float& z : empty.grid.z_m) z = NAN;
  EXPECT_THROW(road::surface_mesh(crg::Surface(empty), 0.25, origin_m), road::Error);
}

TEST(ExportRoad, TheRoadDataFileNamesTheCrg) {
  const road::Exported made = road::road_data_file({"roads/a.crg", ""}, 0.9);
  EXPECT_THAT(made.text, HasSubstr("ROAD_TYPE = 'crg'\n"));
  EXPECT_THAT(made.text, HasSubstr("CRG_ROADFILE = 'roads/a.crg'\n"));
  EXPECT_THAT(made.text, HasSubstr("MU = 0.9\n"));
  EXPECT_TRUE(made.lost.empty());
}

}  // namespace export_road_test
