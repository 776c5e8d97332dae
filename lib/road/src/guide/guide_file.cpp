#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <string_view>

#include "base/csv.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "guide_recording.h"
#include "mesh/error.h"
#include "road/guide.h"

namespace road {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr std::size_t kLargestFileBytes = 256'000'000;
constexpr std::size_t kLargestTreeBytes =
    20'000'000;  // XML and JSON take up to sixty times as much memory
constexpr std::size_t kMostPointsOfFile = 5'000'000;
constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kWanted =
    "a guide is wanted: CSV with x_m,y_m[,z_m] or lat_deg,lon_deg[,h_m], GPX, KML, GeoJSON or a "
    "log with latitude and longitude";

/// NaN where the word is no number.
double number(std::string_view word) {
  while (!word.empty() && std::isspace(static_cast<unsigned char>(word.front())) != 0)
    word.remove_prefix(1);
  while (!word.empty() && std::isspace(static_cast<unsigned char>(word.back())) != 0)
    word.remove_suffix(1);
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = kNoHeight;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? value : kNoHeight;
}

/// The columns of a CSV as its first line that is no remark names them, in lower case.
std::vector<std::string> columns_of(std::string_view text) {
  base::Lines lines(text);
  std::string_view line;
  while (lines.next(line) && base::is_blank_or_remark(line)) {
  }
  line = line.substr(0, 10000);
  std::vector<std::string_view> cells;
  base::split_cells(line, base::separator_of(line), cells);
  std::vector<std::string> names(cells.begin(), cells.end());
  for (std::string& name : names)
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return names;
}

GuideFile from_csv(const std::string& path, std::string_view text) {
  const std::vector<std::string> columns = columns_of(text);
  const auto has = [&](const char* name) {
    return std::count(columns.begin(), columns.end(), name) > 0;
  };
  GuideFile guide;
  guide.geographic = !has("x_m");
  const bool written_out = has("latitude");
  if (guide.geographic && !written_out && !has("lat_deg")) {
    try {
      return guide_of_log(path);
    } catch (const Error& error) {
      throw Error(fmt::format("{}; {}", error.what(), kWanted));
    }
  }
  const auto read = [&](const std::vector<std::string>& place, const char* height) {
    return base::read_csv(path, place, {height}, base::Gaps::allowed);
  };
  const base::CsvTable table = !guide.geographic ? read({"x_m", "y_m"}, "z_m")
                               : written_out     ? read({"latitude", "longitude"}, "height")
                                                 : read({"lat_deg", "lon_deg"}, "h_m");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double z_m = table.present[2] ? table.value(i, 2) : kNoHeight;
    const Vector3d point(table.value(i, 0), table.value(i, 1), z_m);
    if (std::isfinite(point.x()) && std::isfinite(point.y())) guide.points.push_back(point);
  }
  return guide;
}

/// Latitude, longitude and height from three words, of which the last may be missing.
Vector3d position(std::string_view latitude, std::string_view longitude, std::string_view height) {
  return {number(latitude), number(longitude), number(height)};
}

/// KML's list of "longitude,latitude[,height]", parted by blanks.
Points coordinates(const char* text) {
  Points points;
  std::istringstream words{text};
  for (std::string word; words >> word && points.size() < kMostPointsOfFile;) {
    const std::size_t first = word.find(','), second = word.find(',', first + 1);
    if (first == std::string::npos) continue;
    const std::string_view view = word;
    points.push_back(position(view.substr(first + 1, second - first - 1), view.substr(0, first),
                              second == std::string::npos ? "" : view.substr(second + 1)));
  }
  return points;
}

/// The lines that an XML file holds, whatever they are nested in.
struct Lines : pugi::xml_tree_walker {
  std::vector<Points> lines;
  pugi::xml_node of;  ///< whose points the last line holds

  void add(const pugi::xml_node& owner, const Vector3d& point) {
    if (lines.empty() || owner != of) lines.emplace_back();
    of = owner;
    lines.back().push_back(point);
  }

  bool for_each(pugi::xml_node& node) override {
    const std::string_view name = node.name();
    if (name == "trkpt" || name == "rtept") {
      const pugi::xml_node part = node.parent();
      // A track in several pieces is one way.
      add(name == "trkpt" ? part.parent() : part,
          position(node.attribute("lat").value(), node.attribute("lon").value(),
                   node.child_value("ele")));
    } else if (name == "coordinates") {
      const std::string_view parent = node.parent().name();
      if (parent == "LineString" || parent == "LinearRing")
        lines.push_back(coordinates(node.child_value()));
      of = node;
    } else if (name == "gx:coord") {
      std::istringstream words{node.child_value()};
      std::string longitude, latitude, height;
      words >> longitude >> latitude >> height;
      add(node.parent(), position(latitude, longitude, height));
    }
    return true;
  }
};

