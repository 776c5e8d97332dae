#include "inspect/write_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "base/json_text.h"
#include "crg/error.h"
#include "crg/file.h"
#include "mesh/error.h"
#include "report/track_report.h"
#include "support/oval_road.h"
#include "support/places.h"

namespace write_report_test {

namespace fs = std::filesystem;
using nlohmann::json;
using test_support::Oval;

const Oval& clean_oval() {
  static const Oval oval = test_support::oval_road();
  return oval;
}

class WriteReport : public ::testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() / ("write_report_" + std::to_string(::getpid()));
    fs::remove_all(dir_);
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::string write(const Oval& oval, const std::string& name) const {
    std::string path = (dir_ / name).string();
    crg::write(crg::make_crg(oval.line, oval.grid), path, crg::Format::KRBI);
    return path;
  }
  static std::string text_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  json report_of(const road::ReportRequest& request) const {
    return base::parse_json<json>(
        text_of(road::write_report(request, (dir_ / "out").string()).json_path));
  }
  fs::path dir_;
};

TEST_F(WriteReport, CleanRoadIsUsableAndItsNumbersAreThere) {
  road::ReportRequest request;
  request.crg_path = write(clean_oval(), "clean.crg");
  const json report = report_of(request);
  EXPECT_EQ(report["schema"], "kerbstone.report");
  EXPECT_EQ(report["schema_version"], 1);
  EXPECT_EQ(report["verdict"], "usable");
  EXPECT_TRUE(report["findings"].empty());
  EXPECT_EQ(report["title"], "clean.crg");
  EXPECT_EQ(report["kerbs"].size(), 4u);
  EXPECT_EQ(report["inputs"][0]["sha256"].get<std::string>().size(), 64u);
  const std::size_t rows = clean_oval().grid.rows();
  for (const char* key :
       {"elevation_m", "slope", "vertical_curvature_1pm", "banking", "heading_rad", "curvature_1pm",
        "curvature_rate_1pm2", "width_m", "v_left_m", "v_right_m"}) {
    ASSERT_EQ(report["along_u"][key].size(), rows) << key;
  }
  // Middle of the first straight and of the first bend, where the oval's own numbers are plain.
  EXPECT_NEAR(report["along_u"]["width_m"][1500], 18.0, 1e-5);
  EXPECT_NEAR(report["along_u"]["curvature_1pm"][1500], 0.0, 1e-5);
  EXPECT_NEAR(report["along_u"]["curvature_1pm"][4000], 1.0 / 60.0, 1e-4);
  // Two half circles are a turn, and the changes of slope and curvature are what they go on by.
  const json& heading = report["along_u"]["heading_rad"];
  EXPECT_NEAR(heading.back().get<double>() - heading.front().get<double>(), 2.0 * M_PI, 1e-3);
  for (const auto& [of, rate, rough] : {std::tuple{"slope", "vertical_curvature_1pm", 2e-5},
                                        {"curvature_1pm", "curvature_rate_1pm2", 2e-6}})
    for (const std::size_t i : {500u, 3020u, 4000u, 8000u}) {
      const auto at = [&](const char* key, std::size_t row) {
        return report["along_u"][key][row].get<double>();
      };
      const double change = (at(of, i + 25) - at(of, i - 25)) / (50.0 * clean_oval().line.u_step_m);
      EXPECT_NEAR(at(rate, i), change, rough) << rate << " at row " << i;
    }
  // Curve values are written to 1e-6; roughness of class B tilts a lateral cut by a few 1e-3.
  EXPECT_NEAR(report["along_u"]["banking"][4000], -0.04, 0.005);
  ASSERT_EQ(report["roughness"].size(), 2u);
  for (const json& track : report["roughness"]) {
    EXPECT_EQ(track["iso8608"]["class"], "B");
    EXPECT_NEAR(track["iso8608"]["exponent"], 2.0, 0.2);
    EXPECT_EQ(track["iri"].size(), 10u);
  }
}

