#include "cloud/read_cloud.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "cloud/error.h"
#include "support/cloud_files.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace read_cloud_test {

using support::CloudSeed;
using ::testing::HasSubstr;

Cloud read_bytes(const std::string& bytes, const std::string& name,
                 CloudReadReport* report = nullptr, const CloudReadOptions& options = {}) {
  const support::TemporaryFolder folder;
  return read_cloud(folder.file(name, bytes), options, report);
}

std::string refusal(const std::string& bytes, const std::string& name) {
  try {
    read_bytes(bytes, name);
  } catch (const cloud::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(name));
    return error.what();
  }
  return "accepted";
}

void expect_seed(const Cloud& cloud, const CloudSeed& seed, double tolerance_m) {
  ASSERT_EQ(cloud.size(), seed.count);
  for (std::size_t i = 0; i < seed.count; ++i) {
    EXPECT_NEAR(cloud.origin_m.x() + cloud.x_m[i], seed.x(i), tolerance_m);
    EXPECT_NEAR(cloud.origin_m.y() + cloud.y_m[i], seed.y(i), tolerance_m);
    EXPECT_NEAR(cloud.origin_m.z() + cloud.z_m[i], seed.z(i), tolerance_m);
  }
}

TEST(ReadCloud, LasOfEveryVersionAndFormat) {
  const CloudSeed seed;
  for (int minor = 0; minor <= 4; ++minor)
    for (int format = 0; format <= (minor == 4 ? 10 : 5); ++format) {
      SCOPED_TRACE(fmt::format("1.{} format {}", minor, format));
      const Cloud cloud = read_bytes(support::as_las(seed, minor, format), "a.las");
      expect_seed(cloud, seed, 1e-6);
      EXPECT_LT(std::abs(cloud.x_m[0]), 1000.0) << "no local origin";
      ASSERT_EQ(cloud.classification.size(), seed.count);
      EXPECT_EQ(cloud.classification[5], 2);
      EXPECT_EQ(cloud.intensity[7], 7.0f);
      const bool timed = format == 1 || format >= 3;
      ASSERT_EQ(cloud.time_s.size(), timed ? seed.count : 0u);
      if (timed) {
        EXPECT_DOUBLE_EQ(cloud.time_s[3], seed.time(3));
      }
    }
}

TEST(ReadCloud, LasInFeetComesInMetres) {
  const CloudSeed seed;
  CloudReadReport report;
  const Cloud cloud = read_bytes(support::as_las(seed, 2, 0, true), "a.las", &report);
  EXPECT_EQ(report.unit, "ft");
  EXPECT_TRUE(report.unit_from_file);
  EXPECT_NEAR(cloud.origin_m.y() + cloud.y_m[4], 0.3048 * seed.y(4), 1e-6);
}

TEST(ReadCloud, PlyPcdKittiAndText) {
  CloudSeed seed;
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const Cloud cloud = read_bytes(support::as_cloud_ply(seed, format, true), "a.ply");
    expect_seed(cloud, seed, 1e-6);
    EXPECT_NEAR(cloud.time_s.at(9), seed.time(9), 1e-9);
  }
  for (const char* data : {"ascii", "binary", "binary_compressed"})
    expect_seed(read_bytes(support::as_pcd(seed, data, true), "a.pcd"), seed, 1e-6);
  expect_seed(read_bytes(support::as_xyz(seed, true), "a.csv"), seed, 1e-6);
  expect_seed(read_bytes(support::as_xyz(seed, false), "a.xyz"), seed, 1e-6);
  seed.x0 = 12.0, seed.y0 = -7.0;  // float32 carries these to 8 um
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    expect_seed(read_bytes(support::as_cloud_ply(seed, format, false), "a.ply"), seed, 1e-5);
  for (const char* data : {"binary", "binary_compressed"})
    expect_seed(read_bytes(support::as_pcd(seed, data, false), "a.pcd"), seed, 1e-5);
  const Cloud kitti = read_bytes(support::as_kitti(seed), "a.bin");
  expect_seed(kitti, seed, 1e-5);
  EXPECT_EQ(kitti.intensity.at(3), 3.0f);
}

