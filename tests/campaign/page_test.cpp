#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "campaign/results.h"
#include "campaign/results_folder.h"

namespace page_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Page, NamesFailuresFirstEscapesTextAndShowsUnits) {
  const cli::Folder folder;
  campaign_test::write_results(folder, "crgbuild: <script>alert(1)</script>");
  const std::string page = campaign::page_of(campaign::read_campaign(folder.path()));
  EXPECT_THAT(page, HasSubstr("three &lt;jobs&gt;"));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, HasSubstr("4 jobs: 1 done, 1 failed, 1 blocked, 1 not run"));
  EXPECT_LT(page.find("Not done"), page.find("<h2>road</h2>"));
  EXPECT_THAT(page, HasSubstr("<th>error, 99 % <small>mm</small>"));
  EXPECT_THAT(page, HasSubstr("<td>1.25")) << "0.00125 m";
  EXPECT_THAT(page, HasSubstr("<a href='./road/a/report.html'>a</a>"));
}

TEST(Page, LinksAreNoMarkup) {
  campaign::Campaign one{"one", {}};
  one.jobs.push_back({.id = "road/x",
                      .kind = "road",
                      .subject = "x",
                      .message = "",
                      .page = "road/it's a \"page\".html",
                      .facts = {},
                      .outputs = {}});
  EXPECT_THAT(campaign::page_of(one),
              HasSubstr("<a href='./road/it%27s%20a%20%22page%22.html'>x</a>"));
}

}  // namespace page_test