TEST_F(WriteReport, EveryRuleHasItsLimitAndTheLargestThatWasSeen) {
  road::ReportRequest request;
  const auto rule = [&](const Oval& oval, const std::string& what) {
    request.crg_path = write(oval, "ruled.crg");
    const json rules = report_of(request)["rules"];
    for (const json& r : rules)
      if (r["what"] == what) return r;
    return json();
  };
  EXPECT_FALSE(rule(clean_oval(), "bump or pothole")["seen"]);
  Oval bad = clean_oval();
  test_support::plant(bad, [](double u, double v) {
    return 0.1 * std::max(0.0, 1.0 - std::hypot(u - 500.0, v - 1.0));
  });
  const json kept = rule(bad, "bump or pothole");
  EXPECT_TRUE(kept["seen"]);
  EXPECT_EQ(kept["limit"], 0.3);
  EXPECT_NEAR(kept["value"], 0.1, 0.02);
  EXPECT_NEAR(kept["u_m"], 500.0, 2.0);
  Oval open = clean_oval();
  test_support::plant(open, [](double u, double v) {
    return std::hypot(u - 700.0, v - 1.0) < 1.0 ? std::nan("") : 0.0;
  });
  EXPECT_GT(rule(open, "hole in the road, longer side")["value"].get<double>(), 0.5);
}

TEST_F(WriteReport, TheRoadStandsBesideWhatIsPublished) {
  road::ReportRequest request;
  request.crg_path = write(clean_oval(), "clean.crg");
  request.published = {950.0, {}, 18.2, "a page", "A. N., 2026, CC0"};  // the oval: 977 m, 18 m
  const json report = report_of(request);
  EXPECT_EQ(report["verdict"], "usable_with_remarks");
  ASSERT_EQ(report["findings"].size(), 1u);
  EXPECT_THAT(report["findings"][0]["text"].get<std::string>(),
              ::testing::MatchesRegex("Length: 97[67][.][0-9] m, 2[.][78] % more than the 950 m of "
                                      "a page"));
  const std::string facts = report["facts"].dump();
  EXPECT_THAT(facts, ::testing::HasSubstr("18.0 m, 1.1 % less than the 18.2 m of a page"));
  EXPECT_THAT(facts, ::testing::HasSubstr("A. N., 2026, CC0"));
  EXPECT_THAT(facts, ::testing::Not(::testing::HasSubstr("Climb")));
}

using SlowWriteReport = WriteReport;

TEST_F(SlowWriteReport, ThePageOfARoughRoadOf5KilometresIsUnder3Megabytes) {
  if (!report::page_available()) GTEST_SKIP() << "this build has no page";
  test_support::OvalOptions options;
  options.straight_m = 2300.0;
  options.half_width_m = 18.75;
  const Oval rough = test_support::oval_road(options);
  Oval other = rough;
  test_support::plant(other, [](double u, double v) {
    return 0.003 * std::sin(1234.5 * std::sin(17.0 * u + 91.0 * v));
  });
  const crg::Crg before = crg::make_crg(other.line, other.grid);
  road::ReportRequest request;
  request.crg_path = write(rough, "rough.crg");
  request.against_path = write(other, "other.crg");
  request.before = &before;
  report_of(request);
  EXPECT_LT(fs::file_size(dir_ / "out" / "report.html"), 3'000'000u);
}

TEST_F(WriteReport, ARoadThatIsFlatToItsRoundingHasNoClass) {
  road::ReportRequest request;
  test_support::OvalOptions smooth;
  smooth.iso_class = 0;
  test_support::Oval oval = test_support::oval_road(smooth);
  for (std::size_t k = 0; k < oval.grid.z_m.size(); ++k)
    oval.grid.z_m[k] = 10.0F + 1e-6F * static_cast<float>(k * 7919 % 13);
  request.crg_path = write(oval, "flat.crg");
  for (const json& track : report_of(request)["roughness"])
    EXPECT_TRUE(track["iso8608"].is_null()) << track["iso8608"];
}

TEST_F(WriteReport, FacetsAreNoRoughness) {
  road::ReportRequest request;
  test_support::OvalOptions smooth;
  smooth.iso_class = 0;
  test_support::Oval oval = test_support::oval_road(smooth);
  test_support::plant(oval, [](double u_m, double) {
    const double knot = std::floor(u_m / 4.0), t = u_m / 4.0 - knot;
    const auto height_m = [](double k) { return 0.02 * std::sin(12.9898 * k * k); };
    return (1.0 - t) * height_m(knot) + t * height_m(knot + 1.0);
  });
  request.crg_path = write(oval, "facets.crg");
  const json report = report_of(request);
  ASSERT_EQ(report["roughness"].size(), 2u);
  for (const json& track : report["roughness"]) {
    EXPECT_TRUE(track["iso8608"].is_null()) << track["iso8608"];
    EXPECT_NEAR(track["facets"]["median_m"], 4.0, 0.1);
  }
}

