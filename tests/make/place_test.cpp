// A road that was moved, turned, scaled and exported again comes back to where it was.
#include "make/place.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "base/json_text.h"
#include "crg/surface.h"
#include "make/make_track.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/temporary_folder.h"

namespace road {
namespace place_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kYaw = 0.65;
const Vector3d kShift(691'234.5, 5'334'567.8, 512.3);

Vector3d moved(const Vector3d& p) {
  return Eigen::AngleAxisd(kYaw, Vector3d::UnitZ()) * p + kShift;
}

std::string control_points(const std::vector<Vector3d>& mesh, const std::vector<Vector3d>& global) {
  std::string text = "mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m\n";
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    char line[300];
    std::snprintf(line, sizeof line, "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", mesh[i].x(), mesh[i].y(),
                  mesh[i].z(), global[i].x(), global[i].y(), global[i].z());
    text += line;
  }
  return text;
}

TEST(Place, MovedScaledAndExportedAgainIsTheSameRoad) {
  const std::string path = places::torcs_tracks() + "/road/g-track-1/g-track-1.acc";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent (apt install torcs-data)";
  const support::TemporaryFolder folder;
  const Mesh mesh = read_mesh(path);
  Recipe first = recipe_for_mesh(path);
  first.centreline.start_near_m = Eigen::Vector2d(mesh.origin_m.x() + mesh.vertices_m[0].x(),
                                                  mesh.origin_m.y() + mesh.vertices_m[0].y());
  const BuildResult built = make_track(first, folder.path("first"));

  // About z alone, and tilted by 1.5 degrees and scaled by 1.01 before.
  for (const bool tilted : {false, true}) {
    const Eigen::Matrix3d linear =
        tilted ? Eigen::Matrix3d(
                     1.01 * Eigen::AngleAxisd(0.026, Vector3d(0.6, 0.8, 0.0)).toRotationMatrix())
               : Eigen::Matrix3d::Identity();
    const auto change = [&](const Vector3d& p) {
      return Vector3d(linear * moved(p) - linear * kShift + kShift);
    };
    Mesh other = mesh;
    other.origin_m = change(mesh.origin_m);
    for (Vector3d& p : other.vertices_m)
      p = linear * (Eigen::AngleAxisd(kYaw, Vector3d::UnitZ()) * p);
    export_mesh(other, folder.path("utm.obj"), {UpAxis::y, Unit::mm});
    std::vector<Vector3d> global, local;
    for (int k = 0; k < 12; ++k) {
      const std::size_t i = mesh.vertices_m.size() * static_cast<std::size_t>(k) / 12;
      global.push_back(mesh.origin_m + mesh.vertices_m[i]);
      local.push_back(change(global.back()));
    }
    Recipe second = recipe_for_mesh(folder.path("utm.obj"));
    second.read.up = UpAxis::y;
    second.read.unit = Unit::mm;
    if (tilted) second.align = {.rotation = AlignOptions::Rotation::free, .scale = true};
    const Vector3d start = change(mesh.origin_m + mesh.vertices_m[0]);
    second.centreline.start_near_m = Eigen::Vector2d(start.x(), start.y());
    second.control_points_path = folder.file("points.csv", control_points(local, global));
    const BuildResult again = make_track(second, folder.path("second"));

    const crg::Surface a(crg::read(built.crg_path)), b(crg::read(again.crg_path));
    const auto& line = a.reference_line();
    EXPECT_NEAR(line.u_step_m * static_cast<double>(line.size()),
                b.grid().u_step_m * static_cast<double>(b.reference_line().size()), 0.02);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> u(0.0,
                                             line.u_step_m * static_cast<double>(line.size() - 2)),
        v(-7.0, 7.0);
    crg::Cursor cursor;
    std::vector<double> difference;
    double offset = 0.0;
    for (int k = 0; k < 20'000; ++k) {
      const double at_u = u(random), at_v = v(random);
      const crg::Point2 p = a.xy_of_uv(at_u, at_v);
      const crg::Sample there = b.at_xy(p.x_m, p.y_m, cursor);
      ASSERT_TRUE(there.valid) << "u = " << at_u << ", v = " << at_v;
      difference.push_back(std::abs(there.z_m - a.z_at_uv(at_u, at_v)));
      offset = std::max(offset, std::abs(there.v_m - at_v));
    }
    std::sort(difference.begin(), difference.end());
    support::figure_of_case("z_largest_mm", 1e3 * difference.back());
    support::figure_of_case("line_mm", 1e3 * offset);
    EXPECT_LE(difference.back(), 2e-4);
    const auto align = base::parse_json<nlohmann::json>(again.summary_json)["align"];
    EXPECT_EQ(align["tilt_and_scale"].is_null(), !tilted);
    EXPECT_NEAR(align["scale"].get<double>(), tilted ? 1.0 / 1.01 : 1.0, 1e-6);
    EXPECT_NEAR(align["tilt_rad"].get<double>(), tilted ? 0.026 : 0.0, 1e-6);
    // The single stage reads the mesh as it lies there and comes to the same.
    if (tilted) {
      Mesh read = read_mesh(second.mesh_path, second.read);
      const auto placement = place_mesh(second);
      apply_to_mesh(placement->align.tilt_and_scale, read);
      ValidateOptions options;
      options.T_global_mesh = placement->align.T_global_mesh;
      EXPECT_LE(validate(again.crg_path, read, options).z_error_m.p99, 1.5e-3);
    }
  }
}

TEST(Place, TiltAndScaleNeedControlPoints) {
  Recipe recipe = recipe_for_mesh("none.obj");
  recipe.align.scale = true;
  try {
    place_mesh(recipe);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("give control_points too"));
  }
}

