#include "report/plot_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(PlotPage, DrawsLinesWhereTheirNumbersAre) {
  report::PlotPage page;
  page.title = "t";
  // Two points at the corners of the axes: x exactly at the frame, y with 4 % of room above it.
  page.plots = {{"p", "x", "y", {{"one", {0, 10}, {0, 1}}}}};
  const std::string html = report::plot_page(page);
  EXPECT_THAT(html, HasSubstr("d='M64 212.2L948 17.8'"));
  EXPECT_THAT(html, HasSubstr(">10</text>"));
  EXPECT_EQ(html, report::plot_page(page));
}

TEST(PlotPage, MarksStretchesWithinTheFrame) {
  report::Plot plot{"p", "x", "y", {{"one", {0, 10}, {0, 1}}}, {{5, 20}, {30, 40}}};
  const std::string html = report::plot_section(plot);
  EXPECT_THAT(html, HasSubstr("<rect class=band x=506 y=10 width=442 height='210'/>"));
  EXPECT_EQ(html.find("<rect", html.find("<rect") + 1), std::string::npos);
}

TEST(PlotPage, BreaksAtNaNAndKeepsPeaksOfLongLines) {
  report::PlotPage page;
  report::PlotLine line{"spike", {}, {}};
  for (int i = 0; i < 100000; ++i) {
    line.x.push_back(i);
    line.y.push_back(i == 54321 ? 7.0 : (i == 70000 ? std::nan("") : 0.0));
  }
  page.plots = {{"p", "x", "y", {line}}};
  const std::string html = report::plot_page(page);
  EXPECT_LT(html.size(), 60000u);
  const std::string path = html.substr(html.find("class='line"));
  EXPECT_THAT(path, HasSubstr(" 17.8"));  // the peak
  EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 2);
}

TEST(PlotPage, TakesTextForTextAndStrangeNumbersForGaps) {
  report::PlotPage page;
  page.title = "<script>alert('1')</script>";
  page.facts = {{"a&b", "\x01\"<"}};
  const double inf = std::numeric_limits<double>::infinity();
  page.plots = {{"", "", "", {{"", {inf, 1, 2}, {0, -inf, 5}}}}, {"empty", "", "", {}}};
  const std::string html = report::plot_page(page);
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(&#39;1&#39;)"));
  EXPECT_THAT(html, HasSubstr("a&amp;b<td>&quot;&lt;"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, Not(HasSubstr("inf")));
}

}  // namespace
