// An OpenCRG file as data: what its header says and what its channels hold, nothing evaluated.
#pragma once

#include <string>
#include <vector>

#include "crg/grid.h"
#include "crg/reference_line.h"

namespace crg {

enum class Format { KRBI, KDBI, LRFI, LDFI };  ///< float32/float64 binary, 10/20 character text

/// One "KEY = value" line of a section, keyword upper case, in file order.
struct HeaderEntry {
  std::string key;
  double value = 0.0;
  std::string text;  ///< for string values (MPRO names); then value is unused
};

/// The contents of one .crg file. Values are as stored: apply modifiers and options by making a
/// Surface of it. Empty channel vectors mean "no such channel"; otherwise one value per grid row.
struct Crg {
  std::vector<std::string> comment;      ///< lines of $CT
  std::vector<HeaderEntry> road;         ///< $ROAD_CRG
  std::vector<HeaderEntry> options;      ///< $ROAD_CRG_OPTS
  std::vector<HeaderEntry> modifiers;    ///< $ROAD_CRG_MODS
  bool has_modifier_section = false;     ///< an empty section differs from none (docs/formats.md)
  std::vector<HeaderEntry> projection;   ///< $ROAD_CRG_MPRO
  Format format = Format::KRBI;
  std::vector<double> heading_rad;       ///< channel "reference line phi"; row 0 is not used
  std::vector<double> slope;             ///< m/m
  std::vector<double> banking;           ///< m/m
  Grid grid;
};

/// The file that describes `line` and `grid`: START_/END_ values, phi channel, explicit empty
/// modifier section, REFLINE_CONTINUATION 1 when the line is closed. line.z_m and line.banking
/// become slope and banking channels unless they are constant.
/// Throws Error when the two do not fit (rows, u_step, u_begin).
Crg make_crg(const ReferenceLine& line, Grid grid, std::vector<std::string> comment = {});

/// The reference line of a file, integrated as in the standard (forward, and blended towards
/// END_X/END_Y/END_Z where given), modifiers not applied.
ReferenceLine integrate_reference_line(const Crg& crg);

/// Reads a file, follows one level of include. Throws Error.
Crg read(const std::string& path);

/// Writes to a temporary name beside `path`, flushes, renames. Throws Error.
void write(const Crg& crg, const std::string& path, Format format);

}  // namespace crg