TEST_F(WriteReport, CurvesInTheTextAreTheNumbersOfTheReport) {
  report::TrackReport report;
  report.curves.push_back({"x",
                           "x",
                           "m",
                           {0.0f, -0.0f, 1.0f, -1.5f, 1e-6f, -1e-6f, 1e-9f, 123456.789f, 0.1f,
                            100.0f, std::nanf(""), 3e9f, -0.25f},
                           1.0});
  const json parsed = base::parse_json<json>(report::report_json(report));
  const auto& x = parsed["along_u"]["x"];
  ASSERT_EQ(x.size(), 13u);
  const double wanted[] = {0, 0, 1, -1.5, 1e-6, -1e-6, 0, 123456.789, 0.1, 100, 0, 3e9, -0.25};
  for (std::size_t k = 0; k < 13; ++k) {
    if (k == 10)
      EXPECT_TRUE(x[k].is_null());
    else
      EXPECT_NEAR(x[k].get<double>(), wanted[k], 1e-6 + 1e-7 * std::abs(wanted[k])) << k;
  }
}

TEST_F(WriteReport, EachPlantedDefectIsAmongTheFindingsWithinFiveMetres) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double end = clean_oval().grid.u_of(clean_oval().grid.rows() - 1);
  struct Case {
    const char* kind;
    double u_begin_m, u_end_m;
    bool against;
    std::function<double(double, double)> height;
  };
  const std::vector<Case> cases{
      {"tile_step", 200, 200, false,
       [](double u, double) {
         return u < 200.03 || u > 800.0 ? 0.0 : 0.02 * (1.0 - (u - 200.03) / 599.97);
       }},
      {"hole", 431.2, 431.2, false,
       [=](double u, double v) {
         return std::abs(u - 431.2) < 0.05 && std::abs(v + 2.3) < 0.03 ? nan : 0.0;
       }},
      {"kerb_loss", 330, 345, true,
       [](double u, double v) {
         return u < 330.0 || u > 345.0 || v < 6.0 || v > 7.0
                    ? 0.0
                    : -0.03 * (v < 6.6 ? (v - 6.0) / 0.6 : (7.0 - v) / 0.4);
       }},
      {"nan_stripe", 600, 600.3, false,
       [=](double u, double) { return u > 600.0 && u < 600.3 ? nan : 0.0; }},
      {"wrong_seam", end, end, false,
       [=](double u, double) { return 0.03 * std::max(0.0, (u - end + 200.0) / 200.0); }},
      {"bump", 150, 150, false,
       [](double u, double) {
         return std::abs(u - 150.0) > 1.0 ? 0.0 : 0.05 * (1.0 + std::cos(M_PI * (u - 150.0)));
       }},
  };
  const std::string clean_path = write(clean_oval(), "clean.crg");
  for (const Case& c : cases) {
    Oval oval = clean_oval();
    test_support::plant(oval, c.height);
    road::ReportRequest request;
    request.crg_path = write(oval, "defect.crg");
    if (c.against) request.against_path = clean_path;
    const json report = report_of(request);
    bool found = false;
    for (const json& f : report["findings"]) {
      found = found ||
              (f["kind"] == c.kind && std::abs(f["u_begin_m"].get<double>() - c.u_begin_m) <= 5.0 &&
               std::abs(f["u_end_m"].get<double>() - c.u_end_m) <= 5.0 && f["value"].is_number() &&
               !f["unit"].get<std::string>().empty() && !f["text"].get<std::string>().empty());
    }
    EXPECT_TRUE(found) << c.kind << "\n" << base::dump_json(report["findings"], 1);
    EXPECT_NE(report["verdict"], "usable") << c.kind;
  }
}

TEST_F(WriteReport, AFoldMakesTheRoadNotUsable) {
  test_support::OvalOptions options;
  options.radius_m = 8.0;  // the grid reaches 9 m to the inside
  options.kerb_height_m = 0.0;
  road::ReportRequest request;
  request.crg_path = write(test_support::oval_road(options), "fold.crg");
  const json report = report_of(request);
  EXPECT_EQ(report["verdict"], "not_usable");
  ASSERT_FALSE(report["findings"].empty());
  EXPECT_EQ(report["findings"][0]["kind"], "fold");
  EXPECT_NEAR(report["findings"][0]["u_begin_m"].get<double>(), 300.0, 5.0);
}

