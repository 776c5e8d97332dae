// Many passes over one place.
#include <gtest/gtest.h>

#include "cloud/map.h"
#include "cloud/read_cloud.h"
#include "cloud/synth.h"
#include "support/figure.h"
#include "support/lidar_trial.h"
#include "support/temporary_folder.h"

namespace many_passes_test {

// Ten passes agree to a tenth of a millimetre: what all of them are off by must not be taken for
// the base's error, which they would follow away from it.
TEST(SlowManyPasses, FindTheBaseAsTwoDo) {
  const support::TemporaryFolder folder;
  const support::TrialRoads roads = support::trial_roads();
  cloud::ScanSynthOptions synth;
  synth.u_begin_m = 180.0, synth.u_end_m = 420.0;
  synth.azimuths = 140;
  synth.laps = 10;
  cloud::synth_scans(roads.truth, folder.path("."), synth);
  const cloud::Trajectory trajectory = cloud::read_trajectory(folder.path("trajectory.csv")),
                          truth = cloud::read_trajectory(folder.path("truth_trajectory.csv"));
  const cloud::MapResult result = cloud::map_clouds(
      [&](const cloud::ChunkSink& sink) {
        for (const std::string& path : cloud::cloud_files(folder.path(".")))
          cloud::read_chunks(path, {}, sink);
      },
      roads.base, &trajectory, {});
  EXPECT_TRUE(result.report.converged);
  EXPECT_EQ(result.report.passes, 10u);
  const auto trial = support::measure_trial(roads, result, truth, 200.0, 400.0);
  EXPECT_LT(trial.z_rmse_m, 1.0e-3);
  support::figure("z_rmse_mm", 1e3 * trial.z_rmse_m);
}

}  // namespace many_passes_test
