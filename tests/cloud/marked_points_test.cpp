// Points that their file calls noise, withheld or synthetic.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "cloud/error.h"
#include "cloud/map_scans.h"
#include "cloud/read_cloud.h"
#include "support/cloud_files.h"
#include "support/laz_file.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "support/wavy_road.h"

namespace cloud {
namespace marked_points_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// What is set of point i; all others are plain.
enum Mark {
  low_noise = 3,
  high_noise = 5,
  synthetic = 7,
  key = 9,
  withheld = 11,
  overlap = 13,
  first_of_two = 15,
  last_of_two = 17,
  no_return = 18
};
constexpr std::size_t kPoints = 20;

int class_of(std::size_t i, bool old) {
  return i == low_noise ? 7 : i == high_noise ? 18 : i == overlap && old ? 12 : 2;
}

std::string marked_las(int minor, int format) {
  std::string las = support::as_las({}, minor, format);
  const std::size_t length = (las.size() - (minor == 4 ? 375 : 227)) / kPoints;
  const bool old = format < 6;
  for (std::size_t i = 0; i < kPoints; ++i) {
    char* const record = las.data() + las.size() - (kPoints - i) * length;
    int flags = 0;
    if (i == synthetic) flags = old ? 0x20 : 0x01;
    if (i == key) flags = old ? 0x40 : 0x02;
    if (i == withheld) flags = old ? 0x80 : 0x04;
    if (i == overlap && !old) flags = 0x08;
    const int number = i == last_of_two ? 2
                       : i == no_return ? 0
                                        : 1,
              returns = i == first_of_two || i == last_of_two ? 2
                        : i == no_return                      ? 0
                                                              : 1;
    record[14] = static_cast<char>(number | returns << (old ? 3 : 4));
    record[15] = static_cast<char>(flags | (old ? class_of(i, old) : 0));
    if (!old) record[16] = static_cast<char>(class_of(i, old));
  }
  return las;
}

/// Columns as PDAL names them, or others.
std::string marked_text(const char* classes, const char* mark) {
  std::string text =
      fmt::format("x,y,z,{},{},Synthetic,ReturnNumber,Number_of_Returns\n", classes, mark);
  for (std::size_t i = 0; i < kPoints; ++i)
    text += fmt::format("{},{},{},{},{},{},{},{}\n", 0.25 * static_cast<double>(i), 1.5, 0.0,
                        class_of(i, true), i == withheld ? 1 : 0, i == synthetic ? 1 : 0,
                        i == last_of_two ? 2 : 1, i == first_of_two || i == last_of_two ? 2 : 1);
  return text;
}

std::string marked_ply() {
  std::string text = marked_text("", "");
  text = text.substr(text.find('\n') + 1);
  for (char& c : text)
    if (c == ',') c = ' ';
  return fmt::format(
             "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double "
             "y\nproperty double z\nproperty uchar Classification\nproperty uchar "
             "Withheld\nproperty uchar Synthetic\nproperty uchar ReturnNumber\nproperty uchar "
             "NumberOfReturns\nend_header\n",
             kPoints) +
         text;
}

std::map<std::string, std::string> marked_files() {
  return {{"1.las", marked_las(2, 1)},
          {"6.las", marked_las(4, 6)},
          {"1.laz", support::as_laz(marked_las(2, 1))},
          {"6.laz", support::as_laz(marked_las(4, 6))},
          {"a.csv", marked_text("Classification", "Withheld")},
          {"a.ply", marked_ply()}};
}

TEST(MarkedPoints, AreLeftOutWhereThatIsAskedFor) {
  const support::TemporaryFolder folder;
  for (const auto& [name, bytes] : marked_files()) {
    SCOPED_TRACE(name);
    CloudReadOptions options;
    CloudReadReport report;
    const Cloud all = read_cloud(folder.file(name, bytes), options, &report);
    EXPECT_EQ(all.size(), kPoints);
    EXPECT_THAT(report.remarks, IsEmpty());
    options.leave_out_marked = true;
    options.chunk_points = 1;  // some hold nothing
    const Cloud some = read_cloud(folder.path(name), options, &report);
    ASSERT_EQ(some.size(), kPoints - 5);
    for (std::size_t i = 0, k = 0; i < kPoints; ++i) {
      if (i == low_noise || i == high_noise || i == withheld || i == overlap || i == first_of_two)
        continue;
      EXPECT_EQ(some.x_m[k], all.x_m[i]);
      EXPECT_EQ(some.classification[k], all.classification[i]);
      ++k;
    }
    EXPECT_EQ(report.points, kPoints - 5);
    EXPECT_EQ(report.marked.noise, 2u);
    EXPECT_EQ(report.marked.withheld, 1u);
    EXPECT_EQ(report.marked.overlap, 1u);
    EXPECT_EQ(report.marked.not_last, 1u);
    EXPECT_EQ(report.marked.synthetic, 1u);
  }
}

// Version 1.0 has the whole byte for the class; of labels nobody knows what 7 and 18 are.
TEST(MarkedPoints, NothingElseIsLeftOut) {
  const support::TemporaryFolder folder;
  CloudReadOptions options;
  options.leave_out_marked = true;
  CloudReadReport report;
  const Cloud old = read_cloud(folder.file("a.las", marked_las(0, 1)), options, &report);
  EXPECT_EQ(old.size(), kPoints - 4);
  EXPECT_EQ(report.marked.withheld + report.marked.synthetic, 0u);
  for (const char* name : {"label", "class"}) {
    const Cloud labelled =
        read_cloud(folder.file("a.csv", marked_text(name, "other")), options, &report);
    EXPECT_EQ(labelled.size(), kPoints - 1);  // that is no last return
    EXPECT_EQ(labelled.classification.at(low_noise), 7);
  }
}

// A tile of birds alone among the tiles of a road is no reason to make no map.
TEST(MarkedPoints, AloneTheyAreRefusedAmongOthersLeftOut) {
  const support::TemporaryFolder folder;
  const std::string birds = folder.file("a.csv", "x,y,z,classification\n1,2,3,7\n1,2,3,18\n"),
                    road = folder.file("b.csv", "x,y,z,classification\n1,2,3,2\n");
  EXPECT_EQ(read_cloud(birds).size(), 2u);
  const auto points_of = [](const std::vector<std::string>& files) {
    RefineRequest request;
    request.scans = files;
    MapScans scans(request, files, [](const std::string&, double) {});
    std::size_t points = 0;
    scans.source()([&](Cloud&& chunk) { points += chunk.size(); });
    EXPECT_THAT(scans.remarks(), ElementsAre(HasSubstr("of the points 2 marked as noise")));
    return points;
  };
  EXPECT_EQ(points_of({birds, road}), 1u);
  EXPECT_EQ(points_of({road, birds}), 1u);
  for (const auto& files : {std::vector{birds}, std::vector{birds, birds}}) try {
      points_of(files);
      ADD_FAILURE() << "accepted";
    } catch (const cloud::Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("all points are marked as noise (class 7 or 18: "));
      EXPECT_THAT(error.what(), HasSubstr("Classification=1"));
    }
}

