// The road is judged by the road: the same faults are errors between its edges and remarks beyond.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "make/make_reported.h"
#include "mesh/export_mesh.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace judged_test {

using support::add_ring_strip;
using ::testing::HasSubstr;

constexpr double kBegin_m = 200.0, kEnd_m = 204.0;  // of the faulty piece along the ring

/// What is done to a piece of the mesh 3 m wide: its heights, or nothing where it is left out.
struct Fault {
  const char* name;
  bool left_out;
  std::function<double(double s_m, double across)> height_m;  ///< across: 0 to 1
};

const std::vector<Fault>& faults() {
  static const std::vector<Fault> all{
      {"hole", true, {}},
      {"spike", false,
       [](double s_m, double across) {
         return 0.6 * std::max(0.0, 1.0 - std::abs(s_m - 202.0) - 2.0 * std::abs(across - 0.5));
       }},
      {"step", false, [](double, double) { return 0.45; }},
      {"wrong deck", false, [](double, double) { return -0.9; }},
      {"pothole", false,
       [](double s_m, double across) {
         return -0.5 * std::max(0.0, 1.0 - 0.5 * std::abs(s_m - 202.0)) *
                std::max(0.0, 1.0 - 2.0 * std::abs(across - 0.5));
       }},
  };
  return all;
}

/// Road to 4.5 m on both sides, grass to 13.5 m, in strips of 3 m; one of them is at fault.
road::Mesh ring_with(const Fault& fault, double faulty_right_m) {
  road::Mesh mesh;
  for (double right_m = -13.5; right_m < 13.0; right_m += 3.0) {
    const std::string name = std::abs(right_m + 1.5) < 4.0 ? "TKMN1" : "TKLS1";
    const double left_m = right_m + 3.0;
    if (right_m != faulty_right_m) {
      add_ring_strip(mesh, name, right_m, left_m, 0.0, 0.0);
      continue;
    }
    add_ring_strip(mesh, name, right_m, left_m, 0.0, 0.0, kEnd_m,
                   support::kRingLength_m + kBegin_m);
    if (fault.left_out) continue;
    constexpr int kAcross = 6;
    for (int k = 0; k < kAcross; ++k) {
      const std::size_t first = mesh.vertices_m.size();
      add_ring_strip(mesh, name, right_m + 3.0 * k / kAcross, right_m + 3.0 * (k + 1) / kAcross,
                     0.0, 0.0, kBegin_m, kEnd_m);
      for (std::size_t v = first; v < mesh.vertices_m.size(); ++v) {
        Eigen::Vector3d& p = mesh.vertices_m[v];
        const double s_m = support::kRing_m * std::atan2(p.y(), p.x());
        const double left = support::kRing_m - p.head<2>().norm();
        p.z() =
            fault.height_m(s_m < 0.0 ? s_m + support::kRingLength_m : s_m, (left - right_m) / 3.0);
      }
    }
  }
  return mesh;
}

struct Judged {
  road::ReportFiles files;
  std::string said;  ///< by findings and remarks
};

Judged judge(const road::Mesh& mesh) {
  const support::TemporaryFolder folder;
  road::export_mesh(mesh, folder.path("ring.obj"), {road::UpAxis::z, road::Unit::m});
  road::BuildRequest request;
  request.input = folder.path("ring.obj");
  request.output_dir = folder.path("out");
  request.values = {{"up", "z"}, {"u_step_m", "0.5"}, {"v_step_m", "0.25"}};
  const road::ReportedBuild built = road::make_reported(request);
  std::ifstream file(built.report->json_path);
  const auto report = nlohmann::json::parse(file);
  return {*built.report,
          base::dump_json(report.at("findings")) + base::dump_json(report.at("notes"))};
}

void expect_error(const Fault& fault) {
  const Judged inside = judge(ring_with(fault, -1.5));
  EXPECT_EQ(inside.files.verdict, road::Verdict::not_usable) << fault.name;
  EXPECT_TRUE(std::any_of(inside.files.errors.begin(), inside.files.errors.end(),
                          [](const std::string& e) { return e.find(" u = ") != e.npos; }))
      << fault.name;
}

void expect_mark(const Fault& fault, double right_m) {
  const Judged beyond = judge(ring_with(fault, right_m));
  EXPECT_NE(beyond.files.verdict, road::Verdict::not_usable)
      << fault.name << " at " << right_m << ": "
      << (beyond.files.errors.empty() ? "" : beyond.files.errors.front());
  EXPECT_THAT(beyond.said, HasSubstr("beyond the ")) << fault.name << " is marked";
}

TEST(Judged, AHoleAndASpikeOfTheRoadAreErrorsBeyondItsEdgesTheyAreNot) {
  for (std::size_t k = 0; k < 2; ++k) {
    expect_error(faults()[k]);
    expect_mark(faults()[k], 4.5 + 3.0 * static_cast<double>(k));
  }
}

/// Road to 4.5 m on both sides, and on the right, from begin_m to end_m alone, 1.5 m more.
road::Mesh ring_widened(double begin_m, double end_m) {
  road::Mesh mesh;
  add_ring_strip(mesh, "TKMN1", -4.5, 4.5, 0.0, 0.0);
  add_ring_strip(mesh, "TKMN2", -6.0, -4.5, 0.0, 0.0, begin_m, end_m);
  return mesh;
}

TEST(Judged, AKerbThatBeginsAtARightAngleIsNoHoleALostStripIs) {
  const Judged kerb = judge(ring_widened(200.0, 230.0));
  EXPECT_NE(kerb.files.verdict, road::Verdict::not_usable)
      << (kerb.files.errors.empty() ? "" : kerb.files.errors.front());
  const Judged lost = judge(ring_widened(230.0, support::kRingLength_m + 200.0));
  EXPECT_EQ(lost.files.verdict, road::Verdict::not_usable);
}

TEST(SlowJudged, EveryFaultAtEveryPlace) {
  for (const Fault& fault : faults()) {
    expect_error(fault);
    for (const double right_m : {-13.5, -7.5, 4.5, 7.5}) expect_mark(fault, right_m);
  }
}

}  // namespace judged_test