TEST_F(WriteReport, MeshComparisonAndControlPointsAreThere) {
  const road::Mesh mesh = test_support::mesh_of(clean_oval(), 2);
  road::ReportRequest request;
  request.crg_path = write(clean_oval(), "clean.crg");
  request.mesh = &mesh;
  request.control_points = {{"A", {0, 0, 0}, {0, 0, 0}},
                            {"B", {100, 0, 0}, {100, 0, 0}},
                            {"C", {0, 100, 1}, {0, 100, 1}}};
  const json report = report_of(request);
  EXPECT_EQ(report["verdict"], "usable") << base::dump_json(report["findings"], 1);
  ASSERT_EQ(report["comparisons"].size(), 1u);
  EXPECT_EQ(report["comparisons"][0]["key"], "mesh");
  EXPECT_LT(report["comparisons"][0]["abs_error_m"]["p99"], 0.002);
  EXPECT_EQ(report["comparisons"][0]["worst"].size(), 10u);
  EXPECT_EQ(report["control_points"].size(), 3u);
  EXPECT_EQ(report["control_points"][0]["left_out"], false);
  EXPECT_EQ(report["along_u"]["largest_error_mesh_m"].size(), clean_oval().grid.rows());
  EXPECT_EQ(report["kerbs"][0]["profile"]["lines"].size(), 2u);
  EXPECT_EQ(report["rough"]["limit_m"], 0.015);
}

TEST_F(WriteReport, OutliersAndRemarksOfTheBuildAreThere) {
  road::ReportRequest request;
  request.crg_path = write(clean_oval(), "clean.crg");
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d at(100.0 * std::cos(k), 100.0 * std::sin(k), 0.0);
    request.control_points.push_back(
        {fmt::format("P{}", k), at, at + Eigen::Vector3d(k == 5 ? 4.0 : 0.01 * (k % 2), 0, 0)});
  }
  request.remarks = {"smoothing was held at its bound"};
  const json report = report_of(request);
  ASSERT_EQ(report["control_points"].size(), 8u);
  for (const json& point : report["control_points"])
    EXPECT_EQ(point["left_out"], point["name"] == "P5") << point;
  EXPECT_EQ(report["notes"][0], "smoothing was held at its bound");
}

TEST_F(WriteReport, StretchesOffTheMeshAreNamedOrTakenAsGiven) {
  const road::Mesh mesh = test_support::mesh_of(clean_oval(), 2);
  Oval bad = clean_oval();
  test_support::plant(bad, [](double u, double v) {
    return u > 120.0 && u < 125.0 && std::abs(v) < 2.0 ? 0.05 : 0.0;
  });
  road::ReportRequest request;
  request.crg_path = write(bad, "bad.crg");
  EXPECT_TRUE(report_of(request)["rough"].is_null());
  request.mesh = &mesh;
  const json places = report_of(request)["rough"]["places"];
  ASSERT_FALSE(places.empty());
  double first_m = 1e9, last_m = 0.0;
  for (const json& place : places) {
    if (place["largest_error_m"] < 0.04) continue;
    EXPECT_NE(place["reason"].get<std::string>().find("own nodes are off the mesh"),
              std::string::npos);
    first_m = std::min(first_m, place["u_begin_m"].get<double>());
    last_m = std::max(last_m, place["u_end_m"].get<double>());
  }
  EXPECT_NEAR(first_m, 120.0, 0.6);
  EXPECT_NEAR(last_m, 125.0, 0.6);
  // What a build has found already is told as it was told there.
  road::ValidateReport told;
  told.points = 7;
  told.z_error_m = {0.01, 0.02, 0.03, 0.5};
  told.worst_u_m = 1.5, told.worst_v_m = -0.5, told.worst_error_m = -0.5;
  told.rough_places = {{1.0, 2.0, -1.0, 1.0, 0.5, "told", 1.5, -0.5, -0.5}};
  request.validated = told;
  request.kerbs = {{10.0, 20.0, -6.0, -5.0, 0.05, 15.0}};
  request.road_width_m = {8.0, 9.0, 10.0};
  const json report = report_of(request);
  EXPECT_EQ(report["rough"]["places"][0]["reason"], "told");
  const json& mesh_errors = report["comparisons"][0];
  EXPECT_EQ(mesh_errors["points"], 7);
  EXPECT_EQ(mesh_errors["abs_error_m"]["max"], 0.5);
  EXPECT_EQ(mesh_errors["worst"][0]["value_m"], -0.5);
  EXPECT_EQ(mesh_errors["worst"][0]["u_m"], 1.5);
  double largest_m = 0.0;
  for (const json& error : report["along_u"]["largest_error_mesh_m"])
    largest_m = std::max(largest_m, error.is_null() ? 0.0 : error.get<double>());
  EXPECT_EQ(largest_m, 0.5);
  ASSERT_EQ(report["kerbs"].size(), 1u);
  EXPECT_EQ(report["kerbs"][0]["side"], "right");
  EXPECT_EQ(report["kerbs"][0]["v_begin_m"], -5.0);
  EXPECT_EQ(report["kerbs"][0]["profile"]["u_m"], 15.0);
}