/// The stadium of tests/cli with control points in latitude and longitude.
class Geographic : public ::testing::Test {
 protected:
  void SetUp() override {
    cli::write(mesh_, cli::Stadium{}.obj());
    std::string points = "name,mesh_x_m,mesh_y_m,mesh_z_m,lat_deg,lon_deg,h_m\n";
    int k = 0;
    for (const auto& [x, y] : {std::pair{0.0, 0.0},
                               {120.0, 0.0},
                               {160.0, 40.0},
                               {120.0, 80.0},
                               {0.0, 80.0},
                               {-40.0, 40.0}}) {
      const Vector3d p = moved({x, y, 1.0});
      const Eigen::Vector2d lat_lon = from_utm({32, true}, p.head<2>());
      char line[200];
      k += 1;
      std::snprintf(line, sizeof line, "P%d,%.3f,%.3f,1.0,%.10f,%.10f,%.4f\n", k, x, y, lat_lon.x(),
                    lat_lon.y(), p.z() + (k == 3 ? 4.0 : 0.0));
      points += line;
    }
    points_ = folder_.file("points.csv", points);
  }
  support::TemporaryFolder folder_;
  std::string mesh_ = folder_.path("s.obj"), points_;
};

TEST_F(Geographic, HeaderSaysWhereOnEarth) {
  Recipe recipe = recipe_for_mesh(mesh_);
  recipe.control_points_path = points_;
  recipe.centreline.start_near_m = Eigen::Vector2d(0.0, 0.0);
  const BuildResult built = make_track(recipe, folder_.path("utm"));
  const crg::Crg file = crg::read(built.crg_path);
  const auto projection = std::find_if(file.projection.begin(), file.projection.end(),
                                       [](const auto& e) { return e.key == "PROJ_NM"; });
  ASSERT_NE(projection, file.projection.end());
  EXPECT_EQ(projection->text, "UTM_32N");
  const double lat = crg::find_value(file.road, "REFERENCE_LINE_START_LAT").value(),
               lon = crg::find_value(file.road, "REFERENCE_LINE_START_LON").value();
  // The line starts at the mesh's (0, 0) within 5 cm; a thousandth of an arc second is 3 cm.
  EXPECT_LT((to_utm({32, true}, lat, lon) - moved({0, 0, 0}).head<2>()).norm(), 0.06);
  const auto align = base::parse_json<nlohmann::json>(built.summary_json)["align"];
  EXPECT_EQ(align["by"], "control_points");
  EXPECT_EQ(align["projection"], "UTM_32N");
  EXPECT_EQ(align["points"][2], "P3");
  EXPECT_EQ(align["outliers"], nlohmann::json::array({"P3"}));
  EXPECT_NEAR(align["residual_m"][2].get<double>(), 4.0, 1e-2);
  EXPECT_NEAR(align["yaw_deg"].get<double>(), kYaw * 180.0 / M_PI, 1e-4);

  // The same with a local projection: no scale of 0.9996, the origin at the first point.
  recipe.projection = Projection::Kind::tm;
  const crg::Crg local = crg::read(make_track(recipe, folder_.path("tm")).crg_path);
  EXPECT_LT(std::hypot(crg::find_value(local.road, "REFERENCE_LINE_START_X").value(),
                       crg::find_value(local.road, "REFERENCE_LINE_START_Y").value()),
            0.06);
  EXPECT_NEAR(crg::find_value(local.road, "REFERENCE_LINE_START_LAT").value(), lat, 1e-6);
  EXPECT_NEAR(crg::find_value(local.projection, "PROJ_L0").value(),
              from_utm({32, true}, moved({0, 0, 0}).head<2>()).y(), 1e-9);
}

