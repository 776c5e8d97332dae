// A base whose cross slope is off as a whole: the stated deviations must hold what the points do
// not tell, also in thin scans of one drive. KERBSTONE_HEAVY=1: the figures of docs/evidence.md.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "circuit/circuit.h"
#include "cloud/synth.h"
#include "support/figure.h"
#include "support/lidar_trial.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace tilted_base_test {

struct Drive {
  double u_begin_m = 560.0, u_end_m = 760.0;
  int beams = 16, azimuths = 64, laps = 1;
  std::uint64_t seed = 1;
};

struct Outcome {
  MapReport report;
  double nodes = 0.0, rmse_m = 0.0, within_90 = 0.0;
};

/// The road, and the same turned about its middle line.
crg::Crg tilted(crg::Crg road, double slope) {
  for (std::size_t i = 0; i < road.grid.rows(); ++i)
    for (std::size_t j = 0; j < road.grid.columns(); ++j)
      road.grid.z_m[i * road.grid.columns() + j] += static_cast<float>(slope * road.grid.v_m[j]);
  return road;
}

crg::Crg demo_road() {
  return road::truth_crg(road::Circuit(
      road::read_circuit(places::source() + "/tracks/kerbstone-ring/circuit.yaml").design()));
}

Outcome refine(const crg::Crg& truth, const crg::Crg& base, const Drive& drive) {
  const support::TemporaryFolder folder;
  ScanSynthOptions synth;
  synth.u_begin_m = drive.u_begin_m, synth.u_end_m = drive.u_end_m, synth.laps = drive.laps;
  synth.beams = drive.beams, synth.azimuths = drive.azimuths, synth.seed = drive.seed;
  const ScanSynthReport made = synth_scans(truth, folder.path("scans"), synth);
  const Trajectory trajectory = read_trajectory(made.trajectory_path);
  const MapResult result = map_clouds(
      [&](const ChunkSink& sink) {
        for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
      },
      base, &trajectory);
  Outcome out;
  out.report = result.report;
  for (std::size_t i = 0; i < truth.grid.rows(); ++i) {
    const double u = truth.grid.u_of(i);
    if (u < drive.u_begin_m + 20.0 || u > drive.u_end_m - 20.0) continue;
    for (std::size_t j = 0; j < truth.grid.columns(); ++j) {
      if (std::abs(truth.grid.v_m[j]) > 9.0 ||
          !(result.source.at(i, j) == static_cast<float>(NodeSource::lidar)))
        continue;
      const double e = static_cast<double>(result.grid.at(i, j) - truth.grid.at(i, j));
      out.nodes += 1.0, out.rmse_m += e * e;
      out.within_90 += std::abs(e) <= 1.645 * static_cast<double>(result.stddev.at(i, j)) ? 1 : 0;
    }
  }
  out.rmse_m = std::sqrt(out.rmse_m / out.nodes), out.within_90 /= out.nodes;
  return out;
}

std::string row(const char* what, double slope, const Drive& drive, const Outcome& out) {
  std::string text = fmt::format(
      "| {} | {:.1f} mrad | {} x {}, {} drives, seed {} | {} after {} | {:.2f} mm | {:.1f} % | "
      "{:.2f} +- "
      "{:.2f} mrad |",
      what, 1e3 * slope, drive.beams, drive.azimuths, drive.laps, drive.seed,
      out.report.converged ? "converged" : "not", out.report.iterations, 1e3 * out.rmse_m,
      100.0 * out.within_90, 1e3 * out.report.base_tilt, 1e3 * out.report.base_tilt_stddev);
  const std::string at = fmt::format("{} {} mrad ", what,
                                     slope > 0.0125 ? 25
                                     : slope == 0.0 ? 0
                                                    : 12);
  support::figure_of_case(at + "z_mm", 1e3 * out.rmse_m);
  support::figure_of_case(at + "inside_percent", 100.0 * out.within_90);
  support::figure_of_case(at + "stated_mrad", 1e3 * out.report.base_tilt_stddev);
  return text;
}

