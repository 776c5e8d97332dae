#include "cloud/map_scans.h"

#include <gtest/gtest.h>

#include <thread>

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

}  // namespace map_scans_test
