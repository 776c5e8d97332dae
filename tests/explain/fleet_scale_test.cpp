// Ten thousand drives in one estimate: time and memory.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "../../lib/explain/src/information.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "synthetic_drive.h"

namespace explain {
namespace {

using explain_test::synthetic_drive, explain_test::World;

/// Another drive of the same rows: noise of two drives turned into each other is noise, and what
/// amounts do to the sums is their products.
DriveSummary another(const DriveSummary& one, const DriveSummary& other,
                     const Eigen::MatrixXd& normal, double angle_rad, std::size_t number) {
  DriveSummary out = one;
  const std::size_t road = out.road_columns();
  Eigen::VectorXd amounts = Eigen::VectorXd::Zero(normal.rows());
  for (Eigen::Index knot = 20; knot < 26; ++knot)
    amounts[knot * static_cast<Eigen::Index>(kRoadKinds)] = 0.03;
  const auto sensors = static_cast<Eigen::Index>(road + 60);
  for (Eigen::Index k = sensors; k < amounts.size(); ++k)
    amounts[k] = 0.005 * std::sin(static_cast<double>(number) * static_cast<double>(k));
  const Eigen::VectorXd moved = normal * amounts;
  for (std::size_t k = 0; k < out.by_forces.right.size(); ++k)
    out.by_forces.right[k] = std::cos(angle_rad) * one.by_forces.right[k] +
                             std::sin(angle_rad) * other.by_forces.right[k] +
                             moved[static_cast<Eigen::Index>(k)];
  out.recording_sha256 = out.recording = fmt::format("drive {}", number);
  return out;
}

TEST(FleetScale, TenThousandDrivesTakeAMinuteAndAGigabyteAtMost) {
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    GTEST_SKIP() << "minutes, and 5 GB of disk: KERBSTONE_HEAVY=1";
  const support::TemporaryFolder folder;
  // The size of the trials' road, and as many unknowns as crgexplain summary writes for their logs.
  const World world{.knots = 58,
                    .length_m = 1450,
                    .car_parameters = 30,
                    .car_mechanisms = 30,
                    .sensors = 35,
                    .rows_per_knot = 20};
  constexpr std::size_t kCars = 100, kDrives = 100;
  std::vector<std::string> words{"fleet", "--threads", "2", "-o", folder.path("fleet")};
  for (std::size_t c = 0; c < kCars; ++c) {
    const explain_test::SyntheticCar car{.name = fmt::format("car {}", c),
                                         .mechanism = c == 17 ? 0.4 : 0.0,
                                         .own = 0.002,
                                         .seed = 500 + c};
    const DriveSummary one = synthetic_drive(world, car, 2 * c + 1),
                       other = synthetic_drive(world, {.name = car.name}, 2 * c + 2);
    const Eigen::MatrixXd normal = whole_matrix(one.by_forces, one);
    for (std::size_t d = 0; d < kDrives; ++d) {
      const std::size_t number = c * kDrives + d;
      words.push_back(folder.path(fmt::format("{}", number)));
      std::ofstream(words.back(), std::ios::binary)
          << to_bytes(another(one, other, normal, 0.3 * static_cast<double>(d) / kDrives, number));
    }
  }
  const auto begin = std::chrono::steady_clock::now();
  const support::ToolRun ran = support::run_tool(places::crgexplain(), words);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_EQ(ran.code, 0) << ran.err;
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  const double cpu_s = static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  std::printf("10,000 drives of 100 cars: %.1f s, %.1f s of processor, %.0f MB\n", seconds, cpu_s,
              1e-3 * static_cast<double>(used.ru_maxrss));
  // Of the processor: others may be at work on the machine.
  EXPECT_LE(cpu_s, 60.0);
  EXPECT_LE(used.ru_maxrss, 1000 * 1000);  // kB, of the largest child
  const auto found = nlohmann::json::parse(folder.read("fleet/fleet.json"));
  EXPECT_EQ(found.at("drives"), kCars * kDrives);
  bool road = false, late = false;
  for (const auto& f : found.at("findings")) {
    road = road || f.at("mechanism") == "road.banking";
    late = late || (f.at("mechanism") == "vehicle.0" && f.at("owner") == "car 17");
  }
  EXPECT_TRUE(road && late) << ran.out.substr(0, 2000);
}

}  // namespace
}  // namespace explain
