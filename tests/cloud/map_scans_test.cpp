#include "cloud/map_scans.h"

#include <gtest/gtest.h>

#include <thread>
#include <tuple>

#include "support/temporary_folder.h"

namespace map_scans_test {

// Callers of refine(), Python among them, hear of its progress in their own thread alone.
TEST(MapScans, ProgressIsToldInTheThreadThatMadeThem) {
  const support::TemporaryFolder folder;
  std::string points;
  for (int k = 0; k < 1000; ++k) points += std::to_string(k % 40) + " 1.5 0.25\n";
  cloud::RefineRequest request;
  for (const char* name : {"a.xyz", "b.xyz"}) {
    folder.file(name, points);
    request.scans.push_back(folder.path(name));
  }
  std::vector<double> shares;
  std::vector<std::thread::id> threads;
  cloud::MapScans scans(request, request.scans, [&](const std::string& stage, double share) {
    EXPECT_EQ(stage, "reading");
    shares.push_back(share), threads.push_back(std::this_thread::get_id());
  });
  scans.enter("reading", 0.2, 0.6);
  std::size_t read = 0;
  std::thread([&] { scans.source()([&](cloud::Cloud&& chunk) { read += chunk.size(); }); }).join();
  EXPECT_EQ(read, 2000u);
  EXPECT_TRUE(shares.empty());
  scans.tell();
  ASSERT_EQ(shares.size(), 1u);
  EXPECT_NEAR(shares[0], 0.6, 0.01);  // all was read
  // In this thread without being asked.
  scans.source()([](cloud::Cloud&&) {});
  EXPECT_GT(shares.size(), 1u);
  for (const std::thread::id thread : threads) EXPECT_EQ(thread, std::this_thread::get_id());
}

// A foot is 0.3048 m, that of American surveys 1200/3937 m: 0.6 m apart at 1,000,000 ft.
TEST(MapScans, ReadsTheUnitThatIsGiven) {
  const support::TemporaryFolder folder;
  cloud::RefineRequest request;
  request.scans = {folder.file("a.xyz", "10000 -2500 50\n")};
  const auto point_in = [&](const std::string& unit) {
    request.unit = unit;
    cloud::MapScans scans(request, request.scans, [](const std::string&, double) {});
    Eigen::Vector3d point(0.0, 0.0, 0.0);
    scans.source()([&](cloud::Cloud&& chunk) { point = chunk.origin_m + chunk.point(0); });
    return point;
  };
  for (const auto& [unit, x_m, y_m, z_m] : {std::tuple{"ft", 3048.0, -762.0, 15.24},
                                            {"us-ft", 3048.0060960, -762.0015240, 15.2400305},
                                            {"m", 10000.0, -2500.0, 50.0}}) {
    const Eigen::Vector3d seen = point_in(unit);
    EXPECT_NEAR(seen.x(), x_m, 1e-6) << unit;
    EXPECT_NEAR(seen.y(), y_m, 1e-6) << unit;
    EXPECT_NEAR(seen.z(), z_m, 1e-5) << unit;
  }
}

}  // namespace map_scans_test
