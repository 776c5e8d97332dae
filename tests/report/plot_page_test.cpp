#include "report/plot_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>
#include <string>
#include <vector>

namespace plot_page_test {

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

std::vector<std::string> ticks_of(const std::string& html, const std::string& anchor) {
  std::vector<std::string> ticks;
  const std::regex text("text-anchor=" + anchor + ">([^<]*)</text>");
  for (std::sregex_iterator at(html.begin(), html.end(), text), end; at != end; ++at)
    ticks.push_back((*at)[1]);
  return ticks;
}

TEST(PlotPage, TicksDifferAndReadAsNumbers) {
  // Before, six digits: "1e+06" eleven times, and "2e-05".
  const report::Plot far{"p", "", "", {{"one", {1000000.0, 1000010.0}, {-2e-5, 3e-5}}}};
  EXPECT_THAT(
      ticks_of(report::plot_section(far), "middle"),
      ::testing::ElementsAre("1000000", "1000001", "1000002", "1000003", "1000004", "1000005",
                             "1000006", "1000007", "1000008", "1000009", "1000010"));
  EXPECT_THAT(ticks_of(report::plot_section(far), "end"),
              ::testing::ElementsAre("-0.00002", "0", "0.00002", ""));
  const report::Plot near{"p", "", "", {{"one", {-0.5, 0.5}, {1e-9, 3e-9}}}};
  EXPECT_THAT(ticks_of(report::plot_section(near), "middle"),
              ::testing::ElementsAre("-0.5", "-0.4", "-0.3", "-0.2", "-0.1", "0", "0.1", "0.2",
                                     "0.3", "0.4", "0.5"));
  std::vector<std::string> y = ticks_of(report::plot_section(near), "end");
  std::sort(y.begin(), y.end());
  EXPECT_EQ(std::adjacent_find(y.begin(), y.end()), y.end());
}

TEST(PlotPage, MarksStretchesWithinTheFrame) {
  report::Plot plot{"p", "x", "y", {{"one", {0, 10}, {0, 1}}}, {{5, 20}, {30, 40}}};
  const std::string html = report::plot_section(plot);
  EXPECT_THAT(html, HasSubstr("<rect class=band x=506 y=10 width=442 height='210'/>"));
  EXPECT_EQ(html.find("<rect", html.find("<rect") + 1), std::string::npos);
}

TEST(PlotPage, DrawsDotsAndBandsAroundLines) {
  report::PlotLine dots{"rows", {0, 5, NAN, 10}, {0, 1, 1, 2}};
  dots.dots = true;
  const report::PlotLine line{"fit", {0, 10}, {0, 2}, {-1, 1}, {1, 3}};
  const std::string html = report::plot_section({"p", "x", "y", {dots, line}});
  // Heights from -1 to 3, which the band reaches, with a 25th of that for room, over 210 pixels.
  EXPECT_THAT(html, HasSubstr("<path class='dots s1' d='M64 163.6h0M506 115h0M948 66.4h0'/>"));
  EXPECT_THAT(html, HasSubstr("<path class='around s2' d='M64 115L948 17.8L948 115L64 212.2Z'/>"));
  EXPECT_THAT(html, HasSubstr("<path class='line s2'"));
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

}  // namespace plot_page_test
