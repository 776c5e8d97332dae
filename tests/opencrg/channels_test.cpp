// What programs see that look into a data set.
#include <gtest/gtest.h>

#include "crg/roads.h"
#include "crgBaseLibPrivate.h"

namespace channels_test {

TEST(Channels, AreThoseOfTheDataSetAndFollowItsModifiers) {
  const crg::test::Folder folder;
  crg::ReferenceLine line = crg::test::line_along(11, 1.0, [](double) { return 0.0; });
  line.u_begin_m = 5.0;
  crg::Crg road = crg::make_crg(
      line, crg::test::grid_of(line, -2.0, 2.0, 5,
                               [](double u, double v) { return 1.0 + 0.5 * u + 0.25 * v; }));
  crg::write(road, folder.file("road.crg"), crg::Format::KRBI);
  const int set = crgLoaderReadFile(folder.file("road.crg").c_str());
  const CrgDataStruct* const data = crgDataSetAccess(set);
  ASSERT_NE(data, nullptr);
  EXPECT_EQ(data->channelU.info.size, 11u);
  EXPECT_EQ(data->channelU.info.first, 5.0);
  EXPECT_EQ(data->channelU.info.last, 15.0);
  EXPECT_EQ(data->channelU.info.inc, 1.0);
  EXPECT_EQ(data->channelV.info.size, 5u);
  EXPECT_EQ(data->channelV.data[1], -1.0);
  EXPECT_NEAR(data->channelX.info.last - data->channelX.info.first, 10.0, 1e-9);
  EXPECT_EQ(data->channelY.info.last, data->channelY.info.first);
  EXPECT_EQ(data->channelRefZ.data[10], 0.0);
  const auto z = [&](std::size_t v, std::size_t u) {
    return data->channelZ[v].data[u] + data->channelZ[v].info.mean;
  };
  EXPECT_NEAR(z(4, 3), 1.0 + 0.5 * 8.0 + 0.25 * 2.0, 1e-6);
  EXPECT_EQ(crgDataSetModifierSetDouble(set, dCrgModScaleZ, 2.0), 1);
  crgDataSetModifiersApply(set);
  EXPECT_EQ(crgDataSetAccess(set), data);
  EXPECT_NEAR(z(4, 3), 2.0 * (1.0 + 0.5 * 8.0 + 0.25 * 2.0), 1e-6);
  const int point = crgContactPointCreate(set);
  crgContactPointActivatePerfStat(point);
  testing::internal::CaptureStderr();
  crgContactPointPrintPerfStat(point);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("no statistics"), std::string::npos);
  crgMsgSetLevel(dCrgMsgLevelNone);
  EXPECT_EQ(crgDataSetAccess(set + 100), nullptr);
  crgMsgSetLevel(dCrgMsgLevelNotice);
  crgMemRelease();
}

}  // namespace channels_test
