#include "recording/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace table_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string table_refusal(const std::string& text) {
  try {
    recording::parse_table(text, "t.csv");
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(Table, ReadsNamesNumbersAndEmptyCells) {
  const auto table = recording::parse_table("# remark\r\na_m, b\r\n1,+2e3\r\n,-4\r\n", "t.csv");
  EXPECT_THAT(table.names, ElementsAre("a_m", "b"));
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ((*table.find("a_m"))[0], 1.0);
  EXPECT_TRUE(std::isnan((*table.find("a_m"))[1]));
  EXPECT_THAT(*table.find("b"), ElementsAre(2000.0, -4.0));
  EXPECT_EQ(table.find("c"), nullptr);
}

TEST(Table, ReadsDecimalCommasBesideSemicolons) {
  const auto table = recording::parse_table("\xEF\xBB\xBFx:y;0;0,5\r\n1,25;2;-3,5\r\n", "t.csv");
  EXPECT_THAT(table.names, ElementsAre("x:y", "0", "0.5")) << "places along an axis";
  EXPECT_THAT(table.columns[0], ElementsAre(1.25));
  EXPECT_THAT(table.columns[2], ElementsAre(-3.5));
  EXPECT_THAT(table_refusal("x:y;0;0,5\n1.25;2;3\n"), HasSubstr("write all alike"));
  EXPECT_THAT(table_refusal("a,b\n0,5,1\n"), AllOf(HasSubstr("t.csv:2"), HasSubstr("decimal")));
}

TEST(Table, ReadsBackWhatItWrote) {
  recording::Table table;
  table.add("x", {0.1, std::nan(""), 1.0 / 3.0});
  table.add("y", {-1e-300, 2.0, 3e300});
  const auto back = recording::parse_table(recording::format_table(table, 17), "t.csv");
  EXPECT_EQ(back.names, table.names);
  EXPECT_EQ(back.columns[1], table.columns[1]);
  EXPECT_EQ(back.columns[0][2], table.columns[0][2]);
  EXPECT_TRUE(std::isnan(back.columns[0][1]));
}

TEST(Table, RefusesWithPlaceAndReason) {
  EXPECT_THAT(table_refusal(""), HasSubstr("no header line"));
  EXPECT_THAT(table_refusal("a,a\n"), AllOf(HasSubstr("t.csv:1"), HasSubstr("twice")));
  EXPECT_THAT(table_refusal("a,,b\n"), HasSubstr("without a name"));
  EXPECT_THAT(table_refusal("a,b\n1,2\n1\n"), AllOf(HasSubstr("t.csv:3"), HasSubstr("1 cells")));
  EXPECT_THAT(table_refusal("a,b\n1,2,3\n"), HasSubstr("3 cells"));
  EXPECT_THAT(table_refusal("a\nx1\n"), AllOf(HasSubstr("'x1'"), HasSubstr("column 'a'")));
  EXPECT_THAT(table_refusal("a\ninf\n"), HasSubstr("finite"));
}

}  // namespace table_test
