#include "fmu/resource_path.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace resource_path_test {

TEST(ResourcePath, TakesPathsAndFileUris) {
  EXPECT_EQ(fmu::resource_path("/tmp/a b"), "/tmp/a b");
  EXPECT_EQ(fmu::resource_path("file:/tmp/x"), "/tmp/x");
  EXPECT_EQ(fmu::resource_path("file:///tmp/a%20b%C3%A4"), "/tmp/a b\xc3\xa4");
  EXPECT_EQ(fmu::resource_path("file://localhost/tmp/x"), "/tmp/x");
}

TEST(ResourcePath, RefusesTheRest) {
  for (const char* location : {"", "x", "http://host/x", "file:x", "file://host", "file:///a%2",
                               "file:///a%zz", "file:///a%00b", "file:"})
    EXPECT_THROW((void)fmu::resource_path(location), base::Error) << location;
}

}  // namespace resource_path_test
