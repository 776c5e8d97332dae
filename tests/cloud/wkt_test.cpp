// The units that a coordinate system gives as text, in a LAS file of its own for each.
#include "wkt.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "support/cloud_files.h"
#include "support/laz_file.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace wkt_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kFoot = 0.3048, kSurveyFoot = 1200.0 / 3937.0;

constexpr const char* kSurvey2 = R"(LENGTHUNIT["US survey foot",0.304800609601219])";
constexpr const char* kFoot2 = R"(LENGTHUNIT["foot",0.3048,ID["EPSG",9002]])";
constexpr const char* kMetre2 = R"(LENGTHUNIT["metre",1])";

/// The datum and the projection have units of their own, which are not those of the coordinates.
std::string projected(const std::string& axes) {
  return R"(PROJCRS["NAD83 / ""test""",BASEGEOGCRS["NAD83",DATUM["North American Datum 1983",
    ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]],
    PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],
    CONVERSION["t",METHOD["Transverse Mercator"],
    PARAMETER["False easting",3000000,LENGTHUNIT["metre",1]]],CS[Cartesian,2],)" +
         axes + R"(,ID["EPSG",2225]])";
}

std::string plan(const std::string& unit) {
  return projected(R"(AXIS["easting",east],AXIS["northing",north],)" + unit);
}

/// As PROJ writes it: a unit for each axis.
std::string plan_by_axis(const std::string& unit) {
  return projected(R"(AXIS["easting",east,ORDER[1],)" + unit +
                   R"(],AXIS["northing",north,ORDER[2],)" + unit + "]");
}

std::string height(const std::string& unit) {
  return R"(VERTCRS["NAVD88 height",VDATUM["NAVD88"],CS[vertical,1],AXIS["up",up],)" + unit + "]";
}

std::string compound(const std::string& one, const std::string& other) {
  return R"(COMPOUNDCRS["both",)" + one + "," + other + "]";
}

std::string plan1(const std::string& unit) {
  return R"(PROJCS["Oregon",GEOGCS["NAD83",DATUM["D",SPHEROID["GRS 1980",6378137,298.257]],
    PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Lambert"],
    PARAMETER["false_easting",400000],)" +
         unit + R"(,AXIS["Easting",EAST],AXIS["Northing",NORTH],AUTHORITY["EPSG","2991"]])";
}

struct Case {
  std::string text;
  double plan, height;
};

std::vector<Case> cases() {
  const std::string survey1 =
      R"(UNIT["US survey foot",0.3048006096012192,AUTHORITY["EPSG","9003"]])";
  const std::string height1 = R"(VERT_CS["NAVD88",VERT_DATUM["N",2005],UNIT["foot",0.3048]])";
  return {
      {plan(kSurvey2), kSurveyFoot, kSurveyFoot},
      {plan(kFoot2), kFoot, kFoot},
      {plan(kMetre2), 1.0, 1.0},
      {plan(R"(UNIT["Foot_US",0.3048006])"), kSurveyFoot, kSurveyFoot},
      {plan(R"(LENGTHUNIT["British yard",0.914398415])"), 0.914398415, 0.914398415},
      {plan_by_axis(kSurvey2), kSurveyFoot, kSurveyFoot},
      {compound(plan(kMetre2), height(kSurvey2)), 1.0, kSurveyFoot},
      {compound(plan_by_axis(kMetre2), height(kFoot2)), 1.0, kFoot},
      {compound(plan(kSurvey2), height(kMetre2)), kSurveyFoot, 1.0},
      {compound(height(kFoot2), plan(kMetre2)), 1.0, kFoot},
      {projected(R"(AXIS["e",east,)" + std::string(kMetre2) + R"(],AXIS["n",north,)" + kMetre2 +
                 R"(],AXIS["h",up,)" + kFoot2 + "]"),
       1.0, kFoot},
      {"BOUNDCRS[SOURCECRS[" + plan(kSurvey2) + R"(],TARGETCRS[GEOGCRS["WGS 84"]]])", kSurveyFoot,
       kSurveyFoot},
      {plan1(survey1), kSurveyFoot, kSurveyFoot},
      {plan1(R"(UNIT["metre",1])"), 1.0, 1.0},
      {R"(COMPD_CS["both",)" + plan1(R"(UNIT["metre",1])") + "," + height1 + "]", 1.0, kFoot},
      {"projcs(\"round\",unit(\"feet\",3.048e-1))", kFoot, kFoot},
  };
}

CloudReadReport expect_metres(const std::string& las, const char* name, double plan_m,
                              double height_m) {
  const support::CloudSeed seed;
  const support::TemporaryFolder folder;
  CloudReadReport report;
  const Cloud cloud = read_cloud(folder.file(name, las), {}, &report);
  EXPECT_EQ(cloud.size(), seed.count);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.origin_m + cloud.point(i);
    EXPECT_NEAR(p.x(), plan_m * seed.x(i), 1e-6);
    EXPECT_NEAR(p.y(), plan_m * seed.y(i), 1e-6);
    EXPECT_NEAR(p.z(), height_m * seed.z(i), 1e-6);
  }
  EXPECT_TRUE(report.unit_from_file);
  return report;
}

TEST(Wkt, LasComesInTheUnitOfTheText) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.text);
    const std::string las = support::as_las({}, 4, 6);
    for (const std::string& bytes :
         {support::with_record(las, 2112, c.text), support::with_record(las, 2112, c.text + '\0'),
          support::with_extended_record(las, 2112, c.text)}) {
      const CloudReadReport report = expect_metres(bytes, "a.las", c.plan, c.height);
      EXPECT_EQ(report.remarks.size(), c.plan == c.height ? 0u : 1u);
    }
    expect_metres(support::as_laz(support::with_record(las, 2112, c.text)), "a.laz", c.plan,
                  c.height);
  }
}

TEST(Wkt, HeightsBesideThePlanAndEsrisWordForThem) {
  const std::string metres = R"(UNIT["metre",1])", feet = R"(UNIT["Foot_US",0.3048006096012192])",
                    datum =
                        R"(["NAVD88",VDATUM["N"],PARAMETER["Vertical_Shift",0.0],)" + feet + "]";
  const std::string las = support::as_las({}, 4, 6);
  for (const std::string& text :
       {plan1(metres) + ",VERT_CS" + datum, plan1(metres) + "\nVERTCS" + datum,
        "COMPD_CS[\"both\"," + plan1(metres) + ",VERTCS" + datum + "]",
        "\xEF\xBB\xBF" + plan1(metres) + ",VERTCS" + datum})
    expect_metres(support::with_record(las, 2112, text), "a.las", 1.0, kSurveyFoot);
}

TEST(Wkt, AUnitOfHeightsAloneIsAskedFor) {
  const support::TemporaryFolder folder;
  const std::string las = folder.file(
      "a.las", support::with_record(support::as_las({}, 4, 6), 2112,
                                    compound(plan(R"(LENGTHUNIT["foot"])"), height(kFoot2))));
  try {
    read_cloud(las);
    ADD_FAILURE() << "the plan may be in feet, too";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("names a unit for the heights, and none for the plan"));
  }
  CloudReadOptions options;
  options.metres_per_unit = kFoot;
  EXPECT_EQ(read_cloud(las, options).size(), support::CloudSeed{}.count);
}

TEST(Wkt, BesideGeoKeysTheTextCounts) {
  const std::string keys = support::as_las({}, 4, 6, true);  // feet
  EXPECT_THAT(expect_metres(support::with_record(keys, 2112, plan(kSurvey2)), "a.las", kSurveyFoot,
                            kSurveyFoot)
                  .remarks,
              IsEmpty());
  const CloudReadReport report = expect_metres(
      support::with_record(keys, 2112, projected(R"(AXIS["e",east])")), "a.las", kFoot, kFoot);
  EXPECT_EQ(report.coordinate_system, "NAD83 / \"test\"");
}

TEST(Wkt, APlanWithoutUnitIsSaid) {
  const support::TemporaryFolder folder;
  const auto remarks = [&](const std::string& text) {
    CloudReadReport report;
    read_cloud(folder.file("a.las", support::with_record(support::as_las({}, 4, 6), 2112, text)),
               {}, &report);
    return fmt::format("{}", fmt::join(report.remarks, "\n"));
  };
  for (const std::string unit : {R"(LENGTHUNIT["foot"])", R"(LENGTHUNIT["foot",-1])",
                                 R"(LENGTHUNIT["foot",0.3x])", R"(LENGTHUNIT["foot",inf])"})
    EXPECT_THAT(remarks(plan(unit)),
                HasSubstr("'NAD83 / \"test\"' names no unit for the plan; without --unit"));
  EXPECT_THAT(remarks("no coordinate system"), IsEmpty());
}

TEST(Wkt, DegreesAreRefused) {
  const support::TemporaryFolder folder;
  for (const std::string keyword : {"GEOGCRS", "GEODCRS", "GEOGCS"}) {
    const std::string text =
        keyword + R"(["WGS 84",DATUM["W",ELLIPSOID["W",6378137,298.25,LENGTHUNIT["metre",1]]],
        CS[ellipsoidal,2],ANGLEUNIT["degree",0.0174532925199433]])";
    for (const std::string& whole : {text, compound(text, height(kMetre2))}) try {
        read_cloud(
            folder.file("a.las", support::with_record(support::as_las({}, 4, 6), 2112, whole)));
        ADD_FAILURE() << "accepted: " << whole;
      } catch (const cloud::Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("a.las: the coordinates are degrees"));
        EXPECT_THAT(error.what(), HasSubstr("pdal translate"));
      }
  }
}

TEST(Wkt, AnyTextIsReadToItsEnd) {
  const std::string whole = compound(plan(kSurvey2), height(kFoot2));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const CoordinateSystem some = read_wkt(std::string_view(whole).substr(0, length));
    EXPECT_FALSE(some.height.has_value() && !some.plan.has_value());
  }
  EXPECT_TRUE(read_wkt(whole).plan && read_wkt(whole).height);
  EXPECT_FALSE(read_wkt(std::string(65535, '[')).plan.has_value());
  EXPECT_FALSE(read_wkt("]],\"").plan.has_value());
}

TEST(RealClouds, StreetsInFeetByText) {
  for (const char* name : {"street_wkt2_usfoot.las", "street_wkt2_compound_m_plus_ft.las"}) {
    const std::string path = places::data() + "/constructed/" + name;
    if (!std::ifstream(path)) GTEST_SKIP() << "no ../shared/data";
    const CloudFacts facts = describe(path);
    EXPECT_EQ(facts.read.points, 16000u);
    const Eigen::Vector3d size = facts.max_m - facts.min_m;
    EXPECT_NEAR(size.x(), 99.75, 1e-3) << name;
    EXPECT_NEAR(size.y(), 9.75, 1e-3) << name;
    EXPECT_NEAR(facts.min_m.x(), 500000.0, 1e-3) << name;
    EXPECT_NEAR(facts.min_m.z(), 99.95, 1e-3) << name;
    EXPECT_NEAR(size.z(), 0.0975, 1e-3) << name;
  }
}

}  // namespace wkt_test
}  // namespace cloud
