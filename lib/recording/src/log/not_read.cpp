// Formats that are known and not read, with the way out.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "base/text_lines.h"
#include "readers.h"

namespace recording {
namespace {

/// Formats that are known by their first bytes and not read, with the way out.
struct NotRead {
  std::string_view begin, format, way_out;
};
constexpr std::string_view kOfNmea =
    "write it as CSV (gpsbabel -t -i nmea -f LOG -o unicsv -F LOG.csv)";
constexpr std::string_view kOfXml =
    "write it as CSV (gpsbabel -t -i gpx -f LOG -o unicsv -F LOG.csv; KML: -i kml, TCX: -i "
    "gtrnctr)";
constexpr NotRead kNotRead[] = {
    {"MDF     ", "ASAM MDF", "export it as CSV, for instance by asammdf"},
    {"UnFinMF ", "ASAM MDF that was not finished", "finish and export it as CSV, by asammdf"},
    {"<hCNF", "AiM .xrk or .xrz", "export it as CSV in Race Studio"},
    {"LOGG", "Vector .blf", "export its signals as CSV with their database"},
    {"MATLAB ", "MATLAB .mat", "write the signals as CSV (writetable)"},
    {"\x89HDF\r\n", "HDF5 or MATLAB .mat", "write the signals as CSV"},
    {"PAR1", "Parquet", "write it as CSV"},
    {"ARROW1", "Arrow or Feather", "write it as CSV"},
    {"\x93NUMPY", "NumPy .npy", "write it as CSV (numpy.savetxt)"},
    {"ULog\x01\x12", "PX4 .ulg", "write it as CSV, for instance by pyulog"},
    {"\xa3\x95\x80", "ArduPilot .bin", "write it as CSV, for instance by pymavlink"},
    {"<?xml", "XML, as GPX, KML and TCX", kOfXml},
    {"<gpx", "GPX", kOfXml},
    {"<kml", "KML", kOfXml},
    {"PK\x03\x04", "a zip archive or a spreadsheet", "unpack it, or save the sheet as CSV"},
    {"\x1f\x8b", "gzip", "unpack it (gunzip)"},
    {"\xfd"
     "7zXZ",
     "xz", "unpack it (xz --decompress)"},
    {"BZh", "bzip2", "unpack it (bunzip2)"},
    {"#ROSBAG V", "a bag of ROS 1", "convert it to MCAP (mcap convert)"}};

bool is_json(std::string_view text) {
  if (!text.starts_with('{') && !text.starts_with('[')) return false;
  const std::size_t inside = text.find_first_not_of(" \t\r\n", 1);
  return inside != std::string_view::npos &&
         std::string_view("\"{[").find(text[inside]) != std::string_view::npos;
}

/// Formats in text, by a part of their first line.
constexpr NotRead kTextNotRead[] = {
    {"VCDS", "an export of VCDS, whose groups have a clock each",
     "write one table for each group, with time in s, names and units in one line"},
    {"GMOS Trace", "a trace of SpeedAngle (.sa), whose columns have no names",
     "write one as CSV, with names, units and a time"},
    {"FMT, 128,", "ArduPilot .log", "write it as CSV, for instance by pymavlink"},
    {"Type,Local Number,Message,", "a .fit as FitCSVTool lists it",
     "write the .fit itself as CSV (gpsbabel -t -i garmin_fit -f LOG -o unicsv -F LOG.csv)"},
    {"Raw,ElapsedRealtimeMillis,", "GnssLogger's text",
     "take its rows of fixes with their line of names (grep Fix, LOG | sed 's/^# //')"},
};

/// "$GPGSA,", "$GNVTG,": a talker and the kind of a sentence; some loggers put a date before it.
bool is_nmea(std::string_view text) {
  const auto is_capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  text.remove_prefix(std::min(text.substr(0, text.find('\n')).find('$'), text.size()));
  while (text.starts_with('$')) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    if (line.size() > 7 && line.substr(6).starts_with(',') && line[1] == 'G' &&
        std::all_of(line.begin() + 1, line.begin() + 6, is_capital))
      return true;
    // Receivers begin with a sentence of their own maker.
    text.remove_prefix(std::min(text.find('$', 1), text.size()));
  }
  return false;
}

/// "(1436509052.249713) can0 044#2A366C2BBA"
bool is_candump(std::string_view text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  const std::size_t close = line.find(") ");
  return line.starts_with('(') && close != std::string_view::npos &&
         line.find_first_not_of("0123456789.", 1) == close &&
         line.find('#', close) != std::string_view::npos;
}

void refuse_text(std::string_view head, const std::string& name) {
  const auto refuse = [&](std::string_view format, std::string_view way_out) {
    throw base::Error(fmt::format("{}: {}, which is not read; {}", name, format, way_out));
  };
  if (is_json(head)) refuse("JSON", "write it as CSV, a column for each name");
  if (is_nmea(head)) refuse("NMEA 0183", kOfNmea);
  if (is_candump(head))
    refuse("frames of a CAN bus", "decode them with the bus's database into CSV");
  std::size_t lines = 0;
  for (std::string_view rest = head; !rest.empty() && lines < 20; ++lines) {
    const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
    const std::string_view line = rest.substr(0, end);
    for (const NotRead& known : kTextNotRead)
      if (line.find(known.begin) != std::string_view::npos &&
          (lines == 0 || line.starts_with("# ")))
        refuse(known.format, known.way_out);
    rest.remove_prefix(end + 1);
  }
}

}  // namespace

void refuse_what_is_not_read(std::string_view bytes, const std::string& name) {
  // A table may begin with such letters; none has zeros.
  std::string_view head = bytes.substr(0, 4096);
  const bool binary = head.find('\0') != std::string_view::npos;
  if (binary && head.size() > 12 && head.substr(8, 4) == ".FIT")
    throw base::Error(
        fmt::format("{}: Garmin .fit, which is not read; write it as CSV (gpsbabel -t -i "
                    "garmin_fit -f LOG -o unicsv -F LOG.csv)",
                    name));
  if (!binary) head = base::trimmed(head.substr(head.starts_with("\xEF\xBB\xBF") ? 3 : 0));
  if (!binary) refuse_text(head, name);
  for (const NotRead& known : kNotRead)
    if (head.starts_with(known.begin) &&
        (binary || !std::isalnum(static_cast<unsigned char>(known.begin[0])) ||
         known.begin.starts_with("PK")))
      throw base::Error(
          fmt::format("{}: {}, which is not read; {}", name, known.format, known.way_out));
}

}  // namespace recording
