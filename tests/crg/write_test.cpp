#include <gtest/gtest.h>
#include <sys/stat.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <thread>

#include "crg/error.h"
#include "crg/file.h"
#include "crg/patches.h"
#include "roads.h"
#include "support/figure.h"

namespace crg {
namespace write_test {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Crg bumpy(std::size_t rows = 57, std::size_t columns = 13) {
  const ReferenceLine line = test::line_along(
      rows, 0.25, [](double u) { return 0.02 * std::sin(u); }, 4e5, -3e5, 1.0);
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  Crg crg = make_crg(
      line, test::grid_of(line, -2.0, 1.5, columns, [&](double, double) { return noise(random); }),
      {"Test road"});
  crg.grid.at(3, 0) = std::numeric_limits<float>::quiet_NaN();
  crg.grid.at(3, 1) = std::numeric_limits<float>::quiet_NaN();
  crg.banking.assign(rows, 0.03125);
  return crg;
}

template <typename Value>
void expect_same_bits(const std::vector<Value>& a, const std::vector<Value>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) && std::isnan(b[i])) continue;
    ASSERT_EQ(a[i], b[i]) << "at " << i;
    ASSERT_EQ(std::signbit(a[i]), std::signbit(b[i])) << "at " << i;
  }
}

TEST(Write, BinaryFormatsGiveBackEveryBit) {
  for (const Format format : {Format::KRBI, Format::KDBI}) {
    const Crg crg = bumpy();
    const Crg back = read_bytes(to_bytes(crg, format), "memory");
    EXPECT_EQ(back.format, format);
    expect_same_bits(back.grid.z_m, crg.grid.z_m);
    expect_same_bits(back.heading_rad, crg.heading_rad);
    expect_same_bits(back.banking, crg.banking);
    for (std::size_t j = 0; j < crg.grid.columns(); ++j)
      EXPECT_NEAR(back.grid.v_m[j], crg.grid.v_m[j], 1e-12);
    EXPECT_TRUE(back.notes.empty()) << back.notes[0];
  }
}

TEST(Write, DoublesThatFloatCannotHoldSurviveKdbi) {
  Crg crg = bumpy();
  crg.z_double_m.assign(crg.grid.z_m.begin(), crg.grid.z_m.end());
  crg.z_double_m[40] = 1.0 / 3.0;
  crg.grid.z_m[40] = static_cast<float>(1.0 / 3.0);
  const Crg back = read_bytes(to_bytes(crg, Format::KDBI), "memory");
  expect_same_bits(back.z_double_m, crg.z_double_m);
  expect_same_bits(back.grid.z_m, crg.grid.z_m);
}

TEST(Write, TextFormatsKeepThePrintedDigits) {
  const Crg crg = bumpy();
  const Crg narrow = read_bytes(to_bytes(crg, Format::LRFI), "memory");
  const Crg wide = read_bytes(to_bytes(crg, Format::LDFI), "memory");
  ASSERT_EQ(narrow.grid.z_m.size(), crg.grid.z_m.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < crg.grid.z_m.size(); ++i) {
    if (std::isnan(crg.grid.z_m[i])) {
      EXPECT_TRUE(std::isnan(narrow.grid.z_m[i]) && std::isnan(wide.grid.z_m[i]));
      continue;
    }
    // Ten characters leave at least five digits for "-0.00012345" in exponent form, seven for
    // values above 0.1; twenty always hold a float.
    EXPECT_NEAR(narrow.grid.z_m[i], crg.grid.z_m[i], 1e-5 * std::abs(crg.grid.z_m[i]));
    if (crg.grid.z_m[i] != 0.0f)
      worst =
          std::max(worst, std::abs(static_cast<double>(narrow.grid.z_m[i]) / crg.grid.z_m[i] - 1));
    EXPECT_EQ(wide.grid.z_m[i], crg.grid.z_m[i]);
  }
  support::figure("lrfi_share", worst);
  // What has been printed once is printed the same again.
  EXPECT_EQ(to_bytes(narrow, Format::LRFI),
            to_bytes(read_bytes(to_bytes(narrow, Format::LRFI), "memory"), Format::LRFI));
}

TEST(Write, HeaderLinesAreAtMost72ColumnsAndThePayloadFillsRecords) {
  Crg crg = bumpy();
  crg.comment = {std::string(300, 'x') + " and words " + std::string(60, 'y'),
                 "$looks like a section"};
  crg.virtual_channels = {"reference line u,m,0,0.25"};
  const std::string bytes = to_bytes(crg, Format::KRBI);
  const std::size_t separator = bytes.find("\n$$$$");
  ASSERT_NE(separator, std::string::npos);
  const std::size_t payload = bytes.find('\n', separator + 1) + 1;
  EXPECT_EQ((bytes.size() - payload) % 80, 0U);
  std::istringstream lines(bytes.substr(0, payload));
  std::string line;
  while (std::getline(lines, line)) EXPECT_LE(line.size(), 72U) << line;
  EXPECT_EQ(bytes.find('\r'), bytes.find('\r', payload));
  EXPECT_EQ(read_bytes(bytes, "memory").virtual_channels, crg.virtual_channels);
}

