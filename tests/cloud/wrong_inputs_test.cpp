// Mountings, clocks, units and frames that are wrong: refused, or corrected with words that say so.
// KERBSTONE_HEAVY=1: all cases, as a table.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>
#include <regex>

#include "causes.h"
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
  std::function<void(Cloud&)> points = {};
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

Wrong mirrored(const char* axis, std::vector<double> Cloud::*of) {
  return {fmt::format("points with {} the other way", axis), [](Trajectory&) {}, 1.0,
          [of](Cloud& chunk) {
            for (double& value : chunk.*of) value = -value;
          }};
}

Wrong timed(std::string name, std::function<double(double)> time_s) {
  return {std::move(name), [](Trajectory&) {}, 1.0,
          [time_s = std::move(time_s)](Cloud& chunk) {
            for (double& value : chunk.time_s) value = time_s(value);
          }};
}

Wrong posed(std::string name,
            std::function<void(Eigen::Vector3d& at_m, Eigen::Quaterniond& turn)> change) {
  return {std::move(name), [change = std::move(change)](Trajectory& t) {
            for (std::size_t i = 0; i < t.size(); ++i) change(t.position_m[i], t.orientation[i]);
          }};
}

/// Only poses that lie so far apart.
Wrong rated(std::string name, double step_s) {
  return {std::move(name), [step_s](Trajectory& t) {
            Trajectory few;
            for (std::size_t i = 0; i < t.size(); ++i) {
              if (!few.time_s.empty() && t.time_s[i] < few.time_s.back() + step_s - 1e-6) continue;
              few.time_s.push_back(t.time_s[i]), few.position_m.push_back(t.position_m[i]);
              few.orientation.push_back(t.orientation[i]);
            }
            t = few;
          }};
}

/// First pose of the second of two laps.
std::size_t second_lap(const Trajectory& t) {
  std::size_t i = 1;
  while (i + 1 < t.size() && t.piece[i] == 0) ++i;
  return i;
}

/// What else goes wrong with times, attitudes and axes.
std::vector<Wrong> more_wrong() {
  constexpr double kSweep_s = 0.1;
  std::vector<Wrong> list{
      timed("points in ns", [](double s) { return 1e9 * s; }),
      timed("points in us", [](double s) { return 1e6 * s; }),
      timed("points in ms", [](double s) { return 1e3 * s; }),
      timed("points timed within each sweep", [](double s) { return std::fmod(s, kSweep_s); }),
      timed("one time for each sweep",
            [](double s) { return kSweep_s * (std::floor(s / kSweep_s) + 1.0); }),
      mirrored("x", &Cloud::x_m),
      mirrored("y", &Cloud::y_m),
      mirrored("z", &Cloud::z_m)};
  for (const auto& [unit, times] : {std::pair{"ns", 1e9}, {"ms", 1e3}})
    list.push_back({fmt::format("poses in {}", unit), [times = times](Trajectory& t) {
                      for (double& s : t.time_s) s *= times;
                    }});
  list.push_back(posed("quaternions that begin with w", [](auto&, Eigen::Quaterniond& q) {
    q = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());
  }));
  list.push_back(posed("inverse poses", [](Eigen::Vector3d& p, Eigen::Quaterniond& q) {
    q = q.conjugate(), p = -(q * p);
  }));
  list.push_back(
      posed("inverse orientations", [](auto&, Eigen::Quaterniond& q) { q = q.conjugate(); }));
  list.push_back(rated("ten poses a second", 0.1));
  list.push_back(rated("one pose a second", 1.0));
  list.push_back(rated("one pose in two seconds", 2.0));
  list.push_back({"poses of the other lap", [](Trajectory& t) {
                    const std::size_t second = second_lap(t);
                    for (std::size_t i = 0; i < second && second + i < t.size(); ++i)
                      std::swap(t.position_m[i], t.position_m[second + i]),
                          std::swap(t.orientation[i], t.orientation[second + i]);
                  }});
  list.push_back({"poses of the first lap for the second", [](Trajectory& t) {
                    const std::size_t second = second_lap(t);
                    for (std::size_t i = 0; i < second && second + i < t.size(); ++i)
                      t.position_m[second + i] = t.position_m[i],
                                            t.orientation[second + i] = t.orientation[i];
                  }});
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T(0, 0) = -1.0;
  list.push_back(moved("frame mirrored in x", T));
  return list;
}

