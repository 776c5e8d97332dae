#include "base/table_form.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace table_form_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  base::split_cells(line, separator, cells);
  return {cells.begin(), cells.end()};
}

/// The numbers of a row below a header, or what is said against it.
std::string row_below(std::string_view header, std::string_view row) {
  try {
    const base::TableForm form(header, 1, "t.csv");
    std::vector<std::string_view> cells;
    form.split(row, 2, cells);
    std::string out;
    for (std::size_t c = 0; c < cells.size(); ++c)
      out += (c > 0 ? " " : "") + testing::PrintToString(form.number(cells[c], c, 2));
    return out;
  } catch (const base::Error& error) {
    return error.what();
  }
}

TEST(TableForm, QuotesMayHoldSeparators) {
  EXPECT_THAT(cells_of(R"( "a,b" ,c, "d" )", ','), ElementsAre("a,b", "c", "d"));
  EXPECT_THAT(cells_of(R"("say ""a,b""",c)", ','), ElementsAre(R"(say ""a,b"")", "c"));
  EXPECT_THAT(cells_of("\t\"a\tb\"\t\tc\t", '\t'), ElementsAre("", "a\tb", "", "c", ""));
  EXPECT_THAT(cells_of("5\" pipe,c\"", ','), ElementsAre("5\" pipe", "c\"")) << "inches";
  EXPECT_THAT(cells_of("", ','), ElementsAre(""));
}

TEST(TableForm, TheSeparatorIsThatOfTheNames) {
  EXPECT_EQ(base::separator_of("a,b"), ',');
  EXPECT_EQ(base::separator_of("a;b"), ';');
  EXPECT_EQ(base::separator_of("a\tb"), '\t');
  EXPECT_EQ(base::separator_of("a"), ',');
  EXPECT_EQ(base::separator_of(R"("a,b,c";d)"), ';') << "commas between quotes separate nothing";
  EXPECT_EQ(base::separator_of("x_m,\t\ty_m"), '\t');
  EXPECT_EQ(base::separator_of("x_m,\t\ty_m", {"x_m", "y_m"}), ',') << "tabs that fill up";
}

TEST(TableForm, RowsAreAsLongAsTheHeader) {
  EXPECT_EQ(row_below("a,b", "1,-2.5"), "1 -2.5");
  EXPECT_EQ(row_below("a,b", " 1 ,\t+2\r"), "1 2");
  EXPECT_THAT(row_below("a,b", "1,2.5,3"),
              AllOf(HasSubstr("t.csv:2: '1,2.5,3' has 3 cells, the header in line 1 names 2 "),
                    HasSubstr("take away"), Not(HasSubstr("decimal"))));
  EXPECT_THAT(row_below("a,b", "1"),
              AllOf(HasSubstr("t.csv:2: '1' has 1 cells"), HasSubstr("fill in")));
}

TEST(TableForm, DecimalCommasBesideCommasAreNamed) {
  EXPECT_THAT(row_below("time_s,steering", "0,-0,05"), HasSubstr("look like decimal commas"));
  EXPECT_THAT(row_below("a,b", "1,5,2,5"), HasSubstr("look like decimal commas"));
  EXPECT_THAT(row_below("a,b", "1,two,2"), Not(HasSubstr("decimal")));
  EXPECT_THAT(row_below("a,b", R"(1.5,"2,5")"), HasSubstr("decimals of this table have '.'"));
  EXPECT_THAT(row_below("a,b", R"(1,"2,500")"), HasSubstr("write a point for the comma"));
  EXPECT_EQ(row_below("a,b", R"("0,5","-2,25")"), "0.5 -2.25");
  EXPECT_EQ(row_below("a,b", R"("0,125",-7)"), "0.125 -7");
}

TEST(TableForm, ReadsDecimalCommasBesideOtherSeparators) {
  EXPECT_EQ(row_below("a;b;c", "1,5;-0,25;"), "1.5 -0.25 nan");
  EXPECT_EQ(row_below("a\tb\tc", "1,5\t\t7"), "1.5 nan 7");
  EXPECT_EQ(row_below("a\tb\tc", "1.5\t1e3\t"), "1.5 1000 nan") << "an empty cell at the end";
  EXPECT_THAT(row_below("a;b", "1.234,5;2"), HasSubstr("'1.234,5'"));
  EXPECT_THAT(row_below("a;b", "1,234,567;2"), HasSubstr("'1,234,567'"));
  EXPECT_THAT(row_below("a;b", "1,234;2.5"), AllOf(HasSubstr("t.csv:2"), HasSubstr("'2.5'"),
                                                   HasSubstr("decimals of this table have ','")));
}

TEST(TableForm, AColumnThatIsThereTwiceIsRefused) {
  const base::TableForm form("a,b,a", 3, "t.csv");
  EXPECT_EQ(form.column("b"), 1u);
  EXPECT_EQ(form.column("c"), 3u);
  EXPECT_THROW((void)form.column("a"), base::Error);
}

TEST(TableForm, NumbersAreFinite) {
  EXPECT_EQ(row_below("a,b", "nan,1e-400"), "nan 0");
  for (const char* cell : {"inf", "-inf", "1e400"})
    EXPECT_THAT(row_below("a,b", std::string("1,") + cell),
                HasSubstr(std::string("t.csv:2: column 'b' holds '") + cell))
        << cell;
}

TEST(TableForm, SeparatorsBehindTheLastCellArePassedOver) {
  EXPECT_EQ(row_below("a,b", "1,2,"), "1 2") << "as loggers end their rows";
  EXPECT_EQ(row_below("a,b,,", "1,2,,"), "1 2");
  EXPECT_EQ(row_below("a,b,,", "1,2"), "1 2");
  EXPECT_THAT(row_below("a,b,", "1,5,2"), HasSubstr("3 cells")) << "what nobody named";
  EXPECT_EQ(row_below("a,b,", "1,2,,"), "1 2");
  EXPECT_THAT(row_below("a,b", "1,2,,3"), HasSubstr("4 cells"));
}

TEST(TableForm, ACommaThatMayBeDecimalDoesNotSeparate) {
  const base::TableForm form("ride_m:rear_m;0,01;0,03;0,05", 1, "t.csv");
  EXPECT_EQ(form.names().size(), 4u);
}

TEST(TableForm, RowsThatLookLikeRemarks) {
  const base::TableForm form("id,a,b", 1, "t.csv");
  EXPECT_TRUE(form.is_row("#1,2,3"));
  EXPECT_TRUE(form.is_row(",,"));
  EXPECT_FALSE(form.is_row("# made of 1,2,3"));
  EXPECT_FALSE(form.is_row("#1,2"));
}

TEST(TableForm, MarksOfByteOrder) {
  EXPECT_EQ(base::behind_byte_order_mark("\xEF\xBB\xBFx", "t.csv"), "x");
  EXPECT_EQ(base::behind_byte_order_mark("x", "t.csv"), "x");
  for (const std::string& wide : {std::string("\xFF\xFEx\0", 4), std::string("\xFE\xFF\0x", 4)})
    EXPECT_THROW((void)base::behind_byte_order_mark(wide, "t.csv"), base::Error);
}

TEST(TableForm, BlankLinesAndRemarks) {
  for (const char* line : {"", " \t\r", "# a", "  #"}) EXPECT_TRUE(base::is_blank_or_remark(line));
  EXPECT_FALSE(base::is_blank_or_remark("1,2 # a"));
}

}  // namespace table_form_test
