// Mountings, clocks, units and frames that are wrong: refused, or corrected with words that say so.
// KERBSTONE_HEAVY=1: all cases, as a table.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>
#include <regex>

#include "cloud/error.h"
#include "cloud/synth.h"
#include "support/figure.h"
#include "support/lidar_trial.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace wrong_inputs_test {

struct Wrong {
  std::string name;
  std::function<void(Trajectory&)> change;
  double points_times = 1.0;  ///< unit of the points
};

Wrong mounted(std::string name, const Eigen::Isometry3d& extrinsic) {
  return {std::move(name), [extrinsic](Trajectory& t) {
            for (std::size_t i = 0; i < t.size(); ++i) {
              t.position_m[i] += t.orientation[i] * extrinsic.translation();
              t.orientation[i] = t.orientation[i] * Eigen::Quaterniond(extrinsic.rotation());
            }
          }};
}

Wrong turned(const char* name, double deg, const Eigen::Vector3d& axis) {
  return mounted(fmt::format("{} {} deg", name, deg),
                 Eigen::Isometry3d(Eigen::AngleAxisd(deg * std::numbers::pi / 180.0, axis)));
}

Wrong late(double s) {
  return {fmt::format("clock {} s", s), [s](Trajectory& t) {
            for (double& time : t.time_s) time += s;
          }};
}

Wrong moved(std::string name, const Eigen::Matrix4d& T) {
  return {std::move(name), [T](Trajectory& t) {
            const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
            for (std::size_t i = 0; i < t.size(); ++i) {
              t.position_m[i] = R * t.position_m[i] + T.topRightCorner<3, 1>();
              Eigen::Matrix3d axes = R * t.orientation[i].toRotationMatrix();
              if (axes.determinant() < 0.0) axes.col(1) *= -1.0;
              for (int k = 0; k < 3; ++k) axes.col(k).normalize();
              t.orientation[i] = Eigen::Quaterniond(axes).normalized();
            }
          }};
}

const std::regex kPitch("(-?[0-9.]+) deg in pitch");

/// Of the poses against the true ones.
double mean_pitch_deg(const Trajectory& poses, const Trajectory& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    sum += 2.0 * (truth.orientation[i].conjugate() * poses.orientation[i]).y();
  return sum / static_cast<double>(poses.size()) * 180.0 / std::numbers::pi;
}

std::vector<Wrong> all_wrong() {
  std::vector<Wrong> list;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  for (const double deg : {5.0, -5.0, 10.0, -10.0, 20.0, -20.0, 45.0, 90.0, -90.0, 135.0, 180.0})
    list.push_back(turned("yaw", deg, z));
  for (const double deg : {1.0, 2.0, -2.0, 5.0, -5.0, 10.0, -10.0, 20.0, 90.0, 180.0})
    list.push_back(turned("roll", deg, x)), list.push_back(turned("pitch", deg, y));
  for (const double s : {0.05, -0.05, 0.1, -0.1, 0.2, -0.2, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0, 5.0,
                         10.0, 60.0, 3600.0, -3600.0})
    list.push_back(late(s));
  for (const double d : {0.5, -0.5})
    for (const auto& [name, axis] : {std::pair{"ahead", x}, {"left", y}, {"up", z}})
      list.push_back(mounted(fmt::format("lever arm {} m {}", d, name),
                             Eigen::Isometry3d(Eigen::Translation3d(d * axis))));
  const auto scaled = [](double f) {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.topLeftCorner<3, 3>() *= f;
    return T;
  };
  for (const double f : {0.3048, 1.0 / 0.3048, 100.0, 0.01, 1.0 / 0.9144})
    list.push_back(moved(fmt::format("poses times {:.4g}", f), scaled(f)));
  for (const double f : {0.3048, 1.0 / 0.3048, 100.0, 0.001, 0.9144})
    list.push_back({fmt::format("points times {:.4g}", f), [](Trajectory&) {}, f});
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  list.push_back(moved("north east down", T));
  T.topLeftCorner<3, 3>() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  list.push_back(moved("frame turned by 90 deg", T));
  T = Eigen::Matrix4d::Identity(), T(1, 1) = -1.0;
  list.push_back(moved("frame mirrored", T));
  for (const Eigen::Vector3d& d :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 3, 0), Eigen::Vector3d(20, 0, 0),
        Eigen::Vector3d(0, 0, 0.3), Eigen::Vector3d(0, 0, 47)}) {
    T = Eigen::Matrix4d::Identity(), T.topRightCorner<3, 1>() = d;
    list.push_back(moved(fmt::format("frame shifted by {} {} {} m", d.x(), d.y(), d.z()), T));
  }
  return list;
}

