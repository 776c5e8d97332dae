// Messages, what prints, and the caller's memory functions.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "crg/roads.h"
#include "crgBaseLib.h"

namespace messages_test {

std::vector<std::pair<int, std::string>> seen;

int keep(int level, char* message) {
  seen.emplace_back(level, message);
  crgContactPointOptionsPrint(-1);  // a message function may call back
  return 1;
}

struct Messages : testing::Test {
  void SetUp() override {
    seen.clear();
    crgMsgSetCallback(keep);
  }
  void TearDown() override {
    crgMsgSetCallback(nullptr);
    crgMsgSetLevel(dCrgMsgLevelNotice);
    crgMsgSetMaxWarnMsgs(-1);
    crgMsgSetMaxLogMsgs(-1);
    crgLoaderSuppressFileNotFoundFatalMsg(false);
    crgMemRelease();
  }
};

TEST_F(Messages, LevelsDecide) {
  crgMsgSetLevel(dCrgMsgLevelWarn);
  crgMsgPrint(dCrgMsgLevelNotice, "not %d", 1);
  crgMsgPrint(dCrgMsgLevelWarn, "yes %d", 2);
  crgMsgSetLevel(77);  // refused
  crgMsgPrint(dCrgMsgLevelFatal, "%s", std::string(5000, 'x').c_str());
  crgMsgPrint(dCrgMsgLevelFatal, nullptr);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0], std::pair(dCrgMsgLevelWarn, std::string("yes 2")));
  EXPECT_LT(seen[1].second.size(), 1100U);
  EXPECT_EQ(crgMsgIsPrintable(dCrgMsgLevelWarn), 1);
  EXPECT_EQ(crgMsgIsPrintable(dCrgMsgLevelNotice), 0);
  EXPECT_EQ(crgMsgIsPrintable(dCrgMsgLevelNone), 0);
}

TEST_F(Messages, LimitsOfStderr) {
  crgMsgSetCallback(nullptr);
  crgMsgSetMaxWarnMsgs(1);
  testing::internal::CaptureStderr();
  crgMsgPrint(dCrgMsgLevelWarn, "one\n");
  crgMsgPrint(dCrgMsgLevelWarn, "two\n");
  crgMsgPrint(dCrgMsgLevelNotice, "three\n");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: one\nnotice: three\n");
  EXPECT_EQ(crgMsgIsPrintable(dCrgMsgLevelWarn), 0);
}

TEST_F(Messages, SayWhyAFileIsRefused) {
  EXPECT_EQ(crgLoaderReadFile("/nowhere/road.crg"), 0);
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].first, dCrgMsgLevelFatal);
  EXPECT_NE(seen[0].second.find("/nowhere/road.crg"), std::string::npos);
  crgLoaderSuppressFileNotFoundFatalMsg(true);
  EXPECT_EQ(crgLoaderReadFile("/nowhere/road.crg"), 0);
  EXPECT_EQ(seen.size(), 1U);
}

TEST_F(Messages, PrintsTellTheRoad) {
  const crg::test::Folder folder;
  const crg::ReferenceLine line = crg::test::line_along(11, 0.5, [](double) { return 0.0; });
  crg::write(crg::make_crg(
                 line, crg::test::grid_of(line, -2.0, 3.0, 6, [](double, double) { return 1.0; })),
             folder.file("road.crg"), crg::Format::KRBI);
  const int set = crgLoaderReadFile(folder.file("road.crg").c_str());
  ASSERT_GT(set, 0);
  const auto text = [&](auto print, int id) {
    seen.clear();
    print(id);
    std::string all;
    for (const auto& [level, words] : seen) all += words;
    return all;
  };
  EXPECT_NE(text(crgDataPrintHeader, set).find(" 0.5\n"), std::string::npos);
  EXPECT_NE(text(crgDataPrintRoadInfo, set).find(" 5\n"), std::string::npos);
  EXPECT_NE(text(crgDataPrintChannelInfo, set).find(" -2\n"), std::string::npos);
  EXPECT_EQ(text(crgDataSetModifiersPrint, set), "no modifier is set\n");
  crgDataSetModifierSetDefault(set);
  EXPECT_NE(text(crgDataSetModifiersPrint, set).find("modifier 27"), std::string::npos);
  EXPECT_NE(text(crgContactPointOptionsPrint, crgContactPointCreate(set)).find("option 1,"),
            std::string::npos);
  EXPECT_EQ(crgCheck(set), 1);
  EXPECT_NE(std::string(crgGetReleaseInfo()).find("OpenCRG"), std::string::npos);
}

int allocated = 0, freed = 0;

TEST(Memory, CallersFunctionsAreUsed) {
  void* own = crgRealloc(crgCalloc(3, 5), 100);
  ASSERT_NE(own, nullptr);
  crgFree(own);
  crgFree(nullptr);
  crgCallocSetCallback([](size_t n, size_t size) {
    ++allocated;
    return std::calloc(n, size);
  });
  crgReallocSetCallback([](void* p, size_t size) {
    ++allocated;
    return std::realloc(p, size);
  });
  crgFreeSetCallback([](void* p) {
    ++freed;
    std::free(p);
  });
  crgFree(crgRealloc(crgCalloc(1, 1), 2));
  EXPECT_EQ(allocated, 2);
  EXPECT_EQ(freed, 1);
  crgCallocSetCallback(nullptr);
  crgReallocSetCallback(nullptr);
  crgFreeSetCallback(nullptr);
}

}  // namespace messages_test