TEST(Write, EverySectionSurvivesTheRoundTrip) {
  Crg crg = bumpy();
  crg.options = {{.key = "*", .text = " how to go on"},
                 {.key = "BORDER_MODE_U", .value = 3.0, .comment = "repeat"}};
  crg.modifiers = {{.key = "SCALE_Z_GRID", .value = 0.1}};
  crg.projection = {{.key = "PROJ_NM", .text = "UTM_32N"}, {.key = "PROJ_F0", .value = 0.9996}};
  crg.other_sections = {{.name = "$VENDOR_STUFF ! theirs", .lines = {"a b c", "* d"}}};
  crg.other_channels = {{.definition = "reference line wetness,mm",
                         .values = std::vector<double>(crg.grid.rows(), 0.5)}};
  const Crg back = read_bytes(to_bytes(crg, Format::KDBI), "memory");
  ASSERT_EQ(back.options.size(), 2U);
  EXPECT_EQ(back.options[0].key, "*");
  EXPECT_EQ(back.options[0].text, " how to go on");
  EXPECT_EQ(back.options[1].value, 3.0);
  EXPECT_EQ(back.options[1].comment, "repeat");
  EXPECT_EQ(find_value(back.modifiers, "SCALE_Z_GRID"), 0.1);
  EXPECT_TRUE(back.has_modifier_section);
  ASSERT_EQ(back.projection.size(), 2U);
  EXPECT_EQ(back.projection[0].text, "UTM_32N");
  EXPECT_EQ(back.projection[1].value, 0.9996);
  ASSERT_EQ(back.other_sections.size(), 1U);
  EXPECT_EQ(back.other_sections[0].lines, crg.other_sections[0].lines);
  ASSERT_EQ(back.other_channels.size(), 1U);
  EXPECT_EQ(back.other_channels[0].values, crg.other_channels[0].values);
  EXPECT_EQ(back.comment, crg.comment);
}

// Such keys are indented in the file they come from; at the start of a line they mean something
// else.
TEST(Write, KeysThatLookLikeSectionsOrCommentsStayKeys) {
  Crg crg = read_bytes(
      "$ROAD_CRG\n $ODD = 1\n *KEY = 2\nREFERENCE_LINE_INCREMENT = 0.5\nLONG_SECTION_V_RIGHT = "
      "-3\nLONG_SECTION_V_INCREMENT = 1\n$\n"
      "$KD_DEFINITION\n#:LRFI\nD:long section 1,m\nD:long section 2,m\n$\n$$$$\n 1.0       2.0\n "
      "3.0       4.0\n",
      "odd.crg");
  const Crg back = read_bytes(to_bytes(crg, Format::KRBI), "back.crg");
  EXPECT_EQ(find_value(back.road, "$ODD"), 1.0);
  EXPECT_EQ(find_value(back.road, "*KEY"), 2.0);
  EXPECT_EQ(back.grid.u_step_m, 0.5);
  EXPECT_EQ(back.grid.v_m, crg.grid.v_m);
}

TEST(Write, UnevenColumnsAreNamedByPosition) {
  Crg crg = bumpy(20, 4);
  crg.grid.v_m = {-2.0, -1.25, 0.1, 1.5};
  const Crg back = read_bytes(to_bytes(crg, Format::LDFI), "memory");
  EXPECT_EQ(back.grid.v_m, crg.grid.v_m);
}

TEST(Write, ReplacesTheFileInOneStepAndLeavesNothingBehind) {
  const test::Folder folder;
  const std::string path = folder.file("road.crg");
  std::ofstream(path) << "old";
  write(bumpy(), path, Format::KRBI);
  EXPECT_EQ(read(path).grid.rows(), 57U);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.file("")))
    files += entry.exists() ? 1 : 0;
  EXPECT_EQ(files, 1U);
  EXPECT_THROW(write(bumpy(), folder.file("absent/road.crg"), Format::KRBI), Error);
}

TEST(Write, ALinkStaysALinkAndWhatIsNoFileIsWrittenThroughOrRefused) {
  namespace fs = std::filesystem;
  const test::Folder folder;
  std::ofstream(folder.file("real.crg")) << "old";
  fs::create_symlink("real.crg", folder.file("link.crg"));
  write(bumpy(), folder.file("link.crg"), Format::KRBI);
  EXPECT_TRUE(fs::is_symlink(folder.file("link.crg")));
  EXPECT_EQ(read(folder.file("real.crg")).grid.rows(), 57U);
  EXPECT_THROW(write(bumpy(), folder.file(""), Format::KRBI), Error);

  const std::string fifo = folder.file("fifo");
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THROW(read(fifo), Error);  // at once
  EXPECT_THROW(read_patch_index(fifo), Error);
  std::ostringstream received;
  {
    std::jthread reader([&] { received << std::ifstream(fifo, std::ios::binary).rdbuf(); });
    write(bumpy(), fifo, Format::KRBI);
  }
  EXPECT_EQ(received.str(), to_bytes(bumpy(), Format::KRBI));
  EXPECT_TRUE(fs::is_fifo(fifo));
  write(bumpy(), "/dev/null", Format::KRBI);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(Write, KdbiHeadingsKeepTheirLineWhenWrittenAsKrbi) {
  const ReferenceLine line =
      test::line_along(30000, 0.1, [](double u) { return 0.01 * std::sin(0.02 * u); });
  Crg crg = make_crg(line, test::grid_of(line, -1.0, 1.0, 2, [](double, double) { return 0.0; }));
  crg.heading_rad = line.heading_rad;
  set_value(crg.road, "REFERENCE_LINE_END_X", line.x_m.back());
  set_value(crg.road, "REFERENCE_LINE_END_Y", line.y_m.back());
  const ReferenceLine back =
      integrate_reference_line(read_bytes(to_bytes(crg, Format::KRBI), "memory"));
  double worst = 0.0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    worst = std::max(worst, std::hypot(back.x_m[i] - line.x_m[i], back.y_m[i] - line.y_m[i]));
  }
  EXPECT_LT(worst, 1e-7);  // measured 2e-8; plain rounding drifts by 1e-5
}

}  // namespace write_test
}  // namespace crg
