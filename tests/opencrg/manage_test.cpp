// Data sets, contact points, options and modifiers through the C API: what is kept, what is
// refused, what modifiers and options do on roads whose heights are known by hand.
#include <gtest/gtest.h>

#include <array>
#include <climits>
#include <cmath>
#include <string>

#include "crg/roads.h"
#include "crgBaseLib.h"

namespace manage_test {

using crg::test::Folder;

class Manage : public testing::Test {
 protected:
  void SetUp() override { crgMsgSetLevel(dCrgMsgLevelNone); }
  void TearDown() override {
    crgMemRelease();
    crgMsgSetLevel(dCrgMsgLevelNotice);
  }

  // z = 1 + 0.5 u + 0.25 v on u in [5, 15], v in [-2, 2], heading 0, options and modifiers given.
  int load(const std::vector<crg::HeaderEntry>& options = {},
           const std::vector<crg::HeaderEntry>& modifiers = {},
           const std::vector<std::pair<const char*, double>>& road_keys = {}) {
    crg::ReferenceLine line = crg::test::line_along(11, 1.0, [](double) { return 0.0; });
    line.u_begin_m = 5.0;
    crg::Crg road = crg::make_crg(
        line, crg::test::grid_of(line, -2.0, 2.0, 5,
                                 [](double u, double v) { return 1.0 + 0.5 * u + 0.25 * v; }));
    road.options = options;
    road.modifiers = modifiers;
    for (const auto& [key, value] : road_keys) crg::set_value(road.road, key, value);
    crg::write(road, folder_.file("road.crg"), crg::Format::KRBI);
    return crgLoaderReadFile(folder_.file("road.crg").c_str());
  }
  static double z(int cp, double u, double v) {
    double height = -1.0;
    return crgEvaluv2z(cp, u, v, &height) == 1 ? height : NAN;
  }

