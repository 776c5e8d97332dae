// Two synthetic laps refine a wrong base: errors against the truth, and seconds by stage.
//   lidar_map_bench FOLDER [u_begin u_end [azimuths [seed [threads [times [laps]]]]]]
// Ten passes, 17.8 million points: 180 420 278 1 0 1 10; two, for the time of a point: ... 1 2.
// Scans stay in FOLDER. `times` hands out every point so many times in a row, as a scanner of so
// many times the points would: to load time and memory with more points than the disk holds.
#include <fmt/format.h>
#include <time.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "inspect/input_file.h"
#include "make/summary.h"
#include "support/lidar_trial.h"

namespace {

double processor_seconds(clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Every point so many times in a row.
cloud::Cloud repeated(const cloud::Cloud& chunk, std::size_t times) {
  cloud::Cloud out;
  out.origin_m = chunk.origin_m;
  for (std::size_t i = 0; i < chunk.size(); ++i) {
    out.x_m.insert(out.x_m.end(), times, chunk.x_m[i]);
    out.y_m.insert(out.y_m.end(), times, chunk.y_m[i]);
    out.z_m.insert(out.z_m.end(), times, chunk.z_m[i]);
    if (!chunk.time_s.empty()) out.time_s.insert(out.time_s.end(), times, chunk.time_s[i]);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string folder = argv[1];
  const auto argument = [&](int k, double otherwise) {
    return argc > k ? std::atof(argv[k]) : otherwise;
  };
  cloud::ScanSynthOptions synth;
  synth.u_begin_m = argument(2, 380.0), synth.u_end_m = argument(3, 900.0);
  synth.azimuths = static_cast<int>(argument(4, 1024));
  synth.seed = static_cast<std::uint64_t>(argument(5, 1));
  synth.laps = static_cast<int>(argument(8, 2));
  const auto times = static_cast<std::size_t>(argument(7, 1));
  const support::TrialRoads roads = support::trial_roads();
  const auto seconds = [start = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  if (!std::filesystem::exists(folder + "/trajectory.csv")) {
    const cloud::ScanSynthReport made = cloud::synth_scans(roads.truth, folder, synth);
    fmt::print("{} points, {:.1f} % on cars, made in {:.1f} s\n", made.points,
               100.0 * made.share_on_cars, seconds());
  }
  const cloud::Trajectory trajectory = cloud::read_trajectory(folder + "/trajectory.csv"),
                          truth = cloud::read_trajectory(folder + "/truth_trajectory.csv");
  cloud::MapOptions options;
  cloud::CloudReadOptions per_chunk;
  per_chunk.chunk_points /= times;
  options.threads = static_cast<unsigned>(argument(6, 0));
  const double before = seconds(), processor_before = processor_seconds(),
               main_before = processor_seconds(CLOCK_THREAD_CPUTIME_ID);
  const cloud::MapResult result = cloud::map_clouds(
      [&](const cloud::ChunkSink& sink) {
        for (const std::string& path : cloud::cloud_files(folder))
          cloud::read_chunks(path, per_chunk, [&](cloud::Cloud&& chunk) {
            sink(times > 1 ? repeated(chunk, times) : std::move(chunk));
          });
      },
      roads.base, &trajectory, options);
  const double took = seconds() - before, processor = processor_seconds() - processor_before,
               main_thread = processor_seconds(CLOCK_THREAD_CPUTIME_ID) - main_before;
  const cloud::MapReport& r = result.report;
  fmt::print("{}", support::describe(support::measure_trial(
                       roads, result, truth, synth.u_begin_m + 20.0, synth.u_end_m - 20.0)));
  fmt::print(
      "converged {} after {} rounds; inliers {:.0f} %; rms {:.1f} -> {:.1f} mm; between passes "
      "{:.1f} -> {:.1f} mm\n",
      r.converged, r.iterations, 100.0 * r.inlier_share, 1e3 * r.rms_before_m, 1e3 * r.rms_after_m,
      1e3 * r.pass_rms_before_m, 1e3 * r.pass_rms_after_m);
  fmt::print(
      "the base's deviation {:.2f} mm, {:.1f} cells together; views {:.2f} of assumed, {:.1f} "
      "together\n",
      1e3 * r.base_stddev_m, r.base_together, r.view_stddev_factor, r.view_together);
  fmt::print(
      "typical deviations stated: x {:.2f}, y {:.2f}, z {:.2f} mm; roll {:.3f}, pitch {:.3f}, yaw "
      "{:.3f} mrad\n",
      1e3 * r.typical_stddev[0], 1e3 * r.typical_stddev[1], 1e3 * r.typical_stddev[2],
      1e3 * r.typical_stddev[3], 1e3 * r.typical_stddev[4], 1e3 * r.typical_stddev[5]);
  fmt::print("points {}, used {}, coverage {:.1f} %\n", r.points, r.used, 100.0 * r.coverage);
  fmt::print(
      "{:.2f} s: first reading {:.2f}, drift {:.2f}, grid {:.2f}, fusion {:.2f}; reading the files "
      "twice {:.2f} of it\n",
      took, r.seconds_estimate, r.seconds_drift, r.seconds_grid, r.seconds_fuse, r.seconds_read);
  // The main thread does what is not shared, and its part of what is: on an idle machine that is
  // the wall time.
  fmt::print(
      "{:.2f} M points/s; processor time {:.2f} s, of it {:.2f} s in the main thread ({:.2f} M "
      "points/s); peak memory {:.0f} MB\n",
      1e-6 * static_cast<double>(r.points) / took, processor, main_thread,
      1e-6 * static_cast<double>(r.points) / main_thread, road::peak_memory_mb());
}
