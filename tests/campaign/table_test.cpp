#include <gtest/gtest.h>

#include "campaign/results.h"
#include "campaign/results_folder.h"

namespace table_test {

TEST(Table, OneRowPerFactAndQuotesWhereTheyAreNeeded) {
  const cli::Folder folder;
  campaign_test::write_results(folder, "no road, \\\"none\\\"");
  EXPECT_EQ(campaign::table_of(campaign::read_campaign(folder.path())),
            "job,kind,subject,state,fact,value,unit,text\n"
            "road/a,road,a,done,length,1234.25,m,\n"
            "road/a,road,a,done,\"error, 99 %\",0.00125,m,\n"
            "road/a,road,a,done,kerbs,3,,\n"
            "road/b,road,b,failed,message,,,\"no road, \"\"none\"\"\"\n"
            "lap/b+car,lap,b+car,blocked,message,,,needs road/b\n"
            "lap/a+car,lap,a+car,not run,message,,,\n");
}

}  // namespace table_test