/// Nothing of it is wrong.
std::vector<Wrong> all_right() {
  std::vector<Wrong> list{{"right", [](Trajectory&) {}},
                          rated("right: fifty poses a second", 0.02)};
  list.push_back(posed("right: quaternions of the other sign",
                       [](auto&, Eigen::Quaterniond& q) { q.coeffs() *= -1.0; }));
  Wrong week = timed("right: seconds of the week", [](double s) { return s + 345600.0; });
  week.change = late(345600.0).change;
  list.push_back(week);
  return list;
}

const std::regex kPitch("turned by (-?[0-9.]+) deg in pitch on average");  // where it was corrected

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

/// Two laps round a corner, with a trajectory that drifts.
struct Scans {
  ScanSynthReport made;
  Trajectory poses, truth;

  Scans(const support::TrialRoads& roads, const support::TemporaryFolder& folder,
        std::uint64_t seed = ScanSynthOptions().seed) {
    ScanSynthOptions options;
    options.u_begin_m = 520.0, options.u_end_m = 680.0, options.azimuths = 128, options.cars = 0;
    options.seed = seed;
    made = synth_scans(roads.truth, folder.path("scans"), options);
    poses = read_trajectory(made.trajectory_path), truth = read_trajectory(made.truth_path);
  }
  CloudSource changed(const Wrong& wrong) const {
    return [this, &wrong](const ChunkSink& sink) {
      for (const std::string& path : made.scan_paths)
        read_chunks(path, {}, [&](Cloud&& chunk) {
          for (auto* axis : {&chunk.x_m, &chunk.y_m, &chunk.z_m})
            for (double& value : *axis) value *= wrong.points_times;
          if (wrong.points) wrong.points(chunk);
          if (chunk.size() > 0) sink(std::move(chunk));
        });
    };
  }
};

