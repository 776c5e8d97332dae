// What read() accepts, refuses and says about it. The numbers in test names are those of the list
// "Where the standard and its tools disagree" in docs/opencrg.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "crg/error.h"
#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace read_test {

using testing::HasSubstr;

// Two rows, two columns in text; `road` and `definition` lines are put into their sections.
std::string text_file(
    const std::string& road = "",
    const std::string& definition = "#:LRFI\nD:long section 1,m\nD:long section 2,m\n",
    const std::string& payload = " 1.0       2.0\n 3.0       4.0\n",
    const std::string& sections = "") {
  return "$CT\nroad\n$\n$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 1.0\nLONG_SECTION_V_RIGHT = "
         "-1\nLONG_SECTION_V_LEFT = 1\n" +
         road + "$\n" + sections + "$KD_DEFINITION\n" + definition + "$\n$$$$\n" + payload;
}

Crg read_text(const std::string& bytes) { return read_bytes(bytes, "road.crg"); }

std::string refusal(const std::string& bytes) {
  try {
    read_text(bytes);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

Crg small_road(std::size_t rows = 6) {
  const ReferenceLine line = test::line_along(rows, 1.0, [](double) { return 0.0; });
  return make_crg(
      line, test::grid_of(line, -1.0, 1.0, 3, [](double u, double v) { return u + 0.5 * v; }));
}

// The file without one header line.
std::string without(std::string bytes, const std::string& key) {
  const std::size_t at = bytes.find(key);
  return bytes.erase(at, bytes.find('\n', at) + 1 - at);
}

std::string with_value(std::string bytes, const std::string& key, const std::string& value) {
  const std::size_t at = bytes.find('=', bytes.find(key));
  return bytes.replace(at, bytes.find('\n', at) - at, "= " + value);
}

TEST(Read, TextInBothLineEndingsAndAnyLetterCase) {
  std::string bytes = text_file();
  const Crg unix_lines = read_text(bytes);
  for (std::size_t at = 0; (at = bytes.find('\n', at)) != std::string::npos; at += 2)
    bytes.replace(at, 1, "\r\n");
  const Crg dos_lines = read_text(bytes);
  EXPECT_EQ(unix_lines.grid.z_m, (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(dos_lines.grid.z_m, unix_lines.grid.z_m);
  EXPECT_EQ(unix_lines.grid.v_m, (std::vector<double>{-1, 1}));
  EXPECT_EQ(
      read_text("$road_crg\nreference_line_increment=2 ! two\nlong_section_v_increment = "
                "0.5\n$\n$kd_definition\n#:ldfi\nd:Long Section 1,M\nD:LONG SECTION 2,m\n$\n$$\n"
                " 1                   2\n 3                   4\n")
          .grid.u_step_m,
      2.0);
}

TEST(Read, ColumnsInAnyOrderAreSortedByV) {
  const Crg crg = read_text(text_file("",
                                      "#:LRFI\nD:long section at v = 0.5,m\nD:reference line "
                                      "phi,rad\nD:long section at v = -0.25,m\n",
                                      " 1.0      **unused** 2.0\n 3.0      0.1        4.0\n"));
  EXPECT_EQ(crg.grid.v_m, (std::vector<double>{-0.25, 0.5}));
  EXPECT_EQ(crg.grid.z_m, (std::vector<float>{2, 1, 4, 3}));
}

TEST(Read, NanInTextIsAnythingWithAStrangeCharacter) {
  const Crg crg = read_text(text_file("", "#:LRFI\nD:long section 1,m\nD:long section 2,m\n",
                                      " *missing*       nan\n**unused**  12.5D-1\n"));
  EXPECT_TRUE(std::isnan(crg.grid.z_m[0]));
  EXPECT_TRUE(std::isnan(crg.grid.z_m[1]));
  EXPECT_EQ(crg.grid.z_m[2], 0.0F);
  EXPECT_EQ(crg.grid.z_m[3], 1.25F);
}

TEST(Read, Decision01ZeroGapClosesATrack) {
  ReferenceLine line = test::circuit(401, 20.0, 0.0, 1);
  Crg crg = make_crg(line, test::grid_of(line, -2.0, 2.0, 3, [](double, double) { return 0.0; }));
  // Exactly on the first node.
  crg.x_m = line.x_m, crg.y_m = line.y_m;
  crg.x_m.back() = crg.x_m.front(), crg.y_m.back() = crg.y_m.front();
  const ReferenceLine closed = integrate_reference_line(crg);
  EXPECT_EQ(
      std::hypot(closed.x_m.back() - closed.x_m.front(), closed.y_m.back() - closed.y_m.front()),
      0.0);
  EXPECT_TRUE(closed.closed);
}

TEST(Read, Decision02ClosingHoldsForMapPointsToo) {
  const ReferenceLine line = test::circuit(401, 20.0, 0.0, 1);
  const Crg crg =
      make_crg(line, test::grid_of(line, -2.0, 2.0, 3, [](double, double) { return 0.0; }));
  const Surface surface(crg);
  Cursor cursor;
  const double length = line.u_step_m * 400.0;
  const Point2 p = surface.xy_of_uv(length + 0.25, 1.0);
  const UV uv = surface.uv_of_xy(p.x_m, p.y_m, cursor);
  EXPECT_NEAR(uv.u_m, 0.25 - 1e-3, 2e-3);
  EXPECT_NEAR(uv.v_m, 1.0, 1e-9);
}

TEST(Read, Decision03NoFormatLineMeansKrbi) {
  std::string bytes = to_bytes(small_road(), Format::KRBI);
  const Crg crg = read_text(without(bytes, "#:KRBI"));
  EXPECT_EQ(crg.format, Format::KRBI);
  EXPECT_EQ(crg.grid.z_m, small_road().grid.z_m);
  ASSERT_EQ(crg.notes.size(), 1U);
  EXPECT_THAT(crg.notes[0], HasSubstr("default is KRBI"));
}

TEST(Read, Decision04RowsOfBinaryFilesComeFromThePayloadWithoutEndU) {
  const Crg road = small_road(31);  // 31 rows of 4 values: the padding could hold further rows
  for (const Format format : {Format::KRBI, Format::KDBI}) {
    const Crg crg = read_text(without(to_bytes(road, format), "REFERENCE_LINE_END_U"));
    EXPECT_EQ(crg.grid.z_m, road.grid.z_m);
  }
  EXPECT_THAT(refusal(with_value(to_bytes(road, Format::KRBI), "REFERENCE_LINE_END_U", "500")),
              HasSubstr("END_U announces 501"));
  const Crg shorter =
      read_text(with_value(to_bytes(road, Format::KRBI), "REFERENCE_LINE_END_U", "10"));
  EXPECT_EQ(shorter.grid.rows(), 11U);
  ASSERT_FALSE(shorter.notes.empty());
  EXPECT_THAT(shorter.notes[0], HasSubstr("behind END_U"));
}

TEST(Read, Decision05NumberedSectionsDeriveTheirStep) {
  EXPECT_EQ(read_text(text_file()).grid.v_m, (std::vector<double>{-1, 1}));
  EXPECT_THAT(refusal(without(text_file(), "LONG_SECTION_V_LEFT")),
              HasSubstr("LONG_SECTION_V_INCREMENT is missing"));
}

TEST(Read, Decision06HeaderOffsetsAreKeptAndNotApplied) {
  const Crg crg =
      read_text(text_file("REFERENCE_LINE_OFFSET_X = 500000\nREFERENCE_LINE_OFFSET_PHI = 1\n"));
  EXPECT_EQ(find_value(crg.road, "REFERENCE_LINE_OFFSET_X"), 500000.0);
  EXPECT_EQ(Surface(crg).xy_of_uv(0.0, 0.0).x_m, 0.0);
}

TEST(Read, Decision10And13IncludesKeepWhatTheyHaveAndAreFoundBesideTheFile) {
  const test::Folder folder;
  std::filesystem::create_directories(folder.file("sub"));
  Crg inner = small_road();
  set_value(inner.options, "BORDER_MODE_U", 3.0);
  set_value(inner.modifiers, "SCALE_Z_GRID", 2.0);
  write(inner, folder.file("sub/data.crg"), Format::KRBI);
  std::ofstream(folder.file("outer.crg"))
      << "$CT\nouter\n$\n$ROAD_CRG_FILE\n* where\n  sub/\n  data.crg ! beside this "
         "file\n$\n$ROAD_CRG_MODS\n$\n$ROAD_CRG\nREFERENCE_LINE_END_X = 99\n$\n";
  const Crg crg = read(folder.file("outer.crg"));
  EXPECT_EQ(crg.grid.z_m, inner.grid.z_m);
  EXPECT_EQ(find_value(crg.options, "BORDER_MODE_U"), 3.0)
      << "kept: the including file has no such section";
  EXPECT_TRUE(crg.modifiers.empty()) << "replaced by the empty section of the including file";
  EXPECT_EQ(find_value(crg.road, "REFERENCE_LINE_END_X"),
            find_value(inner.road, "REFERENCE_LINE_END_X"));
  EXPECT_EQ(find_value(crg.road, "LONG_SECTION_V_INCREMENT"), 1.0);
  EXPECT_EQ(crg.comment[0], "outer");
  ::setenv("CRG_TEST_ROADS", folder.file("sub").c_str(), 1);
  std::ofstream(folder.file("variable.crg")) << "$ROAD_CRG_FILE\n $CRG_TEST_ROADS/data.crg\n$\n";
  EXPECT_EQ(read(folder.file("variable.crg")).grid.rows(), 6U);
  std::ofstream(folder.file("twice.crg")) << "$ROAD_CRG_FILE\n outer.crg\n$\n";
  EXPECT_THROW(read(folder.file("twice.crg")), Error);
  std::ofstream(folder.file("absent.crg")) << "$ROAD_CRG_FILE\n $CRG_TEST_ABSENT/x.crg\n$\n";
  EXPECT_THROW(read(folder.file("absent.crg")), Error);
}

// The line ends, in plan and height, where the included file says, whatever the including file
// says.
TEST(Read, Decision10TheRoadEndsWhereTheIncludedFileSays) {
  const test::Folder folder;
  std::ofstream(folder.file("data.crg"))
      << "$ROAD_CRG\nREFERENCE_LINE_START_U = 0\nREFERENCE_LINE_END_U = "
         "3\nREFERENCE_LINE_INCREMENT = 1\n"
         "REFERENCE_LINE_START_X = 10\nREFERENCE_LINE_START_Y = 20\nREFERENCE_LINE_START_Z = 1\n"
         "REFERENCE_LINE_END_X = 13.003\nREFERENCE_LINE_END_Y = 20.006\nREFERENCE_LINE_END_Z = "
         "2.5\n$\n"
         "$KD_DEFINITION\n#:LRFI\nD:reference line phi,rad\nD:long section at v = -2,m\n"
         "D:long section at v = -0.5,m\nD:long section at v = 3,m\n$\n$$$$\n"
         "**unused**       0.0       0.5       1.0\n       0.0       0.0       0.5       1.0\n"
         "       0.0       0.0       0.5       1.0\n       0.0       0.0       0.5       1.0\n";
  std::ofstream(folder.file("outer.crg"))
      << "$ROAD_CRG_FILE\ndata.crg\n$\n$ROAD_CRG\nREFERENCE_LINE_END_X = 99\nREFERENCE_LINE_END_Y "
         "= -99\n"
         "REFERENCE_LINE_END_Z = 50\nLONG_SECTION_V_INCREMENT = 7\nLONG_SECTION_V_RIGHT = -9\n$\n";
  const Surface surface(read(folder.file("outer.crg")));
  const Point2 end = surface.xy_of_uv(3.0, 0.0);
  EXPECT_NEAR(end.x_m, 13.003, 1e-12);
  EXPECT_NEAR(end.y_m, 20.006, 1e-12);
  EXPECT_NEAR(surface.z_at_uv(3.0, -2.0), 2.5, 1e-12);
  EXPECT_NEAR(surface.z_at_uv(3.0, -0.5), 3.0, 1e-12);
  EXPECT_NEAR(surface.z_at_uv(0.0, 1.25), 1.75, 1e-12)
      << "half way between the sections at -0.5 and 3";
  EXPECT_EQ(surface.grid().v_m, (std::vector<double>{-2.0, -0.5, 3.0}));
  EXPECT_FALSE(surface.file().notes.empty()) << "what was ignored is said";
}

TEST(Read, Decision11RowsOfNanAndHolesAreAccepted) {
  Crg crg = small_road();
  for (std::size_t j = 0; j < 3; ++j) crg.grid.at(2, j) = NAN;
  crg.grid.at(4, 1) = NAN;
  const Surface surface(read_text(to_bytes(crg, Format::KRBI)));
  EXPECT_TRUE(std::isnan(surface.z_at_uv(2.0, 0.0)));
  EXPECT_TRUE(std::isnan(surface.z_at_uv(3.5, 0.1)));
  EXPECT_EQ(surface.z_at_uv(0.5, 0.0), 0.5);
}

TEST(Read, Decision12ExponentsWithDAreNumbers) {
  EXPECT_EQ(read_text(text_file("", "#:LRFI\nD:long section 1,m\nD:long section 2,m\n",
                                " 1.0D+01  -2.5d-1\n 3.0       4.0\n"))
                .grid.z_m[1],
            -0.25F);
}

TEST(Read, RefusalsNameFileAndPlaceAndWhatWasWanted) {
  EXPECT_EQ(refusal(text_file("REFERENCE_LINE_START_X = abc\n")),
            "road.crg:8: REFERENCE_LINE_START_X = \"abc\": want a finite number");
  EXPECT_THAT(refusal(text_file("", "#:LRFI\nD:long section 1,m\nD:long section 2,m\n",
                                " 1.0       2.0\n 3.0\n")),
              HasSubstr("road.crg:16: the record ends before channel 2"));
  EXPECT_THAT(refusal(text_file("", "#:LRFI\nD:long section 1,m\nD:long section 2,m\n",
                                " 1.0       2.0\n 1.2.3     4.0\n")),
              HasSubstr("road.crg:16: \" 1.2.3    \" is not a number"));
  EXPECT_THAT(refusal(text_file("", "#:XYZ\n")),
              HasSubstr("road.crg:10: data format \"XYZ\", want KRBI"));
  EXPECT_THAT(refusal(text_file("", "#:LRFI\nD:long section 1,m\nD:long section at v = 2,m\n")),
              HasSubstr("both by number and by v"));
  EXPECT_THAT(refusal(text_file("", "#:LRFI\nD:long section 1,mm\n")),
              HasSubstr("unit \"mm\", want m"));
  EXPECT_THAT(refusal(text_file("", "#:LRFI\nD:long section 1,m\nD:long section 1,m\n")),
              HasSubstr("road.crg:12"));
  EXPECT_THAT(refusal(without(text_file(), "REFERENCE_LINE_INCREMENT")),
              HasSubstr("REFERENCE_LINE_INCREMENT is missing"));
  EXPECT_THAT(refusal("$CT\nnothing\n$\n"), HasSubstr("there is no road in this file"));
  EXPECT_THAT(refusal(""), HasSubstr("road.crg: no $KD_DEFINITION"));
  std::string damaged = to_bytes(small_road(), Format::KRBI);
  const std::size_t payload = damaged.find('\n', damaged.find("\n$$$$") + 1) + 1;
  damaged.replace(payload + 8, 4, "\x7f\x00\x00\x00", 4);  // 1.7e38 as height 1 of row 0
  EXPECT_THAT(refusal(damaged), HasSubstr("byte " + std::to_string(payload + 8) + ": value 1.70"));
  EXPECT_THROW(read("/nowhere/road.crg"), Error);
  EXPECT_THROW(read("/"), Error);
}

TEST(Read, HeadersMayLieAboutSizesWithoutCostingMemory) {
  std::string bytes =
      with_value(to_bytes(small_road(), Format::LRFI), "REFERENCE_LINE_END_U", "1e11");
  EXPECT_THAT(refusal(bytes), HasSubstr("END_U announces 100000000001"));
  bytes = with_value(to_bytes(small_road(), Format::KDBI), "REFERENCE_LINE_END_U", "1e11");
  EXPECT_THAT(refusal(bytes), HasSubstr("END_U announces 100000000001"));
}

TEST(Read, ReadFromDiskEqualsReadFromMemory) {
  const test::Folder folder;
  const ReferenceLine line = test::line_along(3000, 0.1, [](double) { return 0.001; });
  const Crg crg = make_crg(line, test::grid_of(line, -5.0, 5.0, 101,
                                               [](double u, double v) { return std::sin(u) * v; }));
  for (const Format format : {Format::KRBI, Format::KDBI, Format::LRFI, Format::LDFI}) {
    write(crg, folder.file("road.crg"), format);
    const Crg disk = read(folder.file("road.crg"));
    const Crg memory = read_text(to_bytes(crg, format));
    EXPECT_EQ(disk.grid.z_m, memory.grid.z_m);
    EXPECT_EQ(disk.heading_rad, memory.heading_rad);
    EXPECT_EQ(disk.source, folder.file("road.crg"));
  }
}

}  // namespace read_test
}  // namespace crg