  Folder folder_;
};

TEST_F(Manage, WrongIdsAndNullAreRefused) {
  const int set = load();
  const int cp = crgContactPointCreate(set);
  ASSERT_GE(cp, 0);
  double a = 0, b = 0;
  int i = 0;
  for (const int id : {-1, INT_MIN, INT_MAX, 7777, 1 << 20}) {
    EXPECT_EQ(crgContactPointCreate(id), -1);
    EXPECT_EQ(crgCheck(id), 0);
    EXPECT_EQ(crgDataSetRelease(id), 0);
    EXPECT_EQ(crgDataSetGetURange(id, &a, &b), 0);
    EXPECT_EQ(crgDataSetModifierSetDouble(id, dCrgModScaleZ, 1.0), 0);
    EXPECT_EQ(crgDataSetGetUtilityDataClosedTrack(id, &i, &a, &b), 0);
    EXPECT_EQ(crgContactPointDelete(id), 0);
    EXPECT_EQ(crgContactPointOptionSetInt(id, dCrgCpOptionBorderModeU, 1), 0);
    EXPECT_EQ(crgContactPointSetHistory(id, 10), 0);
    EXPECT_EQ(crgEvalxy2z(id, 6.0, 0.0, &a), 0);
    EXPECT_EQ(crgEvalxy2pk(id, 6.0, 0.0, &a, &b), 0);
    crgDataSetModifiersApply(id);
    crgDataPrintHeader(id);
    crgContactPointOptionsPrint(id);
    if (id != -1) crgContactPointDeleteAll(id);
  }
  EXPECT_EQ(crgLoaderReadFile(nullptr), 0);
  EXPECT_EQ(crgLoaderReadFile(""), 0);
  EXPECT_EQ(crgLoaderReadFile("/nowhere/road.crg"), 0);
  EXPECT_EQ(crgEvalxy2z(cp, 6.0, 0.0, nullptr), 0);
  EXPECT_EQ(crgEvalxy2uv(cp, 6.0, 0.0, &a, nullptr), 0);
  EXPECT_EQ(crgDataSetGetVRange(set, nullptr, &b), 0);
  EXPECT_EQ(crgContactPointOptionGetInt(cp, dCrgCpOptionBorderModeU, nullptr), 0);
  EXPECT_EQ(crgEvalxy2z(cp, NAN, 0.0, &a), 0);
  EXPECT_EQ(crgEvaluv2z(cp, INFINITY, 0.0, &a), 0);
  EXPECT_EQ(crgEvaluv2pk(cp, 0.0, NAN, &a, &b), 0);
}

TEST_F(Manage, OptionsAreKeptByKind) {
  const int cp = crgContactPointCreate(load({{.key = "BORDER_MODE_V", .value = 3.0}}));
  int whole = -1;
  double number = -1.0;
  EXPECT_EQ(crgContactPointOptionGetInt(cp, dCrgCpOptionBorderModeU, &whole), 1);
  EXPECT_EQ(whole, dCrgBorderModeExKeep) << "the default";
  EXPECT_EQ(crgContactPointOptionGetInt(cp, dCrgCpOptionBorderModeV, &whole), 1);
  EXPECT_EQ(whole, dCrgBorderModeRepeat) << "from the file";
  EXPECT_EQ(crgContactPointOptionSetDouble(cp, dCrgCpOptionBorderModeU, 1.0), 0)
      << "of the other kind";
  EXPECT_EQ(crgContactPointOptionSetInt(cp, dCrgCpOptionBorderOffsetU, 1), 0);
  EXPECT_EQ(crgContactPointOptionSetDouble(cp, dCrgCpOptionSmoothUBegin, 0.0), 0);
  EXPECT_EQ(crgContactPointOptionSetDouble(cp, dCrgCpOptionBorderOffsetU, NAN), 0);
  for (const unsigned id : {0U, 4U, 20U, 45U, 50U, 51U, UINT_MAX})
    EXPECT_EQ(crgContactPointOptionSetInt(cp, id, 1), 0) << id;
  EXPECT_EQ(crgContactPointOptionGetDouble(cp, dCrgCpOptionBorderOffsetV, &number), 0) << "not set";
  EXPECT_EQ(crgContactPointOptionSetDouble(cp, dCrgCpOptionBorderOffsetV, 0.5), 1);
  EXPECT_EQ(crgContactPointOptionGetDouble(cp, dCrgCpOptionBorderOffsetV, &number), 1);
  EXPECT_EQ(number, 0.5);
  EXPECT_EQ(crgContactPointOptionRemove(cp, dCrgCpOptionBorderOffsetV), 1);
  EXPECT_EQ(crgContactPointOptionGetDouble(cp, dCrgCpOptionBorderOffsetV, &number), 0);
  EXPECT_EQ(crgContactPointOptionRemoveAll(cp), 1);
  EXPECT_EQ(crgContactPointOptionGetInt(cp, dCrgCpOptionBorderModeV, &whole), 0);
  double height = -1.0;
  EXPECT_EQ(crgEvaluv2z(cp, 4.0, 0.0, &height), 0) << "no mode along u: no road";
  EXPECT_EQ(height, 0.0);
  EXPECT_EQ(z(cp, 10.0, 9.0), 6.5) << "across it is kept all the same";
  crgContactPointSetDefaultOptions(cp);
  EXPECT_EQ(z(cp, 4.0, 0.0), 3.5);
}

TEST_F(Manage, BordersAndZones) {
  const int set = load();
  const int cp = crgContactPointCreate(set), other = crgContactPointCreate(set);
  ASSERT_NE(cp, other);
  EXPECT_EQ(crgContactPointOptionSetInt(cp, dCrgCpOptionBorderModeU, dCrgBorderModeReflect), 1);
  EXPECT_EQ(z(cp, 4.0, 1.0), 4.25);
  EXPECT_EQ(z(cp, 5.0 - 12.0, 1.0), 1.0 + 0.5 * 13.0 + 0.25);
  EXPECT_EQ(z(other, 4.0, 1.0), 3.75) << "options are of one point";
  crgContactPointOptionSetInt(cp, dCrgCpOptionBorderModeU, dCrgBorderModeRepeat);
  EXPECT_EQ(z(cp, 16.5, 1.0), 1.0 + 0.5 * 6.5 + 0.25);
  crgContactPointOptionSetInt(cp, dCrgCpOptionBorderModeV, dCrgBorderModeExZero);
  crgContactPointOptionSetDouble(cp, dCrgCpOptionBorderOffsetV, 0.125);
  EXPECT_EQ(z(cp, 10.0, 3.0), 0.125);
  // Beyond an end that is kept the mode of the sides takes the grid away, and both offsets count.
  crgContactPointOptionSetInt(cp, dCrgCpOptionBorderModeU, dCrgBorderModeExKeep);
  crgContactPointOptionSetDouble(cp, dCrgCpOptionBorderOffsetU, 2.0);
  EXPECT_EQ(z(cp, 16.0, 3.0), 2.125);
  crgContactPointOptionSetDouble(other, dCrgCpOptionSmoothUBegin, 4.0);
  EXPECT_EQ(z(other, 6.0, 0.0), 0.25 * 4.0);
  EXPECT_EQ(z(other, 4.0, 0.0), 0.0);
  EXPECT_EQ(z(other, 10.0, 0.0), 6.0);
}

TEST_F(Manage, ModifiersActOnceAndContactPointsFollow) {
  const int set = load();
  const int cp = crgContactPointCreate(set);
  double u0 = 0, u1 = 0, number = 0;
  EXPECT_EQ(crgDataSetModifierGetDouble(set, dCrgModRefPointX, &number), 0) << "an empty section";
  EXPECT_EQ(crgDataSetModifierSetDouble(set, dCrgModScaleZ, 2.0), 1);
  EXPECT_EQ(crgDataSetModifierSetDouble(set, dCrgModScaleLength, 3.0), 1);
  EXPECT_EQ(crgDataSetModifierSetDouble(set, dCrgModRefLineOffsetX, 100.0), 1);
  EXPECT_EQ(crgDataSetModifierSetInt(set, dCrgModScaleZ, 2), 0);
  EXPECT_EQ(z(cp, 6.0, 0.0), 4.0) << "not yet applied";
  crgDataSetModifiersApply(set);
  EXPECT_EQ(crgDataSetGetURange(set, &u0, &u1), 1);
  EXPECT_EQ(u0, 5.0) << "a longer road begins where it began";
  EXPECT_EQ(u1, 35.0);
  EXPECT_EQ(z(cp, 8.0, 0.0), 8.0);
  double x = 0, y = 0;
  EXPECT_EQ(crgEvaluv2xy(cp, 5.0, 1.0, &x, &y), 1);
  EXPECT_EQ(x, 100.0);
  EXPECT_EQ(y, 1.0);
  EXPECT_EQ(crgDataSetModifierGetDouble(set, dCrgModScaleZ, &number), 0) << "removed";
  crgDataSetModifiersApply(set);
  EXPECT_EQ(z(cp, 8.0, 0.0), 8.0);
  crgDataSetModifierSetDouble(set, dCrgModScaleLength, -1.0);
  crgDataSetModifiersApply(set);
  EXPECT_EQ(z(cp, 8.0, 0.0), 8.0) << "refused as a whole";
}

TEST_F(Manage, AClosedTrackIsClosedForThePointThatAsks) {
  const crg::ReferenceLine line = crg::test::circuit(1001, 30.0, 0.1, 3);
  crg::write(crg::make_crg(line, crg::test::grid_of(line, -4.0, 4.0, 9,
                                                    [](double u, double) { return 0.01 * u; })),
             folder_.file("ring.crg"), crg::Format::KRBI);
  const int set = crgLoaderReadFile(folder_.file("ring.crg").c_str());
  int closed = 0;
  double from = 0, to = 0;
  ASSERT_EQ(crgDataSetGetUtilityDataClosedTrack(set, &closed, &from, &to), 1);
  ASSERT_EQ(closed, 1);
  const int ring = crgContactPointCreate(set), path = crgContactPointCreate(set);
  crgContactPointOptionSetInt(path, dCrgCpOptionRefLineContinue, dCrgRefLineExtrapolate);
  const double lap = to - from;
  EXPECT_NEAR(z(ring, 12.0 + lap, 0.0), z(ring, 12.0, 0.0), 1e-9);
  EXPECT_NEAR(z(ring, 12.0 - 3.0 * lap, 0.0), z(ring, 12.0, 0.0), 1e-9);
  EXPECT_NEAR(z(path, 12.0 + lap, 0.0), 0.01 * 1000.0 * line.u_step_m, 1e-5) << "the end is kept";
  double x = 0, y = 0, x2 = 0, y2 = 0;
  crgEvaluv2xy(ring, 12.0 + lap, 1.0, &x, &y);
  crgEvaluv2xy(ring, 12.0, 1.0, &x2, &y2);
  EXPECT_NEAR(std::hypot(x - x2, y - y2), 0.0, 1e-9);
}

TEST_F(Manage, ReleaseEndsTheContactPointsToo) {
  const int set = load(), second = load();
  EXPECT_NE(set, second);
  const int cp = crgContactPointCreate(set), stays = crgContactPointCreate(second);
  EXPECT_EQ(crgDataSetRelease(set), 1);
  double height = 0;
  EXPECT_EQ(crgEvaluv2z(cp, 6.0, 0.0, &height), 0);
  EXPECT_EQ(crgEvaluv2z(stays, 6.0, 0.0, &height), 1);
  crgContactPointDeleteAll(-1);
  EXPECT_EQ(crgEvaluv2z(stays, 6.0, 0.0, &height), 0);
  EXPECT_GE(crgContactPointCreate(second), 0);
  crgMemRelease();
  EXPECT_EQ(crgContactPointCreate(second), -1);
}

// By hand: a straight road from (0, 0) along x; its axes turned by 90 degrees and moved.
TEST_F(Manage, AnOriginPutsTheRoadIntoTheWorldAndModifiersLeaveItThere) {
  const int set = load({}, {},
                       {{"REFERENCE_LINE_OFFSET_X", 100.0},
                        {"REFERENCE_LINE_OFFSET_Y", 200.0},
                        {"REFERENCE_LINE_OFFSET_Z", 30.0},
                        {"REFERENCE_LINE_OFFSET_PHI", 0.5 * M_PI}});
  const int cp = crgContactPointCreate(set);
  const auto world = [&](double u, double v) {
    double x = 0, y = 0, height = 0, e = 0, n = 0, h = 0, back_x = 0, back_y = 0, back_z = 0;
    EXPECT_EQ(crgEvaluv2xy(cp, u, v, &x, &y) + crgEvaluv2z(cp, u, v, &height), 2);
    EXPECT_EQ(crgEvalxyz2enh(cp, x, y, height, &e, &n, &h), 1);
    EXPECT_EQ(crgEvalenh2xyz(cp, e, n, h, &back_x, &back_y, &back_z), 1);
    EXPECT_NEAR(std::hypot(back_x - x, back_y - y, back_z - height), 0.0, 1e-9);
    return std::array{e, n, h};
  };
  const auto before = world(9.0, 1.0);
  EXPECT_NEAR(before[0], 100.0 - 1.0, 1e-9);
  EXPECT_NEAR(before[1], 200.0 + 4.0, 1e-9);
  EXPECT_NEAR(before[2], 30.0 + 1.0 + 4.5 + 0.25, 1e-6);
  const auto stays = [&] {
    const auto now = world(9.0, 1.0);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(now[k], before[k], 1e-6);
  };
  crgDataSetModifierRemoveAll(set);
  for (const auto& [id, value] :
       {std::pair{dCrgModRefPointUFrac, 0.5}, std::pair{dCrgModRefPointV, 0.4},
        std::pair{dCrgModRefPointX, 100.2}, std::pair{dCrgModRefPointY, 30.5},
        std::pair{dCrgModRefPointZ, 12.9}, std::pair{dCrgModRefPointPhi, 3.0}})
    EXPECT_EQ(crgDataSetModifierSetDouble(set, static_cast<unsigned>(id), value), 1);
  crgDataSetModifiersApply(set);
  stays();
  EXPECT_EQ(crgDataSetSetGlobalOrigin(set, 7.0, -8.0, 0.0, 0.3), 1);
  double x = 0, y = 0, height = 0, phi = 0;
  EXPECT_EQ(crgDataSetGetGlobalOrigin(set, &x, &y, &height, &phi), 1);
  EXPECT_EQ((std::array{x, y, height, phi}), (std::array{7.0, -8.0, 0.0, 0.3}));
  stays();
  EXPECT_EQ(crgDataSetSetGlobalOrigin(set, 0.0, 0.0, 0.0, 0.0), 1);
  stays();
  EXPECT_EQ(crgEvaluv2xy(cp, 9.0, 1.0, &x, &y), 1);
  EXPECT_NEAR(std::hypot(x - before[0], y - before[1]), 0.0, 1e-9);
  EXPECT_EQ(crgDataSetSetGlobalOrigin(set, NAN, 0.0, 0.0, 0.0), 0);
  stays();
}

}  // namespace manage_test