// Cells were compared with the base as if it had its own slope within them: that pulled the car's
// roll towards the base's wrong banking. The nodes' wrong slopes counted as independent of one
// another. 8 to 15 mm, and intervals of 90 % that held 32 to 59 %.
TEST(TiltedBase, InABendIsFoundByThinScansOfOneDrive) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const crg::Crg truth = demo_road();
  struct Case {
    double slope;
    std::uint64_t seed;
  };
  // The last one held 72.6 % while cells were not gathered again after the poses had turned back.
  std::vector<Case> cases = {{0.006, 1}, {0.0175, 14}};
  if (heavy) {
    cases.clear();
    for (const double slope : {0.0, 0.003, -0.006, 0.006, 0.012, 0.0175, 0.025})
      for (std::uint64_t seed = 1; seed <= 8; ++seed) cases.push_back({slope, seed});
  }
  for (const auto& [slope, seed] : cases) {
    Drive drive;
    drive.seed = seed;
    const Outcome out = refine(truth, tilted(truth, slope), drive);
    SCOPED_TRACE(row("bend", slope, drive, out));
    EXPECT_TRUE(out.report.converged);
    EXPECT_GT(out.nodes, 10000.0);
    EXPECT_LT(out.rmse_m, 0.003);
    EXPECT_GT(out.within_90, 0.85);
    EXPECT_LT(out.within_90, 0.95);
    EXPECT_NEAR(out.report.base_tilt, -slope, 4.0 * out.report.base_tilt_stddev);
    EXPECT_LT(out.report.base_tilt_stddev, 0.0005);
  }
}

// On a straight the sensor's roll and the base's tilt look alike, however dense the scans are: 1.2
// mm were stated where the road was 29 mm off.
TEST(TiltedBase, OnAStraightIsStatedAsUnknown) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const crg::Crg truth = demo_road();
  for (std::uint64_t seed = 1; seed <= (heavy ? 8u : 1u); ++seed)
    for (const double slope : {0.0, 0.006}) {
      Drive drive;
      drive.u_begin_m = 20.0, drive.u_end_m = heavy ? 220.0 : 140.0, drive.seed = seed;
      if (heavy)
        drive.beams = 64, drive.azimuths = 128, drive.laps = 1 + static_cast<int>(seed % 2);
      const Outcome out = refine(truth, tilted(truth, slope), drive);
      SCOPED_TRACE(row("straight", slope, drive, out));
      EXPECT_TRUE(out.report.converged);
      EXPECT_GT(out.within_90, 0.85);
      EXPECT_GT(out.report.base_tilt_stddev, 0.003);
      EXPECT_THAT(out.report.remarks,
                  ::testing::Contains(::testing::HasSubstr("a stretch with a bend would tell")));
    }
}

// The tilt is one error of the whole road: in one road all nodes are inside the interval or most
// are not. Over bases whose heights are off by 20 mm rms over 10 m, as is stated, 90 % are.
TEST(SlowTiltedBase, OnAStraightIntervalsHoldOverBasesAsGoodAsStated) {
  const crg::Crg truth = demo_road();
  const double deviation = 0.02 / (10.0 / std::sqrt(12.0));
  double within = 0.0, count = 0.0;
  // Middles of ten equally likely parts of how far a normal deviate lies from zero.
  for (const double times :
       {0.063, 0.189, 0.319, 0.454, 0.598, 0.755, 0.935, 1.150, 1.440, 1.960}) {
    Drive drive;
    drive.u_begin_m = 20.0, drive.u_end_m = 140.0;
    const double slope = times * deviation;
    const Outcome out = refine(truth, tilted(truth, slope), drive);
    support::figure_of_case("road_inside_percent", 100.0 * out.within_90);
    EXPECT_TRUE(out.report.converged) << slope;
    within += out.within_90, count += 1.0;
  }
  support::figure("inside_percent", 100.0 * within / count);
  EXPECT_GT(within / count, 0.85);
  EXPECT_LT(within / count, 0.95);
}

}  // namespace tilted_base_test
}  // namespace cloud