/// A circuit that lies on itself in one way only: the middle of its road.
Vector3d bean_m(double share, double size = 1.0) {
  const double t = 2.0 * M_PI * share;
  const double r = size * (90.0 + 25.0 * std::cos(t) + 12.0 * std::sin(2.0 * t));
  return {r * std::cos(t), 0.7 * r * std::sin(t), 2.0 * std::sin(t)};
}

/// Its road, 10 m wide, as an object of an .obj whose vertices begin after `before` others.
std::string bean_obj(int before = 0, double size = 1.0, double x_m = 0.0) {
  constexpr int kRows = 400;
  std::string text = "o road\n";
  for (int k = 0; k < kRows; ++k) {
    const Vector3d p = bean_m(k / double{kRows}, size),
                   next = bean_m((k + 0.01) / double{kRows}, size);
    const Eigen::Vector2d along = (next - p).head<2>().normalized();
    for (const double v : {5.0, -5.0}) {
      char line[100];
      std::snprintf(line, sizeof line, "v %.4f %.4f %.4f\n", x_m + p.x() - v * along.y(),
                    p.y() + v * along.x(), p.z());
      text += line;
    }
  }
  for (int k = 0; k < kRows; ++k) {
    const int i = before + 2 * k + 1, j = before + 2 * ((k + 1) % kRows) + 1;
    char line[100];
    std::snprintf(line, sizeof line, "f %d %d %d %d\n", i, i + 1, j + 1, j);
    text += line;
  }
  return text;
}

/// A lap of it as a receiver sees it: every 2 m or so, up to 1.5 m off, begun somewhere.
std::string driven_bean(bool with_height) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> off_m(-1.5, 1.5);
  std::string text = with_height ? "lat_deg,lon_deg,h_m\n" : "lat_deg,lon_deg\n";
  for (int k = 0; k <= 240; ++k) {
    Vector3d p = bean_m(0.37 + k / 240.0);
    p += Vector3d(off_m(generator), off_m(generator), 0.0);
    const Vector3d global = moved(p);
    const Eigen::Vector2d lat_lon = from_utm({32, true}, global.head<2>());
    char row[100];
    std::snprintf(row, sizeof row, with_height ? "%.9f,%.9f,%.3f\n" : "%.9f,%.9f\n", lat_lon.x(),
                  lat_lon.y(), global.z());
    text += row;
  }
  return text;
}

TEST_F(Geographic, AGuideAloneLaysTheMesh) {
  for (const bool with_height : {true, false}) {
    Recipe recipe = recipe_for_mesh(folder_.file("bean.obj", bean_obj()));
    recipe.guide_path = folder_.file("driven.csv", driven_bean(with_height));
    const BuildResult built = make_track(recipe, folder_.path("bean"));
    const auto align = base::parse_json<nlohmann::json>(built.summary_json)["align"];
    EXPECT_EQ(align["by"], "guide");
    EXPECT_EQ(align["projection"], "UTM_32N");
    // Uniform to 1.5 m either way in x and y: 0.87 m rms across the road.
    EXPECT_NEAR(align["rms_m"].get<double>(), 0.87, 0.15);
    EXPECT_NEAR(align["yaw_deg"].get<double>(), kYaw * 180.0 / M_PI, 0.2);
    const crg::Surface road(crg::read(built.crg_path));
    crg::Cursor cursor;
    double largest_m = 0.0;
    for (int k = 0; k < 50; ++k) {
      const Vector3d p = bean_m(k / 50.0), global = moved(p);
      const crg::Sample there = road.at_xy(global.x(), global.y(), cursor);
      ASSERT_TRUE(there.valid) << k;
      largest_m = std::max(largest_m, std::abs(there.v_m));
      // 240 points of 0.87 m rms leave 0.1 m; the slope of the road is 2 % at most.
      EXPECT_NEAR(there.z_m, with_height ? global.z() : p.z(), 0.03);
    }
    std::printf("laid on a guide of 0.87 m rms: middle within %.2f m\n", largest_m);
    EXPECT_LE(largest_m, 0.5);
  }
  // The report compares the road with the mesh where the guide laid it.
  const cli::Ran ran = cli::crgbuild({"build", folder_.path("bean.obj"), "-o", folder_.path("page"),
                                      "--guide", folder_.path("driven.csv")});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("aligned  by the guide: rms 8"));
}