TEST(SlowWrongInputs, AreRefusedOrNamed) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const support::TrialRoads roads = support::trial_roads();
  const support::TemporaryFolder folder;
  const Scans scans(roads, folder);
  const Trajectory &good = scans.poses, &truth = scans.truth;
  std::vector<Wrong> cases = all_wrong();
  for (Wrong& wrong : more_wrong()) cases.push_back(std::move(wrong));
  EXPECT_GE(cases.size(), 90u);
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
      {"frame shifted by 1 0 0 m", "the frame of the poses moved by -1.0 +0.0 m in x y"}};
  const std::size_t wrong_cases = cases.size();
  const std::vector<Wrong> right = all_right();
  cases.insert(cases.begin(), right.begin(), right.begin() + (heavy ? 4 : 1));
  std::size_t accepted = 0;
  for (const Wrong& wrong : cases) {
    Trajectory trajectory = good;
    wrong.change(trajectory);
    measure(trajectory);
    const CloudSource source = scans.changed(wrong);
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
    if (wrong.name.starts_with("right")) {
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
  support::figure("cases", static_cast<double>(wrong_cases));
  EXPECT_EQ(accepted, 0u);
}

/// Angles about z, y, x in turn.
Eigen::Quaterniond by_angles(double yaw, double pitch, double roll) {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

Wrong attitude(std::string name,
               const std::function<Eigen::Quaterniond(double, double, double)>& of) {
  return posed(std::move(name), [of](auto&, Eigen::Quaterniond& q) {
    const Eigen::Matrix3d R = q.toRotationMatrix();
    q = of(std::atan2(R(1, 0), R(0, 0)), std::asin(-R(2, 0)), std::atan2(R(2, 1), R(2, 2)));
  });
}

/// Only the points for which `keep` holds.
Wrong some_points(std::string name, std::function<bool(const Cloud&, std::size_t)> keep) {
  return {std::move(name), [](Trajectory&) {}, 1.0,
          [keep = std::move(keep)](Cloud& chunk) {
            std::size_t kept = 0;
            for (std::size_t k = 0; k < chunk.size(); ++k) {
              if (!keep(chunk, k)) continue;
              for (auto* values : {&chunk.x_m, &chunk.y_m, &chunk.z_m, &chunk.time_s})
                (*values)[kept] = (*values)[k];
              ++kept;
            }
            chunk.intensity.clear(), chunk.classification.clear(), chunk.sigma_m.clear();
            for (auto* values : {&chunk.time_s, &chunk.x_m, &chunk.y_m, &chunk.z_m})
              values->resize(kept);
          }};
}

std::vector<Wrong> others() {
  using std::numbers::pi;
  std::vector<Wrong> list{
      {"points with x and y swapped", [](Trajectory&) {}, 1.0,
       [](Cloud& c) { std::swap(c.x_m, c.y_m); }},
      {"points with y up", [](Trajectory&) {}, 1.0, [](Cloud& c) { std::swap(c.y_m, c.z_m); }},
      posed("positions with x and y swapped",
            [](Eigen::Vector3d& p, auto&) { std::swap(p.x(), p.y()); }),
      attitude("yaw that turns to the right",
               [](double y, double p, double r) { return by_angles(-y, p, r); }),
      attitude("headings from north",
               [](double y, double p, double r) { return by_angles(pi / 2.0 - y, p, r); }),
      attitude("degrees as radians",
               [](double y, double p, double r) {
                 return by_angles(y * 180.0 / pi, p * 180.0 / pi, r * 180.0 / pi);
               }),
      attitude("roll and pitch swapped",
               [](double y, double p, double r) { return by_angles(y, r, p); }),
      late(7200.0),
      late(18.0),
      late(-604800.0),
      late(0.02),
      posed(
          "quaternions that end with x",
          [](auto&, Eigen::Quaterniond& q) { q = Eigen::Quaterniond(q.x(), q.z(), q.y(), q.w()); }),
      {"points in inches", [](Trajectory&) {}, 1.0 / 0.0254},
      {"points 1 % too far", [](Trajectory&) {}, 1.01},
      timed("sweeps timed from their end", [](double s) {
        const double sweep = std::floor(10.0 * s);
        return 0.1 * (2.0 * sweep + 1.0) - s;
      })};
  list.push_back(mounted("poses of another sensor",
                         Eigen::Translation3d(-1.2, 0.7, 0.4) *
                             Eigen::AngleAxisd(pi / 3.0, Eigen::Vector3d::UnitZ())));
  Wrong fast = late(0.0);
  fast.name = "clock of the poses 0.5 % fast";
  fast.change = [](Trajectory& t) {
    for (double& s : t.time_s) s *= 1.005;
  };
  list.push_back(fast);
  // Nothing of the rest is wrong.
  for (const double s : {1.7e9, -500.0}) {
    Wrong both =
        timed(fmt::format("right: times from {:.0f} s", s), [s](double t) { return t + s; });
    both.change = late(s).change;
    list.push_back(both);
  }
  Wrong turned_both =
      mounted("right: a sensor that looks to the left",
              Eigen::Isometry3d(Eigen::AngleAxisd(pi / 2.0, Eigen::Vector3d::UnitZ())));
  turned_both.points = [](Cloud& c) {
    std::swap(c.x_m, c.y_m);
    for (double& y : c.y_m) y = -y;
  };
  list.push_back(turned_both);
  list.push_back(some_points("right: one point of two",
                             [](const Cloud&, std::size_t k) { return k % 2 == 0; }));
  list.push_back(some_points("right: nothing beyond 40 m", [](const Cloud& c, std::size_t k) {
    return c.point(k).norm() < 40.0;
  }));
  list.push_back(some_points("right: the last two seconds are missing",
                             [](const Cloud& c, std::size_t k) { return c.time_s[k] < 19.0; }));
  list.push_back({"right: poses that shake by half a millimetre", [](Trajectory& t) {
                    for (std::size_t i = 0; i < t.size(); ++i)
                      for (int k = 0; k < 3; ++k)
                        t.position_m[i][k] +=
                            5e-4 * std::sin(7919.0 * static_cast<double>(i) + 131.0 * k);
                  }});
  list.push_back(rated("right: thirty-three poses a second", 0.03));
  return list;
}

// Made after the causes were, and never tuned on.
TEST(SlowWrongInputs, OthersAreRefusedOrNamedToo) {
  const support::TrialRoads roads = support::trial_roads();
  const support::TemporaryFolder folder;
  const Scans scans(roads, folder, 4711);
  for (const Wrong& wrong : others()) {
    Trajectory trajectory = scans.poses;
    wrong.change(trajectory);
    measure(trajectory);
    std::string how, words;
    double rmse_m = -1.0;
    try {
      MapOptions every;
      every.estimate_every = 1;
      const MapResult result = map_clouds(scans.changed(wrong), roads.base, &trajectory, every);
      const MapReport& r = result.report;
      words = fmt::format("{} {}", fmt::join(r.faults, "; "), fmt::join(r.remarks, "; "));
      how = !r.faults.empty() ? "not usable" : !r.remarks.empty() ? "corrected" : "accepted";
      rmse_m = support::measure_trial(roads, result, scans.truth, 540.0, 660.0).z_rmse_m;
      if (r.faults.empty()) {
        EXPECT_LT(rmse_m, 0.003) << wrong.name;
      }
    } catch (const cloud::Error& e) {
      how = "refused", words = e.what();
    }
    if (std::getenv("KERBSTONE_HEAVY") != nullptr)
      std::printf("| %s | %s | %.1f mm | %s |\n", wrong.name.c_str(), how.c_str(), 1e3 * rmse_m,
                  words.c_str()),
          std::fflush(stdout);
    if (wrong.name.starts_with("right")) {
      EXPECT_TRUE(how == "accepted" || how == "corrected") << wrong.name << ": " << words;
    } else {
      EXPECT_NE(how, "accepted") << wrong.name;
    }
  }
}

/// What comes first of a text of causes.
std::string first_of(const std::string& text) {
  const std::string before = "better, the best first: ";
  const std::size_t at = text.find(before);
  return at == std::string::npos ? text : text.substr(at + before.size());
}

// What the map itself need not be made for; the other kinds are corrected by it, or seen by it.
TEST(SlowWrongInputs, TheTrueCauseComesFirst) {
  const std::pair<const char*, const char*> named[] = {
      {"yaw 45 deg", "the sensor turned by -45 deg in yaw"},
      {"yaw 135 deg", "the sensor turned by -135 deg in yaw"},
      {"yaw 180 deg", "the sensor turned by 180 deg in yaw"},
      {"roll 90 deg", "the sensor turned by -90 deg in roll"},
      {"pitch 90 deg", "the sensor turned by -90 deg in pitch"},
      {"roll 180 deg", "the sensor turned by 180 deg in roll"},
      {"pitch 180 deg", "the sensor turned by 180 deg in pitch"},
      {"lever arm 0.5 m left", "the sensor -0.50 m to the left"},
      {"lever arm 0.5 m up", "the sensor -0.50 m up"},
      {"poses times 3.281", "poses in ft instead of m"},
      {"points times 0.9144", "points in m instead of yard"},
      {"north east down", "the poses are north, east, down"},
      {"frame turned by 90 deg", "the frame of the poses is turned by 90 deg"},
      {"frame mirrored", "the frame of the poses has y the other way"},
      {"frame mirrored in x", "the frame of the poses has x the other way"},
      {"frame shifted by 1 0 0 m", "the frame of the poses moved by -1.0 +0.0 m in x y"},
      {"frame shifted by 20 0 0 m", "tried with"},
      {"frame shifted by 0 0 47 m", "tried with"},
      {"points in ns", "the times of the points look like ns"},
      {"points in us", "the times of the points look like us"},
      {"points in ms", "the times of the points look like ms"},
      {"poses in ns", "the times of the trajectory look like ns"},
      {"poses in ms", "the times of the trajectory look like ms"},
      {"points timed within each sweep", "the times of the points begin again 159 times"},
      {"one time for each sweep", "all points of a sweep have one time"},
      {"points with x the other way", "the points with x the other way"},
      {"points with y the other way", "the points with y the other way"},
      {"points with z the other way", "the points with z the other way"},
      {"quaternions that begin with w", "the quaternions begin with w"},
      {"inverse poses", "the poses are the map in the sensor's frame"},
      {"inverse orientations", "the orientations are the map's in the sensor's frame"},
      {"poses of the other lap", "points and poses are of different laps"},
      {"poses of the first lap for the second", "points and poses are of different laps: +13.000"}};
  const support::TrialRoads roads = support::trial_roads();
  const support::TemporaryFolder folder;
  const Scans scans(roads, folder);
  const RoadFrame frame(roads.base);
  std::vector<Wrong> cases = all_wrong();
  for (Wrong& wrong : more_wrong()) cases.push_back(std::move(wrong));
  for (const auto& [name, cause] : named) {
    const auto wrong = std::find_if(cases.begin(), cases.end(),
                                    [name = name](const Wrong& w) { return w.name == name; });
    ASSERT_NE(wrong, cases.end()) << name;
    Trajectory trajectory = scans.poses;
    wrong->change(trajectory);
    measure(trajectory);
    const std::string text = likely_causes(scans.changed(*wrong), frame, trajectory, MapOptions());
    EXPECT_THAT(first_of(text), ::testing::StartsWith(cause)) << name;
  }
}

}  // namespace wrong_inputs_test
}  // namespace cloud