TEST(ReadCloud, ChunksTogetherAreTheCloud) {
  CloudSeed seed;
  seed.count = 1000;
  CloudReadOptions options;
  options.chunk_points = 7;
  for (const std::string ending : {".las", ".xyz"})
    expect_seed(
        read_bytes(ending == ".las" ? support::as_las(seed, 2, 1) : support::as_xyz(seed, false),
                   "a" + ending, nullptr, options),
        seed, 1e-6);
}

TEST(ReadCloud, TruncatedAnywhereIsRefusedNotRead) {
  const CloudSeed seed;
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.las", support::as_las(seed, 2, 3)},
           {"a.ply", support::as_cloud_ply(seed, "binary_little_endian", true)},
           {"b.ply", support::as_cloud_ply(seed, "ascii", true)},
           {"a.pcd", support::as_pcd(seed, "binary", false)},
           {"b.pcd", support::as_pcd(seed, "binary_compressed", false)},
           {"c.pcd", support::as_pcd(seed, "ascii", true)}})
    for (std::size_t length = 0; length + 30 < bytes.size(); length += 13) {
      const std::string said = refusal(bytes.substr(0, length), name);
      EXPECT_NE(said, "accepted") << name << " of " << length << " bytes";
    }
  EXPECT_THAT(refusal(support::as_las(seed, 2, 3).substr(0, 400), "a.las"),
              HasSubstr("truncated: the header promises 20 points, 5 fit"));
}

TEST(ReadCloud, LeavesOutPointsThatAreNoNumbersAndRefusesNothingElse) {
  CloudReadReport report;
  const Cloud cloud = read_bytes("1 2 3\nnan 2 3\n4 inf 6\n4 5 1e99\n7 8 9\n", "a.xyz", &report);
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_EQ(report.not_finite, 3u);
  EXPECT_THAT(refusal("nan nan nan\n", "a.xyz"), HasSubstr("none of the 1 points"));
  EXPECT_THAT(refusal("1 2 3\n4 five 6\n", "a.xyz"), HasSubstr("a.xyz:2:"));
  EXPECT_THAT(refusal("", "a.xyz"), HasSubstr("empty file"));
  EXPECT_THAT(refusal("x,y\n1,2\n", "a.csv"), HasSubstr("0 fields z"));
  EXPECT_THAT(refusal("# .PCD v0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 0\nHEIGHT "
                      "1\nPOINTS 0\nDATA ascii\n",
                      "a.pcd"),
              HasSubstr("no points"));
  EXPECT_THAT(refusal("123", "a.bin"), HasSubstr("multiple of 16"));
  EXPECT_THAT(refusal("123", "a.dat"), HasSubstr("ending"));
}

// CloudCompare's text begins its line of names so, and its .ply calls what is no coordinate so.
TEST(ReadCloud, NamesOfCloudCompare) {
  for (const char* names :
       {"//X,Y,Z,Intensity,GpsTime", "//X Y Z scalar_Intensity scalar_Gps_Time"}) {
    const Cloud text = read_bytes(std::string(names) + "\n1,2,3,7,100.25\n", "a.csv");
    ASSERT_EQ(text.time_s.size(), 1u) << names;
    EXPECT_EQ(text.time_s[0], 100.25);
    EXPECT_EQ(text.intensity.at(0), 7.0f);
  }
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float scalar_GpsTime\nproperty float scalar_Classification\n"
      "end_header\n1 2 3 100.25 2\n";
  const Cloud cloud = read_bytes(ply, "a.ply");
  EXPECT_EQ(cloud.time_s.at(0), 100.25);
  EXPECT_EQ(cloud.classification.at(0), 2);
}

