#include "support/listed.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support/places.h"

namespace support {

std::map<std::string, std::string> listed(const std::string& name) {
  std::ifstream lines(places::source() + "/tests/" + name);
  EXPECT_TRUE(lines) << name;
  std::map<std::string, std::string> list;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    const std::size_t blank = line.find(' ');
    EXPECT_NE(blank, std::string::npos) << name << ": " << line;
    EXPECT_TRUE(list.emplace(line.substr(0, blank), line.substr(blank + 1)).second) << line;
  }
  return list;
}

}  // namespace support
