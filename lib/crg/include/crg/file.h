// An OpenCRG file as data: what its header says and what its channels hold, nothing evaluated.
// Format: ASAM OpenCRG 1.2 and 2.0, section "Data format"; deviations are listed in
// docs/formats.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "crg/grid.h"
#include "crg/reference_line.h"

namespace crg {

enum class Format { KRBI, KDBI, LRFI, LDFI };  ///< float32/float64 binary, 10/20 character text

/// One "KEY = value" line of a section, keyword upper case, in file order. An entry with the key
/// "*" is a comment line (text without the leading asterisk).
struct HeaderEntry {
  std::string key = {};
  double value = 0.0;
  std::string text = {};     ///< for string values (MPRO names); then value is unused
  std::string comment = {};  ///< what followed "!" on the line
};

/// A section lib/crg does not know, kept word for word.
struct Section {
  std::string name = {};  ///< with the leading "$", as in the file
  std::vector<std::string> lines = {};
};

/// A channel lib/crg has no use for, kept so that a round trip loses nothing.
struct Channel {
  std::string definition = {};  ///< text after "D:"
  std::vector<double> values = {};
};

/// The contents of one .crg file. Values are as stored: apply modifiers and options by making a
/// Surface of it. Empty channel vectors mean "no such channel"; otherwise one value per grid row.
struct Crg {
  std::vector<std::string> comment;     ///< lines of $CT
  std::vector<HeaderEntry> road;        ///< $ROAD_CRG
  std::vector<HeaderEntry> options;     ///< $ROAD_CRG_OPTS
  std::vector<HeaderEntry> modifiers;   ///< $ROAD_CRG_MODS
  bool has_modifier_section = false;    ///< an empty section differs from none (docs/formats.md)
  bool has_option_section = false;      ///< as above; matters for files that include others
  std::vector<HeaderEntry> projection;  ///< $ROAD_CRG_MPRO
  Format format = Format::KRBI;
  std::vector<double> heading_rad;  ///< channel "reference line phi"; row 0 is not used
  std::vector<double> slope;        ///< m/m; row 0 is not used
  std::vector<double> banking;      ///< m/m
  Grid grid;

  std::vector<double>
      x_m;  ///< channel "reference line x": node positions, used when y is there too
  std::vector<double> y_m;
  std::vector<double> u_m;  ///< channel "reference line u": kept, not used
  /// Heights in double precision, same shape as grid.z_m; filled only where a file of doubles holds
  /// values that float cannot carry. Queries use grid.z_m, as the reference implementation does.
  std::vector<double> z_double_m;
  std::vector<Channel> other_channels;
  std::vector<std::string> virtual_channels;  ///< text after "U:"
  std::vector<Section> other_sections;
  std::vector<std::string> notes;  ///< what read() accepted although it is not quite the standard
  std::string source;              ///< the path read() was given; names the file in messages
  std::string included_path;       ///< the file that $ROAD_CRG_FILE led to; empty if none
};

/// The value of the last entry with this key (upper case), if there is one.
std::optional<double> find_value(const std::vector<HeaderEntry>& entries, std::string_view key);

/// Replaces the value of `key`, or appends it.
void set_value(std::vector<HeaderEntry>& entries, std::string_view key, double value);

/// Removes every entry with this key.
void erase_key(std::vector<HeaderEntry>& entries, std::string_view key);

/// The file that describes `line` and `grid`: START_/END_ values, phi channel, explicit empty
/// modifier section, REFLINE_CONTINUATION 1 when the line is closed. line.z_m and line.banking
/// become slope and banking channels unless they are constant. The phi channel holds float32
/// values chosen so that the integrated line stays within half a float32 step times u_step of
/// the nodes of `line` however long it is (measured: docs/evidence.md).
/// Throws Error when the two do not fit (rows, u_step, u_begin).
Crg make_crg(const ReferenceLine& line, Grid grid, std::vector<std::string> comment = {});

/// The reference line of a file, integrated as in the standard (forward, and blended towards
/// END_X/END_Y/END_Z where given), modifiers not applied. Throws Error when there is no usable
/// increment or fewer than two rows.
ReferenceLine integrate_reference_line(const Crg& crg);

/// Reads a file, follows one level of include. Throws Error.
Crg read(const std::string& path);

/// Writes to a temporary name beside `path` (links followed; FIFO, device: through), flushes,
/// renames. Throws Error.
void write(const Crg& crg, const std::string& path, Format format);

/// The bytes that write() would put into the file. Throws Error.
std::string to_bytes(const Crg& crg, Format format);

/// Reads a file that is already in memory; `name` stands for it in messages. Includes are not
/// followed: a file that needs one is refused. Throws Error.
Crg read_bytes(std::string_view bytes, const std::string& name);

}  // namespace crg
