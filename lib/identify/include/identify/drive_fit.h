// What is found about a car from one drive: numbers with intervals, or why there is none.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace identify {

/// A number that was found, or why it was not.
struct Found {
  std::string name, unit;
  double value = 0.0;
  double sd = 0.0;        ///< of everything that is counted
  double sd_drive = 0.0;  ///< of it what the drive leaves open; the rest is the vehicle file's
  double within = 0.0;    ///< half the 90 % interval
  double stated = 0.0;    ///< the vehicle file's; NaN: it has none
  std::string unseen;     ///< why it is not observable; empty: it is
};

/// A drive as one answer: numbers, what they rest on, and what may be wrong.
struct DriveFit {
  std::vector<Found> found;
  std::vector<std::string> remarks;  ///< what was assumed, what cannot be told apart
  std::vector<std::string> doubts;   ///< why it must not be used
  std::size_t windows = 0, blocks = 0;

  /// Throws std::out_of_range.
  const Found& at(const std::string& name) const {
    for (const Found& f : found)
      if (f.name == name) return f;
    throw std::out_of_range(name);
  }
};

}  // namespace identify