TEST(MarkedPoints, ScansOfAMapSayItOnce) {
  const support::TemporaryFolder folder;
  RefineRequest request;
  for (const auto& [name, bytes] : marked_files())
    request.scans.push_back(folder.file(name, bytes));
  MapScans scans(request, request.scans, [](const std::string&, double) {});
  for (int reading = 0; reading < 2; ++reading) {
    std::size_t points = 0;
    scans.source()([&](Cloud&& chunk) { points += chunk.size(); });
    EXPECT_EQ(points, 6 * (kPoints - 5));
    EXPECT_THAT(
        scans.remarks(),
        ElementsAre(
            "of the points 12 marked as noise (class 7 or 18), 6 as withheld, 6 as overlap of "
            "swaths (the flag, or class 12), 6 that are not the last return of their pulse "
            "were left out; 6 points marked as synthetic were used"));
  }
  EXPECT_THAT(describe(request.scans.front()).read.remarks,
              ::testing::Contains(HasSubstr("1 that are not the last return of their "
                                            "pulse are not used by map and grid")));
}

// Marks of overlap spare what others show: where most points have one, nothing would be left.
TEST(MarkedPoints, OverlapOfMostPointsIsRefused) {
  const support::TemporaryFolder folder;
  const std::string line = "1,2,3,12\n",
                    most = folder.file("a.csv", "x,y,z,classification\n1,2,3,2\n" + line + line),
                    half = folder.file("b.csv", "x,y,z,classification\n1,2,3,2\n" + line);
  const auto read = [](const std::string& file) {
    RefineRequest request;
    request.scans = {file};
    MapScans scans(request, request.scans, [](const std::string&, double) {});
    scans.source()([](Cloud&&) {});
  };
  EXPECT_NO_THROW(read(half));
  try {
    read(most);
    ADD_FAILURE() << "accepted";
  } catch (const cloud::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("2 points are marked as overlap"));
  }
}

// The road that comes out is that of the other points, to the last bit.
TEST(MarkedPoints, MoveNoRoad) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto run = [&](const std::vector<std::string>& arguments) {
    const support::ToolRun ran = support::run_tool(places::lidar2mesh(), arguments);
    EXPECT_EQ(ran.code, 0) << ran.err;
  };
  run({"synth", folder.path("road.crg"), "-o", folder.path("scans"), "--laps", "1", "--u-begin-m",
       "20", "--u-end-m", "60", "--azimuths", "64", "--cars", "0"});
  const Cloud clean = read_cloud(folder.path("scans/scan_000.ply"));
  std::string text = "time,x,y,z,classification,Overlap,ReturnNumber,NumberOfReturns\n",
              marked = text;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const auto line = [&](double up_m, int number, const char* marks = "0,1,1") {
      const Eigen::Vector3d p = clean.origin_m + clean.point(i);
      return fmt::format("{},{},{},{},{},{}\n", clean.time_s[i], p.x(), p.y(), p.z() + up_m, number,
                         marks);
    };
    text += line(0.0, 2), marked += line(0.0, 2);
    if (i % 5 == 0) marked += line(-0.1, 7);
    if (i % 7 == 0) marked += line(0.1, 18);
    if (i % 6 == 0) marked += line(-0.02, 2, "1,1,1");
    if (i % 4 == 0) marked += line(0.03, 2, "0,1,2");
  }
  folder.file("clean.csv", text), folder.file("marked.csv", marked);
  for (const std::string name : {"clean", "marked"})
    run({"map", folder.path(name + ".csv"), "--trajectory", folder.path("scans/trajectory.csv"),
         "--road", folder.path("road.crg"), "--no-report", "-o", folder.path(name)});
  for (const std::string name : {"refined.crg", "refined.stddev.crg", "refined.provenance.crg"})
    EXPECT_TRUE(folder.read("clean/" + name) == folder.read("marked/" + name)) << name;
  EXPECT_THAT(folder.read("marked/summary.json"), HasSubstr("marked as noise"));
}

}  // namespace marked_points_test
}  // namespace cloud
