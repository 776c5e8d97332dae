#include "road/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace {

TEST(Parallel, VisitsEveryIndexOnceWhateverTheNumberOfThreads) {
  for (const unsigned threads : {0u, 1u, 2u, 7u, 64u}) {
    std::vector<int> visits(1003, 0);
    road::parallel_for(visits.size(), 10, threads, [&](std::size_t begin, std::size_t end) {
      ASSERT_LE(end, visits.size());
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(1003, 1)) << threads;
  }
}

TEST(Parallel, DoesNothingForNothing) {
  road::parallel_for(0, 10, 4, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(Parallel, RethrowsTheErrorOfTheLowestChunkThatFailed) {
  // Every chunk fails, so the lowest is always among them.
  try {
    road::parallel_for(100, 10, 4, [](std::size_t begin, std::size_t) { throw std::runtime_error(std::to_string(begin)); });
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "0");
  }
}

}  // namespace
