// The text part of a file: sections up to the separator line, and what the channels are.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "crg/file.h"

namespace crg {

/// What one column of the payload is.
struct Column {
  enum class Kind { Heading, Slope, Banking, X, Y, U, Height, Other };
  Kind kind = Kind::Height;
  std::size_t index = 0;  ///< place in v order (Height) or in Crg::other_channels (Other)
};

struct Header {
  Crg crg;                       ///< everything but the payload; grid.v_m and u values are set
  std::vector<Column> columns;   ///< in file order
  std::string include_path;      ///< text of $ROAD_CRG_FILE
  std::size_t include_line = 0;  ///< the first of its lines
  bool has_separator = false;
  std::size_t end_offset = 0;  ///< first byte of the payload
  std::size_t line_count = 0;  ///< lines up to and including the separator
};

/// Finds the end of the header in `bytes`: the offset behind the separator line (one that begins
/// with "$$"), or npos while there is none yet.
std::size_t find_header_end(std::string_view bytes);

/// Parses the header at the front of `bytes`. Throws Error naming `name`:line.
Header parse_header(std::string_view bytes, const std::string& name);

}  // namespace crg
