#include "road/projection.h"

#include <gtest/gtest.h>

namespace projection_test {

using road::Projection;

/// A file whose line lies at these map points.
crg::Crg file_in(const Projection& projection) {
  const Eigen::Vector2d here_m =
      road::project(projection, projection.latitude_deg, projection.longitude_deg);
  crg::ReferenceLine line;
  line.x_m = {here_m.x(), here_m.x() + 1000.0};
  line.y_m = {here_m.y(), here_m.y() + 200.0};
  crg::Crg file;
  road::write_projection(projection, line, file);
  return file;
}

TEST(Projection, IsReadBackFromTheHeader) {
  for (const auto kind : {Projection::Kind::utm, Projection::Kind::tm})
    for (const double latitude_deg : {43.8, -33.9}) {
      const Projection wanted = road::projection_at(kind, latitude_deg, 151.2);
      const Projection seen = road::read_projection(file_in(wanted));
      ASSERT_EQ(seen.kind, wanted.kind);
      const Eigen::Vector2d map_m = road::project(wanted, latitude_deg + 0.01, 151.23);
      const Eigen::Vector2d back_deg = road::unproject(seen, map_m);
      EXPECT_NEAR(back_deg.x(), latitude_deg + 0.01, 1e-11);
      EXPECT_NEAR(back_deg.y(), 151.23, 1e-11);
    }
}

TEST(Projection, OfOthersThatIsNotUnderstoodIsNone) {
  EXPECT_EQ(road::read_projection({}).kind, Projection::Kind::none);
  crg::Crg file = file_in(road::projection_at(Projection::Kind::tm, 43.8, 11.4));
  set_value(file.projection, "PROJ_F0", 0.9996);
  EXPECT_EQ(road::read_projection(file).kind, Projection::Kind::none);
  for (const char* name : {"UTM_61N", "UTM_32X", "GK3", "UTM_3"}) {
    crg::Crg other;
    other.projection = {{"PROJ_NM", 0.0, name, ""}};
    EXPECT_EQ(road::read_projection(other).kind, Projection::Kind::none) << name;
  }
}

TEST(Projection, HasItsNameInProj) {
  EXPECT_EQ(road::proj_text(road::projection_at(Projection::Kind::utm, -33.9, 151.2)),
            "+proj=utm +zone=56 +south +datum=WGS84 +units=m +no_defs");
}

}  // namespace projection_test
