#include "recording/place.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace recording {
namespace place_test {

Mapping satellites() {
  Mapping out;
  out.columns = {{"lat", "latitude_rad", M_PI / 180}, {"lon", "longitude_rad", M_PI / 180}};
  out.has_origin = true;
  out.origin_latitude_deg = 45;
  out.origin_longitude_deg = 10;
  return out;
}

TEST(Place, AThousandthOfADegree) {
  // Published lengths of a degree at 45 degrees: 111,131.8 m of latitude, 78,846.8 m of longitude.
  Table log;
  log.add("lat", {45.0, 45.001, 45.0});
  log.add("lon", {10.0, 10.0, 10.001});
  Mapping mapping = satellites();
  put_on_plane(log, mapping, "log");
  const std::vector<double>&x = *log.find("east of origin"), &y = *log.find("north of origin");
  EXPECT_NEAR(x[0], 0, 1e-6);
  EXPECT_NEAR(y[1], 111.1318, 2e-3);
  EXPECT_NEAR(x[2], 78.8468, 2e-3);
  EXPECT_EQ(mapping.columns[0].channel, "x_m");
}

TEST(Place, TurnsThenShifts) {
  Table log;
  log.add("lat", {45.001});
  log.add("lon", {10.0});
  Mapping mapping = satellites();
  mapping.place_turn_rad = M_PI / 2;
  mapping.place_x_m = 1000;
  put_on_plane(log, mapping, "log");
  EXPECT_NEAR((*log.find("east of origin"))[0], 1000 - 111.1318, 2e-3);
  EXPECT_NEAR((*log.find("north of origin"))[0], 0, 1e-6);
}

TEST(Place, WantsAnOrigin) {
  Table log;
  log.add("lat", {45.0});
  log.add("lon", {10.0});
  Mapping mapping = satellites();
  mapping.has_origin = false;
  EXPECT_THROW(put_on_plane(log, mapping, "log"), base::Error);
}

}  // namespace place_test
}  // namespace recording
