// Ten thousand drives in one estimate: time and memory.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <Eigen/Cholesky>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "information.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "synthetic_drive.h"

namespace explain {
namespace fleet_scale_test {

using explain_test::synthetic_drive, explain_test::World;

/// Another drive of the same rows: what amounts do to the sums is their products, and noise of the
/// rows is noise with the products for covariance.
DriveSummary another(const DriveSummary& one, const Eigen::MatrixXd& normal,
                     const Eigen::MatrixXd& root, double mechanism, std::size_t number) {
  DriveSummary out = one;
  const auto road = static_cast<Eigen::Index>(out.road_columns());
  Eigen::VectorXd amounts = Eigen::VectorXd::Zero(normal.rows()), noise = amounts;
  for (Eigen::Index knot = 20; knot < 26; ++knot)
    amounts[knot * static_cast<Eigen::Index>(kRoadKinds)] = 0.03;
  amounts[road + 30] = mechanism;
  for (Eigen::Index k = road + 60; k < amounts.size(); ++k)
    amounts[k] = 0.005 * std::sin(static_cast<double>(number) * static_cast<double>(k));
  base::Random random(number + 1);
  for (double& value : noise) value = random.normal();
  const Eigen::VectorXd right = normal * amounts + root * noise;
  out.by_forces.right.assign(right.data(), right.data() + right.size());
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
    const DriveSummary one = synthetic_drive(world, {.name = fmt::format("car {}", c)}, c + 1);
    const Eigen::MatrixXd normal = whole_matrix(one.by_forces, one);
    // Kinds that nothing is said of have no noise.
    const Eigen::MatrixXd a_little = 1e-9 * Eigen::MatrixXd::Identity(normal.rows(), normal.rows());
    const Eigen::MatrixXd root = (normal + a_little).llt().matrixL();
    for (std::size_t d = 0; d < kDrives; ++d) {
      const std::size_t number = c * kDrives + d;
      words.push_back(folder.path(fmt::format("{}", number)));
      std::ofstream(words.back(), std::ios::binary)
          << to_bytes(another(one, normal, root, c == 17 ? 0.4 : 0.0, number));
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
  support::figure("clock_s", seconds), support::figure("processor_s", cpu_s);
  support::figure("memory_mb", 1e-3 * static_cast<double>(used.ru_maxrss));
  // Of the processor: others may be at work on the machine.
  EXPECT_LE(cpu_s, 60.0);
  EXPECT_LE(used.ru_maxrss, 1000 * 1000);  // kB, of the largest child
  const auto found = base::parse_json<nlohmann::json>(folder.read("fleet/fleet.json"));
  EXPECT_EQ(found.at("drives"), kCars * kDrives);
  bool road = false, late = false;
  for (const auto& f : found.at("findings")) {
    road = road || f.at("mechanism") == "road.banking";
    late = late || (f.at("mechanism") == "vehicle.0" && f.at("owner") == "car 17");
  }
  EXPECT_TRUE(road && late) << ran.out.substr(0, 2000);
}

}  // namespace fleet_scale_test
}  // namespace explain
