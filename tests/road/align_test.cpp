#include "road/align.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>

#include "road/error.h"
#include "support/temporary_folder.h"

namespace {

TEST(Align, FindsAKnownRotationAndTranslation) {
  // 30 degrees and a UTM-sized shift; sin 30 = 1/2 and cos 30 = sqrt(3)/2 by hand.
  const Eigen::Vector3d shift(691'000.25, 5'334'000.5, 512.0);
  std::vector<road::ControlPoint> points;
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(400, 10, 3), Eigen::Vector3d(-50, 300, -2)}) {
    const double s = std::sqrt(3.0) / 2.0;
    points.push_back({"", p, Eigen::Vector3d(s * p.x() - 0.5 * p.y(), 0.5 * p.x() + s * p.y(), p.z()) + shift});
  }
  const auto report = road::fit_alignment(points);
  EXPECT_NEAR(report.T_global_mesh.yaw_rad, M_PI / 6, 1e-9);
  EXPECT_LT((report.T_global_mesh.translation_m - shift).norm(), 1e-6);
  EXPECT_LT(report.rms_m, 1e-6);

  crg::ReferenceLine line;
  line.x_m = {0.0, 400.0};
  line.y_m = {0.0, 10.0};
  line.heading_rad = {0.1, 0.2};
  apply_alignment(report.T_global_mesh, line);
  EXPECT_NEAR(line.x_m[1], points[1].global_m.x(), 1e-6);
  EXPECT_NEAR(line.y_m[1], points[1].global_m.y(), 1e-6);
  EXPECT_NEAR(line.z_m[1], 512.0, 1e-9);
  EXPECT_NEAR(line.heading_rad[1], 0.2 + M_PI / 6, 1e-9);
}

TEST(Align, SaysHowFarEachPointIsOff) {
  std::vector<road::ControlPoint> points;
  for (const double x : {0.0, 100.0, 200.0, 300.0}) points.push_back({"", {x, 0, 0}, {x, 0, 0}});
  points[2].global_m.z() += 0.4;
  const auto report = road::fit_alignment(points);
  EXPECT_NEAR(report.residual_m[2], 0.3, 1e-9);  // 0.4 less its share in the mean, 0.1
  EXPECT_NEAR(report.residual_m[0], 0.1, 1e-9);
}

TEST(Align, RefusesPointsThatFixNoRotation) {
  EXPECT_THROW(road::fit_alignment({{"", {1, 2, 3}, {4, 5, 6}}}), road::Error);
  EXPECT_THROW(road::fit_alignment({{"", {1, 2, 3}, {4, 5, 6}}, {"", {1.5, 2, 9}, {4, 5.5, 6}}}), road::Error);
}

TEST(Align, ReadsControlPointsAndNamesTheRowThatIsIncomplete) {
  const support::TemporaryFolder folder;
  const std::string path = folder.path("points.csv");
  std::ofstream(path) << "mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m\n1,2,3,4,5,6\n1,2,3,4,5,\n";
  EXPECT_THROW(road::read_control_points(path), road::Error);
  std::ofstream(path) << "mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m\n1,2,3,4,5,6\n";
  EXPECT_EQ(road::read_control_points(path).at(0).global_m, Eigen::Vector3d(4, 5, 6));
}

}  // namespace