TEST(SlowWrongInputs, AreRefusedOrNamed) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const support::TrialRoads roads = support::trial_roads();
  const support::TemporaryFolder folder;
  ScanSynthOptions options;
  options.u_begin_m = 520.0, options.u_end_m = 680.0, options.azimuths = 128, options.cars = 0;
  const ScanSynthReport made = synth_scans(roads.truth, folder.path("scans"), options);
  const Trajectory good = read_trajectory(made.trajectory_path),
                   truth = read_trajectory(made.truth_path);
  std::vector<Wrong> cases = all_wrong();
  EXPECT_GT(cases.size(), 60u);
  if (!heavy)
    std::erase_if(cases, [](const Wrong& w) {
      for (const char* name :
           {"yaw 5 deg", "yaw 90 deg", "pitch 5 deg", "clock 0.05 s", "clock 2 s", "clock 3600 s",
            "lever arm 0.5 m left", "points times 0.3048", "frame shifted by 1 0 0 m"})
        if (w.name == name) return false;
      return true;
    });
  const std::map<std::string, std::string> named = {
      {"yaw 5 deg", "-4.99 deg in yaw"},
      {"yaw 90 deg", "-90 deg in yaw"},
      {"yaw 180 deg", "180 deg in yaw"},
      {"pitch 5 deg", "deg in pitch"},
      {"roll 20 deg", "-20 deg in roll"},
      {"clock 0.05 s", "+0.050 s on the times of the points"},
      {"clock 2 s", "+2.000 s on"},
      {"clock 10 s", "+10.000 s on"},
      {"clock 3600 s", "+3600.000 s on"},
      {"lever arm 0.5 m left", "-0.52 m to the left"},
      {"poses times 3.281", "poses in ft"},
      {"points times 0.3048", "points in m instead of ft"},
      {"frame shifted by 1 0 0 m", "-0.96 0.04 0.01 m in x y z"}};
  cases.insert(cases.begin(), {"right", [](Trajectory&) {}});
  std::size_t accepted = 0;
  for (const Wrong& wrong : cases) {
    Trajectory trajectory = good;
    wrong.change(trajectory);
    measure(trajectory);
    const CloudSource source = [&](const ChunkSink& sink) {
      for (const std::string& path : made.scan_paths)
        read_chunks(path, {}, [&](Cloud&& chunk) {
          for (auto* axis : {&chunk.x_m, &chunk.y_m, &chunk.z_m})
            for (double& value : *axis) value *= wrong.points_times;
          sink(std::move(chunk));
        });
    };
    std::string how, words;
    try {
      MapOptions every;
      every.estimate_every = 1;
      const MapResult result = map_clouds(source, roads.base, &trajectory, every);
      const MapReport& r = result.report;
      const support::TrialError error = support::measure_trial(roads, result, truth, 540.0, 660.0);
      words = fmt::format("{} {}", fmt::join(r.faults, "; "), fmt::join(r.remarks, "; "));
      how = !r.faults.empty() ? "not usable" : !r.remarks.empty() ? "corrected" : "accepted";
      if (r.faults.empty()) {  // what is said to be right is right
        EXPECT_LT(error.z_rmse_m, 0.003) << wrong.name;
        EXPECT_LT(error.z_p99_m, 0.010) << wrong.name;
        EXPECT_LT(error.banking_error_rad, 0.05 * 0.017453293) << wrong.name;
      }
    } catch (const cloud::Error& e) {
      how = "refused", words = e.what();
    }
    if (heavy)
      std::printf("| %s | %s | %s |\n", wrong.name.c_str(), how.c_str(), words.c_str()),
          std::fflush(stdout);
    if (wrong.name == "right") {
      EXPECT_EQ(how, "accepted") << words;
      continue;
    }
    accepted += how == "accepted" ? 1 : 0;
    EXPECT_NE(how, "accepted") << wrong.name;
    if (const auto found = named.find(wrong.name); found != named.end()) {
      EXPECT_THAT(words, ::testing::HasSubstr(found->second)) << wrong.name;
    }
    // What the poses' own drift leaves of the pitch is found with it.
    std::smatch pitch;
    if (wrong.name == "pitch 5 deg" && std::regex_search(words, pitch, kPitch)) {
      EXPECT_NEAR(std::stod(pitch[1]), -5.0 - mean_pitch_deg(good, truth), 0.05);
    }
  }
  support::figure("accepted", static_cast<double>(accepted));
  support::figure("cases", static_cast<double>(cases.size()) - 1.0);
  EXPECT_EQ(accepted, 0u);
}

}  // namespace wrong_inputs_test
}  // namespace cloud
