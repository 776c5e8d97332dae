#include "base/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "support/temporary_folder.h"

namespace csv_test {

// In a folder of this run alone: ctest runs the tests of a program beside each other.
std::string file_with(const std::string& text) {
  static const support::TemporaryFolder folder;
  return folder.file("csv_test.csv", text);
}

std::string error_of(const std::string& text) {
  try {
    base::read_csv(file_with(text), {"x_m", "y_m"});
  } catch (const base::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Csv, PicksColumnsByNameInAnyOrderAndIgnoresOthers) {
  const auto table = base::read_csv(
      file_with(
          "\xEF\xBB\xBF# made by hand\r\n name , y_m,x_m\r\nfoo, 2.5 ,-1e3\r\n\r\nbar,,+4\r\n"),
      {"x_m", "y_m"}, {"z_m"}, base::Gaps::allowed);
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.value(0, 0), -1000.0);
  EXPECT_EQ(table.value(0, 1), 2.5);
  EXPECT_EQ(table.value(1, 0), 4.0);
  EXPECT_TRUE(std::isnan(table.value(1, 1))) << "an empty cell";
  EXPECT_FALSE(table.present[2]);
  EXPECT_TRUE(std::isnan(table.value(0, 2)));
}

TEST(Csv, SaysFileLineSeenAndWanted) {
  using testing::HasSubstr;
  EXPECT_THAT(error_of("x_m,z_m\n1,2\n"), testing::AllOf(HasSubstr("csv_test.csv:1:"),
                                                         HasSubstr("'y_m'"), HasSubstr("x_m,z_m")));
  EXPECT_THAT(error_of("x_m,y_m\n1,2\n3\n"),
              HasSubstr("csv_test.csv:3: '3' has 1 cells, the header in line 1 names 2"));
  EXPECT_THAT(error_of("z_m,x_m,y_m\n1,2,3\n1,2\n"), HasSubstr("csv_test.csv:3: '1,2' has 2"));
  EXPECT_THAT(error_of("x_m,y_m\n\n1,5,2,5\n"),
              testing::AllOf(HasSubstr("csv_test.csv:3: "), HasSubstr("decimal commas")));
  EXPECT_THAT(error_of("x_m,y_m,x_m\n1,2,3\n"), HasSubstr("csv_test.csv:1: two columns"));
  EXPECT_THAT(
      error_of("x_m,y_m\n1,2\n3,four\n"),
      testing::AllOf(HasSubstr("csv_test.csv:3:"), HasSubstr("'four'"), HasSubstr("number")));
  EXPECT_THAT(error_of("x_m,y_m\n1,2km\n"), HasSubstr("'2km'"));
  EXPECT_THAT(error_of(""), HasSubstr("empty"));
  EXPECT_THROW(base::read_csv("/does/not/exist.csv", {"x_m"}), base::Error);
}

TEST(Csv, RequiredColumnsAreFilled) {
  for (const char* empty : {"", "\"\"", "nan"}) {
    const std::string text = std::string("x_m,y_m,z_m\n1,2,\n3,") + empty + ",4\n";
    EXPECT_THAT(error_of(text), testing::HasSubstr("csv_test.csv:3: column 'y_m' ")) << empty;
  }
}

TEST(Csv, LinesMayEndInCarriageReturnsAlone) {
  const auto table = base::read_csv(file_with("a,b\r1,2\r\r3,4\r"), {"a", "b"});
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.value(1, 1), 4.0);
  EXPECT_EQ(table.line[1], 4u);
}

TEST(Csv, AHeaderMayBeginWithAHash) {
  const auto read = [](const std::string& text) {
    return base::read_csv(file_with(text), {"x_m", "y_m"}, {"z_m"});
  };
  const base::CsvTable plain = read("# by hand\n# x_m, y_m,z_m\n1,2,3\n# x_m,y_m\n4,5,6\n");
  ASSERT_EQ(plain.rows(), 2u);
  EXPECT_EQ(plain.value(1, 2), 6.0);
  EXPECT_EQ(plain.line[1], 5u);
  const base::CsvTable twice = read("# x_m,y_m in metres\n# y_m,x_m\ny_m,x_m\n1,2\n");
  ASSERT_EQ(twice.rows(), 1u);
  EXPECT_EQ(twice.value(0, 0), 2.0) << "the line without a hash is the header";
  EXPECT_FALSE(twice.present[2]);
}

TEST(Csv, ReadsWhatSpreadsheetsWrite) {
  const auto table = base::read_csv(
      file_with("\xEF\xBB\xBFname;\"y_m\";x_m;\r\n\"a;b\";2,5;-1e3;\r\n;;\r\nc;0,25;4\r\n"),
      {"x_m", "y_m"}, {}, base::Gaps::allowed);
  ASSERT_EQ(table.rows(), 3u);
  EXPECT_EQ(table.value(0, 0), -1000.0);
  EXPECT_EQ(table.value(0, 1), 2.5);
  EXPECT_TRUE(std::isnan(table.value(1, 0)));
  EXPECT_EQ(table.value(2, 1), 0.25);
  EXPECT_EQ(table.line[2], 4u);
}

TEST(Csv, OfAWholeFileEveryColumnIsRead) {
  const auto table =
      base::read_whole_csv(file_with("# a drive\n\"a[1,2]\",time_s,b\n1,2,3\n"), {"time_s"});
  EXPECT_THAT(table.names, testing::ElementsAre("time_s", "a[1,2]", "b"));
  ASSERT_EQ(table.rows(), 1u);
  EXPECT_THAT(table.values, testing::ElementsAre(2.0, 1.0, 3.0));
}

}  // namespace csv_test
