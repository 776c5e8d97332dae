// Figures that docs/evidence.md shows: scripts/evidence keeps them.
#pragma once

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace support {

/// States what the running test measured; the unit is in the name.
inline void figure(const std::string& name, double value) {
  std::ostringstream text;
  text << value;
  ::testing::Test::RecordProperty(name, text.str());
}

}  // namespace support