TEST(ReadCloud, NamesWhatLiesInThePlaceOfAFile) {
  EXPECT_THAT(refusal("ASTM-E57\x01", "a.e57"), HasSubstr("is an E57 file, which is not read"));
  for (const char* name : {"a.las", "a.laz", "a.ply", "a.pcd", "a.bin", "a.xyz"}) {
    EXPECT_THAT(refusal("version https://git-lfs.github.com/spec/v1\noid sha256:77\n", name),
                HasSubstr("is a pointer of Git LFS"));
    EXPECT_THAT(refusal("<!DOCTYPE html>\n<html></html>", name), HasSubstr("is an HTML page"));
  }
}

TEST(ReadCloud, HugePromisesCostNothing) {
  std::string pcd = support::as_pcd({}, "binary", false);
  pcd.replace(pcd.find("POINTS 20"), 9, "POINTS 18446744073709551615");
  EXPECT_THAT(refusal(pcd, "a.pcd"), HasSubstr("truncated"));
  std::string ply = support::as_cloud_ply({}, "binary_little_endian", true);
  ply.replace(ply.find("vertex 20"), 9, "vertex 9999999999999");
  EXPECT_THAT(refusal(ply, "a.ply"), HasSubstr("truncated"));
}

TEST(WriteCloud, PlyKeepsEveryBit) {
  const support::TemporaryFolder folder;
  const Cloud cloud = read_cloud(folder.file("a.las", support::as_las({}, 4, 6)));
  write_cloud(cloud, folder.path("b.ply"), true);
  const Cloud again = read_cloud(folder.path("b.ply"));
  EXPECT_EQ(again.x_m, cloud.x_m);
  EXPECT_EQ(again.z_m, cloud.z_m);
  EXPECT_EQ(again.time_s, cloud.time_s);
  EXPECT_EQ(again.classification, cloud.classification);
}

// As PCL reads it: fields by name and offset, float32.
TEST(WriteCloud, PcdAndPlyAreFloatsRelativeToAnOriginInTheHeader) {
  const support::TemporaryFolder folder;
  const Cloud cloud = read_cloud(folder.file("a.las", support::as_las({}, 4, 6)));
  ASSERT_FALSE(cloud.origin_m.isZero());
  for (const char* name : {"b.pcd", "b.ply"}) {
    SCOPED_TRACE(name);
    write_cloud(cloud, folder.path(name));
    const std::string bytes = folder.read(name);
    const bool pcd = std::string(name) == "b.pcd";
    EXPECT_TRUE(bytes.starts_with(pcd ? "# .PCD v0.7" : "ply\n"));
    const std::string begin = pcd ? "DATA binary\n" : "end_header\n";
    const std::string header = bytes.substr(0, bytes.find(begin));
    EXPECT_THAT(header,
                HasSubstr(pcd ? "SIZE 4 4 4 8 4 1\nTYPE F F F F F U" : "property float x\n"));
    EXPECT_THAT(header, HasSubstr(fmt::format("origin_m {} {} {}", cloud.origin_m.x(),
                                              cloud.origin_m.y(), cloud.origin_m.z())));
    constexpr std::size_t kStride = 12 + 8 + 4 + 1;
    const std::size_t data = header.size() + begin.size();
    ASSERT_EQ(bytes.size(), data + kStride * cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      float p[3];
      std::memcpy(p, bytes.data() + data + kStride * i, sizeof p);
      EXPECT_EQ(p[0], static_cast<float>(cloud.x_m[i]));
      EXPECT_EQ(p[1], static_cast<float>(cloud.y_m[i]));
      EXPECT_EQ(p[2], static_cast<float>(cloud.z_m[i]));
    }
    const Cloud again = read_cloud(folder.path(name));
    ASSERT_EQ(again.size(), cloud.size());
    EXPECT_EQ(again.time_s, cloud.time_s);
    EXPECT_EQ(again.classification, cloud.classification);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      EXPECT_LT((again.origin_m + again.point(i) - cloud.origin_m - cloud.point(i)).norm(), 1e-4);
    EXPECT_THAT(describe(folder.path(name)).read.remarks, ::testing::IsEmpty());
  }
  EXPECT_THROW(write_cloud(cloud, folder.path("b.xyz")), cloud::Error);
}

