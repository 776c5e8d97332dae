#include "base/error.h"

#include <gtest/gtest.h>

namespace error_test {

std::string what(const std::string& words) { return base::Error(words).what(); }

TEST(Error, IsOneLineWhateverItQuotes) {
  EXPECT_EQ(what("log.csv:3: 'a\r\nb\x1b[2J' is no number\n"), "log.csv:3: 'a b [2J' is no number");
  EXPECT_EQ(what("Höhe 0,5 m"), "Höhe 0,5 m");
  EXPECT_EQ(what(""), "");
}

TEST(Error, OfAVeryLongWordKeepsItsBeginningAndItsEnd) {
  const std::string text =
      what("log.csv:3: '" + std::string(100000, 'x') + "' is no number; remove the line");
  EXPECT_LT(text.size(), 2000);
  EXPECT_TRUE(text.starts_with("log.csv:3: 'xxx"));
  EXPECT_TRUE(text.ends_with("xxx' is no number; remove the line"));
}

}  // namespace error_test
