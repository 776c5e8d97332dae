// Figures that docs/evidence.md shows: scripts/evidence keeps them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

namespace support {

/// States what the running test measured; the unit is in the name, where spaces become '_'.
inline void figure(std::string name, double value) {
  std::replace(name.begin(), name.end(), ' ', '_');
  std::ostringstream text;
  text << value;
  ::testing::Test::RecordProperty(name, text.str());
}

/// The same for one of several cases of the test: the least and the most of them are kept.
inline void figure_of_case(std::string name, double value) {
  std::replace(name.begin(), name.end(), ' ', '_');
  double least = value, most = value;
  const auto& seen = *::testing::UnitTest::GetInstance()->current_test_info()->result();
  for (int k = 0; k < seen.test_property_count(); ++k) {
    const ::testing::TestProperty& p = seen.GetTestProperty(k);
    if (p.key() == name + "_least") least = std::min(std::stod(p.value()), value);
    if (p.key() == name + "_most") most = std::max(std::stod(p.value()), value);
  }
  figure(name + "_least", least), figure(name + "_most", most);
}

}  // namespace support
