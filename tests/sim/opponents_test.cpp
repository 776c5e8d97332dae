#include "sim/opponents.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "vehicle/error.h"

namespace opponents_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Opponents, AreReadWithWhatIsBehindTheAt) {
  const support::TemporaryFolder folder;
  const std::string drive = folder.file("a@b.csv", "time_s,x_m,y_m\n10,1,2\n12,3,4\n");
  const sim::OpponentDrive plain = sim::read_opponent(drive);
  EXPECT_EQ(plain.name, drive);
  EXPECT_THAT(plain.drive.time_s, ElementsAre(0, 2));
  EXPECT_THAT(plain.drive.x_m, ElementsAre(1, 3));
  EXPECT_FALSE(plain.ahead_m);
  EXPECT_THAT(sim::read_opponent(drive + "@0.5s").drive.time_s, ElementsAre(-0.5, 1.5));
  const sim::OpponentDrive behind = sim::read_opponent(drive + "@-20m");
  EXPECT_EQ(behind.ahead_m, -20.0);
  EXPECT_THAT(behind.drive.time_s, ElementsAre(0, 2));
  const sim::OpponentDrive own = sim::read_opponent(
      folder.file("own.csv", "time_s,car.x,car.y,input.throttle\n0,1,2,0\n1,3,5,0\n"));
  EXPECT_THAT(own.drive.y_m, ElementsAre(2, 5)) << "as crgsim writes it";
}

TEST(Opponents, RefusesInOneLine) {
  const support::TemporaryFolder folder;
  try {
    sim::read_opponent(folder.file("no.csv", "time_s,x_m\n0,1\n1,2\n"));
    FAIL() << "no error";
  } catch (const vehicle::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no column y_m; an opponent needs time_s, x_m and y_m"));
  }
}

}  // namespace opponents_test