TEST(ReadCloud, NuscenesHasFiveFloats) {
  std::string bytes;
  for (int i = 0; i < 4; ++i)
    for (const float value : {1.0f + static_cast<float>(i), 2.0f, 3.0f, 40.0f, 7.0f})
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  const support::TemporaryFolder folder;
  const Cloud cloud = read_cloud(folder.file("sweep.pcd.bin", bytes));
  ASSERT_EQ(cloud.size(), 4u);
  EXPECT_EQ(cloud.x_m, (std::vector<double>{1.0, 2.0, 3.0, 4.0}));
  EXPECT_EQ(cloud.z_m, (std::vector<double>(4, 3.0)));
  EXPECT_EQ(cloud.intensity, (std::vector<float>(4, 40.0f)));
  EXPECT_THAT(refusal(bytes.substr(1), "sweep.pcd.bin"), HasSubstr("a multiple of 20 wanted"));
  EXPECT_THAT(refusal(bytes + bytes.substr(0, 20), "sweep.bin"), HasSubstr(".pcd.bin (nuScenes)"));
}

TEST(ReadCloud, RefusesDegrees) {
  std::string las = support::as_las({}, 4, 6, true);  // with geo keys: feet
  // GTModelTypeGeoKey 1024 = 2: geographic, in place of the first key.
  const std::size_t keys = las.find("LASF_Projection") + 52 + 8;
  const std::uint16_t model[4] = {1024, 0, 1, 2};
  std::memcpy(las.data() + keys, model, sizeof model);
  EXPECT_THAT(refusal(las, "a.las"), HasSubstr("degrees of longitude and latitude"));
}

