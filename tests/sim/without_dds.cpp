// Linked with dds_absent.cpp: what a program says that was built without Cyclone DDS.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "dds_connection.h"
#include "sim/dds.h"

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(DdsAbsent, SaysWhatIsMissingAndWhatToInstall) {
  EXPECT_EQ(sim::dds_version(), "");
  for (const auto& call : {+[] { sim::require_dds("--dds"); },
                           +[] { static_cast<void>(sim::connect_dds(0, {}, true)); }}) {
    try {
      call();
      FAIL() << "no error";
    } catch (const base::Error& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("needs Eclipse Cyclone DDS"),
                                      HasSubstr("install cyclonedds-dev and cyclonedds-tools"),
                                      Not(HasSubstr("\n"))));
    }
  }
}

}  // namespace
