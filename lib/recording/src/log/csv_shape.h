// Where the numbers of a log in text begin, and what stands before them. Private.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace recording {

struct Shape {
  char separator = ',';
  std::size_t header_line = 0, data_line = 0;
  std::vector<std::string> names, units, sources;  ///< one each for a column, or none
  double stated_s = 0.0;          ///< how long the log is by its preamble; 0: not said
  std::vector<double> beacons_s;  ///< where laps end by the preamble
  bool exported = false;          ///< by a logger's program, with units
};

/// Of a text without a byte order mark. Throws base::Error, with `name`, where it has no header or
/// a plain one has a name twice or none.
Shape shape_of(std::string_view text, const std::string& name);

}  // namespace recording