TEST_F(WriteReport, SaysWhatWasLookedForAndFromWhichLimits) {
  // A bump of 15 mm over the whole width: lower than what is a finding.
  Oval bump = clean_oval();
  test_support::plant(bump, [](double u, double) {
    return u > 50.0 && u < 54.0 ? 0.015 * std::pow(std::sin(M_PI * (u - 50.0) / 4.0), 2) : 0.0;
  });
  road::ReportRequest request;
  request.crg_path = write(bump, "bump.crg");
  const json report = report_of(request);
  EXPECT_EQ(report["verdict"], "usable") << base::dump_json(report["findings"], 1);
  std::string all;
  for (const json& sentence : report["looked_for"]) all += sentence.get<std::string>() + "\n";
  EXPECT_THAT(all, testing::HasSubstr("Bumps and potholes from 40 mm on"));
  EXPECT_THAT(all, testing::HasSubstr("lower ones"));
  EXPECT_THAT(all, testing::HasSubstr("Steps across the road from 5 mm on"));
  EXPECT_THAT(all, testing::HasSubstr("no mesh was given"));
}

TEST_F(WriteReport, OneAndManyThreadsGiveTheSameBytes) {
  const road::Mesh mesh = test_support::mesh_of(clean_oval(), 4);
  road::ReportRequest request;
  request.crg_path = write(clean_oval(), "clean.crg");
  request.mesh = &mesh;
  std::string bytes[2];
  for (const unsigned threads : {1u, 5u}) {
    request.threads = threads;
    const auto files = road::write_report(request, (dir_ / "out").string());
    bytes[threads > 1] =
        text_of(files.json_path) + (files.page_path.empty() ? "" : text_of(files.page_path));
  }
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST_F(WriteReport, WhatCannotBeReportedEndsInOneClearLineAndLeavesNothing) {
  road::ReportRequest request;
  request.crg_path = (dir_ / "none.crg").string();
  EXPECT_THROW(road::write_report(request, (dir_ / "out").string()), std::runtime_error);
  std::ofstream(dir_ / "broken.crg") << "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 0.1\n";
  request.crg_path = (dir_ / "broken.crg").string();
  EXPECT_THROW(road::write_report(request, (dir_ / "out").string()), std::runtime_error);
  EXPECT_FALSE(fs::exists(dir_ / "out"));
  request.crg_path = write(clean_oval(), "clean.crg");
  std::ofstream(dir_ / "file") << "in the way";
  try {
    road::write_report(request, (dir_ / "file").string());
    FAIL();
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("file"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("-o"));
  }
}

/// A suite of its own: ctest says that it was skipped where the files are not there.
using ReportOfSamples = WriteReport;

TEST_F(ReportOfSamples, SampleFilesOfTheStandardAllGetAReport) {
  const fs::path samples = fs::path(places::data()) / "opencrg" / "samples";
  if (!fs::is_directory(samples)) GTEST_SKIP() << "no sample files beside the checkout";
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(samples)) {
    // Four of them only include files that are not there.
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".crg" || stem.starts_with("fileref") ||
        stem == "testOptionBorderMode")
      continue;
    road::ReportRequest request;
    request.crg_path = entry.path().string();
    try {
      const json report = report_of(request);
      EXPECT_TRUE(report["verdict"].is_string());
      ++count;
    } catch (const std::exception& error) {
      ADD_FAILURE() << entry.path() << ": " << error.what();
    }
  }
  EXPECT_GT(count, 10u);
}

TEST(ReportPage, TextCannotEndTheDataOrBecomeMarkup) {
  if (!report::page_available()) GTEST_SKIP() << "this build has no page (scripts/setup)";
  report::TrackReport data;
  data.title = "</script><script>alert(1)</script><!-- \xff \xe2\x80\xa8 &amp;";
  data.sheet.v_m = {0.0, 1.0};
  const std::string page = report::report_page(data);
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  const std::size_t begin = page.find("id=\"report-data\">") + 17,
                    end = page.find("</script>", begin);
  const json parsed = base::parse_json<json>(page.substr(begin, end - begin));
  EXPECT_EQ(parsed["title"].get<std::string>().substr(0, 9), "</script>");
  // Nothing outside the file is referred to.
  for (const char* outside : {"src=\"http", "href=\"http", "url(http", "@import"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

}  // namespace write_report_test
