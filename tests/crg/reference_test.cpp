// Agreement with the answers of the reference C API 2.0.1 at pseudo-random points: on ASAM's sample
// files (see the README beside them; skipped where they are absent) and on roads of our own
// (tests/corpus/reference).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "crg/surface.h"
#include "roads.h"
#include "support/figure.h"
#include "support/places.h"

namespace crg {
namespace reference_test {

struct Case {
  std::string sample;
  ModifierUse modifiers = ModifierUse::ReferenceDefaults;
  std::map<std::string, double> options, extra_modifiers;
};

Case case_of(std::string name) {
  const std::map<std::string, Case> special = {
      {"scale_z", {"handmade_curved_banked_sloped", {}, {}, {{"SCALE_Z_GRID", 2.5}}}},
      {"scale_bank", {"handmade_curved_banked_sloped", {}, {}, {{"SCALE_BANKING", 3.0}}}},
      {"scale_len", {"handmade_curved_banked_sloped", {}, {}, {{"SCALE_LENGTH", 1.7}}}},
      {"curved_offsets",
       {"handmade_curved_banked_sloped",
        {},
        {{"BORDER_MODE_U", 2.0},
         {"BORDER_MODE_V", 2.0},
         {"BORDER_OFFSET_U", 0.25},
         {"BORDER_OFFSET_V", -0.5}},
        {}}},
      {"circle_close", {"handmade_circle", {}, {{"REFLINE_CONTINUATION", 1.0}}, {}}}};
  Case result;
  if (special.count(name) != 0) {
    result = special.at(name);
    result.modifiers = ModifierUse::ReferenceDefaults;
    return result;
  }
  const auto drop = [&](const std::string& suffix) {
    if (!name.ends_with(suffix)) return false;
    name.resize(name.size() - suffix.size());
    return true;
  };
  if (drop("_nomods")) result.modifiers = ModifierUse::None;
  for (int mode = 0; mode <= 4; ++mode) {
    if (drop("_bu" + std::to_string(mode))) result.options["BORDER_MODE_U"] = mode;
    if (drop("_bv" + std::to_string(mode))) result.options["BORDER_MODE_V"] = mode;
  }
  result.sample = name;
  return result;
}

std::vector<std::string> answer_files() {
  std::vector<std::string> names;
  const std::filesystem::path folder =
      std::filesystem::path(places::data()) / "opencrg" / "reference";
  if (std::filesystem::is_directory(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".csv") names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Reference, AnswersAgree) {
  const std::vector<std::string> names = answer_files();
  if (names.empty())
    GTEST_SKIP() << "no reference answers in " << places::data() << "/opencrg/reference";
  const std::filesystem::path data = std::filesystem::path(places::data()) / "opencrg";
  // The samples include each other as ../crg-txt/<name>.
  const test::Folder folder;
  for (const char* part : {"crg-txt", "here"}) {
    std::filesystem::create_directories(folder.file(part));
    for (const auto& entry : std::filesystem::directory_iterator(data / "samples")) {
      std::filesystem::copy_file(entry.path(),
                                 folder.file(part) + "/" + entry.path().filename().string());
    }
  }
  std::size_t compared = 0, corners = 0;
  double z_m = 0.0, place_m = 0.0, heading_rad = 0.0;  // worst
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const Case now = case_of(name);
    Crg crg = read(folder.file("here") + "/" + now.sample + ".crg");
    for (const auto& [key, value] : now.options) set_value(crg.options, key, value);
    if (!now.extra_modifiers.empty()) {
      crg.modifiers = reference_default_modifiers(crg);
      crg.has_modifier_section = true;
      for (const auto& [key, value] : now.extra_modifiers) set_value(crg.modifiers, key, value);
    }
    const Surface surface(std::move(crg), {.modifiers = now.modifiers});
    const ReferenceLine& line = surface.reference_line();
    const std::vector<double>& v_m = surface.grid().v_m;
    const double u_end = line.u_begin_m + static_cast<double>(line.size() - 1) * line.u_step_m;

    std::ifstream file(data / "reference" / (name + ".csv"));
    std::string text;
    while (std::getline(file, text)) {
      if (text.empty() || text[0] == '#' || text[0] == 'k') continue;
      std::replace(text.begin(), text.end(), ',', ' ');
      std::istringstream words(text);
      std::string kind, in1, in2, ret, out1, out2;
      words >> kind >> in1 >> in2 >> ret >> out1 >> out2;
      const double a = std::strtod(in1.c_str(), nullptr), b = std::strtod(in2.c_str(), nullptr);
      const double want1 = std::strtod(out1.c_str(), nullptr),
                   want2 = std::strtod(out2.c_str(), nullptr);
      const bool no_road = ret == "0" || std::isnan(want1);
      Cursor cursor;
      const auto expect_z = [&](double z) {
        if (no_road) {
          EXPECT_TRUE(std::isnan(z)) << text;
        } else {
          EXPECT_NEAR(z, want1, 1e-6) << text;
          z_m = std::max(z_m, std::abs(z - want1));
        }
      };
      // Decision 7: where both borders are left and v answers zero, zero it is (docs/opencrg.md).
      const auto zero_corner = [&](double u, double v) {
        const auto mode = now.options.find("BORDER_MODE_V");
        return mode != now.options.end() && mode->second == 1.0 &&
               (u < line.u_begin_m || u > u_end) && (v < v_m.front() || v > v_m.back());
      };
      ++compared;
      if (kind == "uv2z") {
        if (zero_corner(a, b)) {
          ++corners;
          EXPECT_EQ(surface.z_at_uv(a, b), 0.0);
        } else {
          expect_z(surface.z_at_uv(a, b));
        }
      } else if (kind == "uv2xy") {
        const Point2 point = surface.xy_of_uv(a, b);
        EXPECT_NEAR(point.x_m, want1, 1e-9) << text;
        EXPECT_NEAR(point.y_m, want2, 1e-9) << text;
        place_m = std::max({place_m, std::abs(point.x_m - want1), std::abs(point.y_m - want2)});
        const Sample sample = surface.at_uv(a, b);  // the same whether it has a height or not
        EXPECT_EQ(sample.x_m, point.x_m) << text;
        EXPECT_EQ(sample.y_m, point.y_m) << text;
      } else if (kind == "uv2pk") {
        const Sample sample = surface.at_uv(a, b);
        EXPECT_NEAR(sample.heading_rad, want1, 1e-9) << text;
        heading_rad = std::max(heading_rad, std::abs(sample.heading_rad - want1));
        EXPECT_NEAR(sample.curvature_1pm, want2, 1e-9) << text;
        EXPECT_EQ(surface.heading_at_uv(a, b).heading_rad, sample.heading_rad) << text;
        EXPECT_EQ(surface.heading_at_uv(a, b).curvature_1pm, sample.curvature_1pm) << text;
      } else if (kind == "xy2uv") {
        const UV uv = surface.uv_of_xy(a, b, cursor);
        EXPECT_NEAR(uv.u_m, want1, 1e-9) << text;
        EXPECT_NEAR(uv.v_m, want2, 1e-9) << text;
        place_m = std::max({place_m, std::abs(uv.u_m - want1), std::abs(uv.v_m - want2)});
        const Sample sample = surface.at_xy(a, b, cursor);
        EXPECT_EQ(sample.u_m, uv.u_m) << text;
        EXPECT_EQ(sample.v_m, uv.v_m) << text;
        EXPECT_TRUE(std::isfinite(sample.heading_rad)) << text;
      } else if (kind == "xy2z") {
        const Sample sample = surface.at_xy(a, b, cursor);
        if (!zero_corner(sample.u_m, sample.v_m)) expect_z(sample.z_m);
      } else {
        ADD_FAILURE() << "unknown kind: " << text;
      }
    }
  }
  EXPECT_GT(compared, 50000U);
  support::figure("files", static_cast<double>(names.size()));
  support::figure("z_m", z_m);
  support::figure("place_m", place_m);
  support::figure("heading_rad", heading_rad);
  EXPECT_EQ(corners, names.size() < 36 ? corners : 8U);
}

/// The answers of one file in tests/corpus/reference; its README says what the lines mean.
struct OwnRoad {
  std::string name;
  Surface surface;
  std::vector<std::string> lines;  ///< without the header
};

OwnRoad read_own_road(const std::filesystem::path& answers) {
  std::ifstream file(answers);
  std::vector<std::string> lines;
  std::map<std::string, double> options, modifiers;
  SurfaceOptions use{.modifiers = ModifierUse::ReferenceDefaults};
  std::string text, road;
  while (std::getline(file, text)) {
    if (text.front() == 'u') continue;
    if (text.front() != '#') {
      lines.push_back(text);
      continue;
    }
    std::istringstream words(text.substr(1));
    std::string kind, key;
    double value = 0.0;
    words >> kind >> key >> value;
    if (kind == "road") road = key;
    if (kind == "option") options[key] = value;
    if (kind == "modifier") modifiers[key] = value;
    if (kind == "modifiers" && key == "none") use.modifiers = ModifierUse::None;
  }
  Crg crg = read(places::source() + "/tests/corpus/" + road);
  for (const auto& [key, value] : options) set_value(crg.options, key, value);
  if (!modifiers.empty()) {
    if (!crg.has_modifier_section) crg.modifiers = reference_default_modifiers(crg);
    crg.has_modifier_section = true;
    for (const auto& [key, value] : modifiers) set_value(crg.modifiers, key, value);
  }
  return {answers.stem().string(), Surface(std::move(crg), use), std::move(lines)};
}

TEST(Reference, AnswersAgreeOnOurRoads) {
  std::size_t compared = 0, files = 0, seam = 0, beyond = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(places::source() + "/tests/corpus/reference")) {
    if (entry.path().extension() != ".csv") continue;
    const OwnRoad road = read_own_road(entry.path());
    SCOPED_TRACE(road.name);
    ++files;
    const Surface& surface = road.surface;
    const ReferenceLine& line_of_road = surface.reference_line();
    const std::vector<double>& v_m = surface.grid().v_m;
    const double u_begin = line_of_road.u_begin_m;
    const double u_end =
        u_begin + static_cast<double>(line_of_road.size() - 1) * line_of_road.u_step_m;
    for (std::string line : road.lines) {
      SCOPED_TRACE(line);
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream words(line);
      std::vector<std::string> cells(12);
      for (std::string& cell : cells) words >> cell;
      const auto number = [&](std::size_t column) {
        return std::strtod(cells[column].c_str(), nullptr);
      };
      const auto expect_height = [&](double z, std::size_t column) {
        if (cells[column] == "none" || cells[column] == "nan") {
          EXPECT_TRUE(std::isnan(z)) << z;
        } else {
          EXPECT_NEAR(z, number(column), 1e-6);
        }
      };
      // Beyond an end the line goes on along the heading in the header, of more digits than the
      // rows of a file of text.
      const auto tolerance = [&](double u) { return u < u_begin || u > u_end ? 1e-7 : 1e-9; };
      const double u = number(0), v = number(1);
      ++compared;
      const Sample there = surface.at_uv(u, v);
      // Decisions 15 and 16: a closed track has mitres and curvature of its own at the seam.
      if (line_of_road.closed && (there.u_m < u_begin + line_of_road.u_step_m ||
                                  there.u_m > u_end - line_of_road.u_step_m)) {
        ++seam;
        continue;
      }
      // Banking ends at the sides, also where the grid repeats beyond them; of sections by number
      // the C API repeats it.
      const bool banking_differs = road.name == "reflect" && (v < v_m.front() || v > v_m.back());
      if (banking_differs) {
        ++beyond;
      } else {
        expect_height(surface.z_at_uv(u, v), 2);
      }
      EXPECT_NEAR(there.x_m, number(3), tolerance(u));
      EXPECT_NEAR(there.y_m, number(4), tolerance(u));
      EXPECT_NEAR(there.heading_rad, number(5), 1e-9);
      EXPECT_NEAR(there.curvature_1pm, number(6), 1e-9);
      Cursor cursor;
      const Sample back = surface.at_xy(number(7), number(8), cursor);
      EXPECT_NEAR(back.u_m, number(9), tolerance(u));
      EXPECT_NEAR(back.v_m, number(10), tolerance(u));
      if (!banking_differs) expect_height(back.z_m, 11);
    }
  }
  EXPECT_EQ(files, 9U);
  EXPECT_EQ(compared, files * 200);
  EXPECT_LE(seam, 40U);
  EXPECT_LE(beyond, 60U);
}

}  // namespace reference_test
}  // namespace crg