TEST_F(Geographic, AGuideIsLaidOnTheOneRoadThatHasItsShape) {
  // Of two circuits side by side, neither of them clearly the one that is meant, the second.
  const std::string both = bean_obj(0, 1.05, -400.0) + bean_obj(800);
  Recipe recipe = recipe_for_mesh(folder_.file("two.obj", both));
  EXPECT_THROW(make_track(recipe, folder_.path("asked")), Error);
  recipe.guide_path = folder_.file("driven.csv", driven_bean(true));
  const BuildResult built = make_track(recipe, folder_.path("two"));
  const auto align = base::parse_json<nlohmann::json>(built.summary_json)["align"];
  EXPECT_NEAR(align["yaw_deg"].get<double>(), kYaw * 180.0 / M_PI, 0.2);
  const crg::Surface road(crg::read(built.crg_path));
  crg::Cursor cursor;
  for (int k = 0; k < 50; ++k) {
    const Vector3d global = moved(bean_m(k / 50.0));
    EXPECT_TRUE(road.at_xy(global.x(), global.y(), cursor).valid) << k;
  }
}

/// A lap of the stadium, whose shape is the same after half a turn.
std::string driven_stadium(const crg::ReferenceLine& line) {
  std::string driven = "lat_deg,lon_deg,h_m\n";
  for (std::size_t i = 0; i + 1 < line.size(); i += 20) {
    const Vector3d p = moved({line.x_m[i], line.y_m[i], 0.0});
    const Eigen::Vector2d lat_lon = from_utm({32, true}, p.head<2>());
    char row[200];
    std::snprintf(row, sizeof row, "%.10f,%.10f,%.4f\n", lat_lon.x(), lat_lon.y(), p.z());
    driven += row;
  }
  return driven;
}

TEST_F(Geographic, AShapeThatIsTheSameAfterHalfATurnIsRefused) {
  const BuildResult plain = make_track(recipe_for_mesh(mesh_), folder_.path("plain"));
  const std::string driven = folder_.file(
      "lap.csv", driven_stadium(crg::integrate_reference_line(crg::read(plain.crg_path))));
  for (const char* flag : {"--trajectory", "--guide"}) {
    const cli::Ran ran =
        cli::crgbuild({"build", mesh_, "-o", folder_.path("refused"), flag, driven});
    EXPECT_EQ(ran.code, 1) << flag;
    EXPECT_THAT(ran.err, HasSubstr("lap.csv: "));
    EXPECT_THAT(ran.err, HasSubstr("the same when it is turned by 180 deg"));
    EXPECT_THAT(ran.err, HasSubstr("control"));
    EXPECT_FALSE(std::filesystem::exists(folder_.path("refused/stadium.crg")));
  }
}

TEST_F(Geographic, TrajectoryTakesThePlaceOfControlPoints) {
  std::string driven = driven_bean(true);
  driven += ",,\n";  // the receiver lost its fix
  Recipe recipe = recipe_for_mesh(folder_.file("bean.obj", bean_obj()));
  recipe.trajectory_path = folder_.file("lap.csv", driven);
  const auto align = base::parse_json<nlohmann::json>(
      make_track(recipe, folder_.path("driven")).summary_json)["align"];
  EXPECT_EQ(align["by"], "trajectory");
  EXPECT_EQ(align["projection"], "UTM_32N");
  EXPECT_NEAR(align["yaw_deg"].get<double>(), kYaw * 180.0 / M_PI, 0.2);
  EXPECT_NEAR(align["rms_m"].get<double>(), 0.87, 0.15);
  recipe.trajectory_path = folder_.file("short.csv", "lat_deg,lon_deg,h_m\n48,11,500\n");
  EXPECT_THROW(make_track(recipe, folder_.path("short")), Error);
}

TEST_F(Geographic, WrongPlacesAreRefusedWithAReason) {
  const std::string good = cli::read(points_);
  const auto refusal = [&](const std::string& points) {
    return cli::crgbuild({"build", mesh_, "-o", folder_.path("refused"), "--u-step-m", "0.5",
                          "--v-step-m", "0.5", "--control-points",
                          folder_.file("bad.csv", points)});
  };
  std::string swapped =
      "name,mesh_x_m,mesh_y_m,mesh_z_m,lon_deg,lat_deg,h_m" + good.substr(good.find('\n'));
  const cli::Ran ran = refusal(swapped);
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("bad.csv: no rotation and translation fits, but it does with "
                                 "latitude and longitude swapped"));
  std::string south = good;
  for (std::size_t at = 0; (at = south.find(",48.", at)) != std::string::npos; ++at)
    south.replace(at, 4, ",-48.");
  const cli::Ran below = refusal(south);
  EXPECT_EQ(below.code, 1);
  EXPECT_THAT(below.err, HasSubstr("in another hemisphere"));
  std::string west = good;
  for (std::size_t at = 0; (at = west.find(",11.", at)) != std::string::npos; ++at)
    west.replace(at, 4, ",-11.");
  EXPECT_THAT(refusal(west).err, HasSubstr("in another hemisphere"));
  EXPECT_EQ(cli::crgbuild({"build", mesh_, "-o", folder_.path("both"), "--control-points", points_,
                           "--trajectory", points_})
                .code,
            2);
}

}  // namespace place_test
}  // namespace road
