// A registered cloud that bends against its base as a whole, as drones' do, is told from one that
// is right.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/random.h"
#include "cloud/map.h"

namespace cloud {
namespace bow_test {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kHalf_m = 4.0, kStep_m = 0.25;
constexpr const char* kSaid = "bends or tilts against the base as a whole";

/// A road in the plan, and what lies over the flat ground there by its own places.
struct Site {
  double radius_m = 0.0;  ///< of its bend to the left; 0: it is straight
  double length_m = 160.0;
  double left_m = kHalf_m;  ///< its width there
  std::function<double(double u_m, double v_m)> base_m = [](double, double) { return 0.0; };
  std::function<double(double x_m, double y_m)> cloud_m = [](double, double) { return 0.0; };

  double heading(double u_m) const { return radius_m > 0.0 ? u_m / radius_m : 0.0; }
  Eigen::Vector2d at(double u_m, double v_m) const {
    const double a = heading(u_m);
    const Eigen::Vector2d middle =
        radius_m > 0.0 ? Eigen::Vector2d(radius_m * std::sin(a), radius_m * (1.0 - std::cos(a)))
                       : Eigen::Vector2d(u_m, 0.0);
    return middle + v_m * Eigen::Vector2d(-std::sin(a), std::cos(a));
  }

  crg::Crg base() const {
    crg::ReferenceLine line;
    crg::Grid grid;
    line.u_step_m = grid.u_step_m = kStep_m;
    for (double v = -kHalf_m; v <= left_m; v += kStep_m) grid.v_m.push_back(v);
    for (double u = 0.0; u <= length_m; u += kStep_m) {
      const Eigen::Vector2d p = at(u, 0.0);
      line.x_m.push_back(p.x()), line.y_m.push_back(p.y());
      line.heading_rad.push_back(heading(u));
      for (const double v : grid.v_m) grid.z_m.push_back(static_cast<float>(base_m(u, v)));
    }
    return crg::make_crg(line, grid);
  }

  Cloud cloud() const {
    Cloud out;
    base::Random random(3);
    for (double u = 0.05; u < length_m; u += 0.15)
      for (double v = -kHalf_m; v < left_m; v += 0.15) {
        const Eigen::Vector2d p = at(u + 0.1 * random.uniform(), v + 0.1 * random.uniform());
        out.x_m.push_back(p.x()), out.y_m.push_back(p.y());
        // In bumps of 2 mm, 20 m long, that the base has not.
        out.z_m.push_back(cloud_m(p.x(), p.y()) + 0.002 * std::sin(0.3 * u) +
                          0.01 * (random.uniform() - 0.5));
      }
    return out;
  }
};

struct Said {
  std::string faults, remarks;
};

Said said_of(const Site& site, bool correct_drift, double base_stddev_m = 0.02) {
  const Cloud cloud = site.cloud();
  MapOptions options;
  options.correct_drift = correct_drift, options.base_stddev_m = base_stddev_m;
  const MapResult result =
      map_clouds([&](const ChunkSink& sink) { sink(Cloud(cloud)); }, site.base(), nullptr, options);
  Said said;
  for (const std::string& text : result.report.faults) said.faults += text + "\n";
  for (const std::string& text : result.report.remarks) said.remarks += text + "\n";
  return said;
}

/// Highest in the middle of the block, lower by `height_m` at 80 m from it.
std::function<double(double, double)> dome(double height_m, double x_m, double y_m) {
  return [=](double x, double y) {
    return -height_m * (std::pow(x - x_m, 2) + std::pow(y - y_m, 2)) / 6400.0;
  };
}

TEST(Bow, OfACloudWithoutATrajectoryIsNeverSilent) {
  Site straight, bend;  // in which a dome is a tilt
  bend.radius_m = 60.0;
  straight.cloud_m = dome(0.06, 80.0, 0.0), bend.cloud_m = dome(0.06, 30.0, 40.0);
  const Said seen = said_of(straight, false);
  EXPECT_THAT(seen.faults, ::testing::ContainsRegex("as a whole by 5[4-7] mm, from its lowest at u "
                                                    ".* to its highest at u [78][0-9] m"));
  EXPECT_THAT(seen.faults, HasSubstr("the road follows the cloud"));
  EXPECT_THAT(said_of(straight, true).faults, HasSubstr("the road follows the base in part"));
  EXPECT_THAT(said_of(bend, false).faults, HasSubstr(kSaid));
  // By size, and by what is known of the base.
  const Said known = said_of(straight, false, 0.05);
  EXPECT_EQ(known.faults, "");
  EXPECT_THAT(known.remarks, HasSubstr(kSaid));
  straight.cloud_m = dome(0.02, 80.0, 0.0);
  const Said small = said_of(straight, false);
  EXPECT_EQ(small.faults, "");
  EXPECT_THAT(small.remarks, HasSubstr(kSaid));
}

TEST(Bow, IsNotSeenInRightCloudsWhateverTheBaseLacks) {
  for (const double radius_m : {0.0, 60.0}) {
    Site site;
    site.radius_m = radius_m;
    const auto expect_none = [&](const char* what) {
      SCOPED_TRACE(fmt::format("{}, radius {} m", what, radius_m));
      const Said said = said_of(site, false);
      EXPECT_EQ(said.faults, "");
      EXPECT_THAT(said.remarks, Not(HasSubstr(kSaid)));
    };
    site.base_m = [](double u, double) { return u > 50.0 && u < 90.0 ? -0.03 : 0.02; };
    expect_none("a layer that the base lacks");
    site.base_m = [](double u, double v) { return 1e-4 * (u - 80.0) * v; };
    site.left_m = 8.0;
    expect_none("a wrong banking");
    site.left_m = kHalf_m;
    site.base_m = [](double u, double v) {
      return 0.012 * std::sin(0.2 * u) + 0.01 * std::sin(0.11 * u + v);
    };
    expect_none("waves");
  }
}

}  // namespace bow_test
}  // namespace cloud
