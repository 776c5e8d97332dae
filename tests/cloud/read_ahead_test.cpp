// Scans read by a thread of their own: the same chunks, and errors where they belong.
#include "read_ahead.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "cloud/error.h"

namespace cloud {
namespace read_ahead_test {

constexpr int kMany = 200;

/// Chunks of one point that count up; after `count` of them an error, where there is one.
CloudSource counting(int count, const std::string& error = {}) {
  return [count, error](const ChunkSink& sink) {
    for (int k = 0; k < count; ++k) {
      Cloud chunk;
      chunk.x_m = {static_cast<double>(k)}, chunk.y_m = chunk.z_m = {0.0};
      sink(std::move(chunk));
    }
    if (!error.empty()) throw Error(error);
  };
}

TEST(ReadAhead, HandsOutTheSameChunksInTheSameOrder) {
  for (const unsigned threads : {1u, 2u, 4u}) {
    const CloudSource source = read_ahead(counting(kMany), threads);
    for (int reading = 0; reading < 2; ++reading) {
      std::vector<double> seen;
      source([&](Cloud&& chunk) { seen.push_back(chunk.x_m.at(0)); });
      ASSERT_EQ(seen.size(), static_cast<std::size_t>(kMany));
      for (int k = 0; k < kMany; ++k)
        EXPECT_EQ(seen[static_cast<std::size_t>(k)], static_cast<double>(k));
    }
  }
}

TEST(ReadAhead, ReadsBesideTheCallersThread) {
  std::thread::id reader;
  const CloudSource source = [&](const ChunkSink& sink) {
    reader = std::this_thread::get_id();
    counting(3)(sink);
  };
  read_ahead(source, 1)([](Cloud&&) {});
  EXPECT_EQ(reader, std::this_thread::get_id());
  read_ahead(source, 2)([](Cloud&&) {});
  EXPECT_NE(reader, std::this_thread::get_id());
}

TEST(ReadAhead, AnErrorOfTheSourceComesAfterTheChunksBeforeIt) {
  int taken = 0;
  try {
    read_ahead(counting(5, "the sixth is torn"), 2)([&](Cloud&&) { ++taken; });
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the sixth is torn");
  }
  EXPECT_EQ(taken, 5);
}

TEST(ReadAhead, AnErrorOfTheSinkEndsTheReading) {
  int read = 0, taken = 0;
  const CloudSource source = [&](const ChunkSink& sink) {
    counting(kMany)([&](Cloud&& chunk) { ++read, sink(std::move(chunk)); });
  };
  EXPECT_THROW(read_ahead(source, 2)([&](Cloud&&) {
                 if (++taken == 3) throw Error("no more");
               }),
               Error);
  EXPECT_EQ(taken, 3);
  EXPECT_LE(read, 5);  // those taken, one that lies ready, and one that finds no room
}

TEST(ReadAhead, AnEmptySourceHandsOutNothing) {
  read_ahead(counting(0), 2)([](Cloud&&) { FAIL(); });
}

}  // namespace read_ahead_test
}  // namespace cloud