// A road of 70 m at 11.5 degrees east, 48.1 north that climbs by 2 m; and what is not one.
TEST(ReadCloud, RefusesDegreesInEveryFormat) {
  std::string text, floats, doubles;
  for (int i = 0; i < 100; ++i) {
    const double p[] = {11.5 + 1e-5 * i, 48.1 + 2e-6 * i, 500.0 + 0.02 * i};
    text += fmt::format("{:.8f},{:.8f},{:.3f}\n", p[0], p[1], p[2]);
    for (const double value : p) {
      const auto single = static_cast<float>(value);
      floats.append(reinterpret_cast<const char*>(&single), sizeof single);
      doubles.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  const std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 100\nproperty double x\nproperty "
      "double "
      "y\nproperty double z\nend_header\n" +
      doubles;
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH "
      "100\nHEIGHT 1\nPOINTS 100\nDATA binary\n" +
      floats;
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.xyz", text}, {"a.csv", "x_m,y_m,z_m\n" + text}, {"a.ply", ply}, {"a.pcd", pcd}}) {
    const std::string said = refusal(bytes, name);
    EXPECT_THAT(said, HasSubstr("look like degrees of longitude and latitude (x 11.50000 to "));
    EXPECT_THAT(said, HasSubstr("out_srs=EPSG:"));
    EXPECT_THAT(said, HasSubstr("--unit m"));
    CloudReadOptions metres;
    metres.metres_per_unit = 1.0;
    EXPECT_EQ(read_bytes(bytes, name, nullptr, metres).size(), 100u) << name;
  }
  EXPECT_THAT(refusal("lon,lat,height\n" + text, "a.csv"), HasSubstr("column lon seen"));
  // A pole, seen from a scanner near it and in a survey's frame; a flat square of half a metre.
  for (const double x0 : {3.0, 4000.0}) {
    std::string pole, square;
    for (int i = 0; i < 100; ++i) {
      pole += fmt::format("{} {} {}\n", x0 + 0.2 * std::sin(0.7 * i), x0 + 2.0 * std::cos(0.7 * i),
                          0.05 * i);
      const int row = i / 10;
      square += fmt::format("{} {} {}\n", x0 + 0.05 * (i % 10), x0 + 0.05 * row, 0.001 * i);
    }
    EXPECT_EQ(refusal(pole, "a.xyz"), "accepted");
    EXPECT_EQ(refusal(square, "a.xyz"), "accepted");
  }
}

TEST(Describe, SaysThatTimesAreNoNumbers) {
  const support::TemporaryFolder folder;
  const CloudFacts facts =
      describe(folder.file("a.csv", "x_m,y_m,z_m,time_s\n0,0,0,nan\n1,0,0,nan\n"));
  EXPECT_FALSE(facts.has_time);
  EXPECT_THAT(facts.read.remarks,
              ::testing::Contains(HasSubstr("times of the points are not numbers")));
}

TEST(Describe, FindsQuantisation) {
  const support::TemporaryFolder folder;
  CloudSeed seed;
  seed.count = 200;
  const CloudFacts facts = describe(folder.file("a.pcd", support::as_pcd(seed, "binary", false)));
  EXPECT_DOUBLE_EQ(facts.resolution_m[1], 0.5);  // float32 beyond 2^22
  EXPECT_THAT(fmt::format("{}", fmt::join(facts.read.remarks, "\n")),
              HasSubstr("y is quantised to 0.5 m"));
}

std::string lidar(const char* name) { return places::data() + "/lidar/" + name; }

TEST(RealClouds, Autzen) {
  if (!std::ifstream(lidar("autzen_trim.las"))) GTEST_SKIP() << "no ../shared/data";
  const CloudFacts facts = describe(lidar("autzen_trim.las"));
  EXPECT_EQ(facts.read.points, 110000u);
  EXPECT_EQ(facts.read.unit, "ft");
  // The bounds that the header states, in feet.
  std::ifstream file(lidar("autzen_trim.las"), std::ios::binary);
  file.seekg(179);
  double bounds[6];
  file.read(reinterpret_cast<char*>(bounds), sizeof bounds);
  for (std::ptrdiff_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(facts.max_m[k] / 0.3048, bounds[2 * k], 1e-6);
    EXPECT_NEAR(facts.min_m[k] / 0.3048, bounds[2 * k + 1], 1e-6);
  }
  EXPECT_EQ(facts.points_of_class, (std::map<int, std::size_t>{{1, 83893}, {2, 26107}}));
  // Plan in metres, heights in US feet: the same place, so the same height above the sea within 30
  // m.
  const CloudFacts mixed = describe(lidar("autzen-bmx-2010.las"));
  EXPECT_EQ(mixed.read.points, 829u);
  EXPECT_NEAR(mixed.min_m.z(), facts.min_m.z(), 30.0);
  const support::TemporaryFolder folder;
  const Cloud cloud = read_cloud(lidar("autzen_trim.las"));
  write_cloud(cloud, folder.path("a.ply"), true);
  const Cloud again = read_cloud(folder.path("a.ply"));
  ASSERT_EQ(again.size(), cloud.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    worst =
        std::max(worst, (again.origin_m + again.point(i) - cloud.origin_m - cloud.point(i)).norm());
  EXPECT_LT(worst, 1e-3);
}

TEST(ReadCloud, RefusesAFifoAtOnce) {
  const support::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo(folder.path("scan.las").c_str(), 0600), 0);
  EXPECT_THROW(read_cloud(folder.path("scan.las")), cloud::Error);
}

TEST(RealClouds, Samp11IsQuantisedToHalfAMetre) {
  if (!std::ifstream(lidar("samp11-utm.pcd"))) GTEST_SKIP() << "no ../shared/data";
  const CloudFacts facts = describe(lidar("samp11-utm.pcd"));
  EXPECT_EQ(facts.read.points, 38010u);
  EXPECT_DOUBLE_EQ(facts.resolution_m[1], 0.5);
}

}  // namespace read_cloud_test
}  // namespace cloud