GuideFile from_xml(const std::string& path, std::string_view text) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed) {
    const auto line =
        1 + std::count(text.begin(),
                       text.begin() + std::min<std::ptrdiff_t>(parsed.offset, std::ssize(text)),
                       '\n');
    throw Error(fmt::format("{}:{}: no XML: {}; {}", path, line, parsed.description(), kWanted));
  }
  Lines found;
  document.traverse(found);
  if (found.lines.empty())
    throw Error(
        fmt::format("{}: XML without a track, route or line (trkpt, rtept, LineString, LinearRing, "
                    "gx:Track); {}",
                    path, kWanted));
  const auto longest =
      std::max_element(found.lines.begin(), found.lines.end(),
                       [](const Points& a, const Points& b) { return a.size() < b.size(); });
  return {true, std::move(*longest)};
}

/// The longest list of positions in a GeoJSON object of any kind.
void longest_line(const nlohmann::json& object, int depth, Points& longest) {
  if (depth > 8 || !object.is_object()) return;
  for (const char* list : {"features", "geometries"})
    if (const auto members = object.find(list); members != object.end() && members->is_array())
      for (const auto& member : *members) longest_line(member, depth + 1, longest);
  if (const auto geometry = object.find("geometry"); geometry != object.end())
    longest_line(*geometry, depth + 1, longest);
  const auto coordinates = object.find("coordinates");
  const auto type = object.find("type");
  if (coordinates == object.end() || type == object.end() || !type->is_string()) return;
  const auto take = [&](const nlohmann::json& list) {
    if (!list.is_array() || list.size() <= longest.size()) return;
    Points points;
    for (const auto& at : list) {
      const auto value = [&](std::size_t k) {
        return at.size() > k && at[k].is_number() ? at[k].get<double>() : kNoHeight;
      };
      if (!at.is_array()) return;
      points.emplace_back(value(1), value(0), value(2));
    }
    longest = std::move(points);
  };
  if (*type == "LineString") take(*coordinates);
  if ((*type == "MultiLineString" || *type == "Polygon") && coordinates->is_array())
    for (const auto& line : *coordinates) take(line);
}

GuideFile from_json(const std::string& path, std::string_view text) {
  GuideFile guide;
  guide.geographic = true;
  try {
    longest_line(base::parse_json<nlohmann::json>(text), 0, guide.points);
  } catch (const nlohmann::json::exception& error) {
    throw Error(fmt::format("{}: no GeoJSON: {}; {}", path, error.what(), kWanted));
  }
  if (guide.points.empty())
    throw Error(fmt::format("{}: JSON without a LineString, MultiLineString or Polygon; {}", path,
                            kWanted));
  return guide;
}

}  // namespace

GuideFile read_guide(const std::string& path, const std::string& mapping_path) {
  const std::string text = base::read_file(path, kLargestFileBytes);
  std::string_view begin = text;
  if (begin.starts_with("\xEF\xBB\xBF")) begin.remove_prefix(3);
  while (!begin.empty() && std::isspace(static_cast<unsigned char>(begin.front())) != 0)
    begin.remove_prefix(1);
  const bool is_tree = mapping_path.empty() && (begin.starts_with('<') || begin.starts_with('{'));
  if (is_tree && text.size() > kLargestTreeBytes)
    throw Error(
        fmt::format("{}: {} bytes; GPX, KML and GeoJSON are read up to {}; thin the line, a few "
                    "thousand points are enough",
                    path, text.size(), kLargestTreeBytes));
  GuideFile guide = !mapping_path.empty()    ? guide_of_log(path, mapping_path)
                    : begin.starts_with('<') ? from_xml(path, begin)
                    : begin.starts_with('{') ? from_json(path, begin)
                                             : from_csv(path, begin);
  if (guide.points.size() < 3)
    throw Error(fmt::format("{}: {} positions; a guide has at least 3, in the order of driving",
                            path, guide.points.size()));
  if (guide.points.size() > kMostPointsOfFile)
    throw Error(fmt::format("{}: {} positions; at most {} are read, a few thousand are enough",
                            path, guide.points.size(), kMostPointsOfFile));
  for (std::size_t i = 0; i < guide.points.size(); ++i) {
    const Vector3d& p = guide.points[i];
    const bool good = guide.geographic ? std::abs(p.x()) <= 90.0 && std::abs(p.y()) <= 180.0
                                       : std::abs(p.x()) <= 1e8 && std::abs(p.y()) <= 1e8;
    if (!good)  // NaN too
      throw Error(fmt::format("{}: position {} is ({}, {}); wanted {}", path, i + 1, p.x(), p.y(),
                              guide.geographic
                                  ? "latitude and longitude in degrees; positions in the frame of "
                                    "the mesh are given as CSV with x_m,y_m"
                                  : "metres within 1e8 of the origin"));
    if (!(std::abs(p.z()) < 1e6)) guide.points[i].z() = kNoHeight;
  }
  return guide;
}

}  // namespace road
