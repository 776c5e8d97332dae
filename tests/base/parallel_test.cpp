#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace parallel_test {

TEST(Parallel, VisitsEveryIndexOnceWhateverTheNumberOfThreads) {
  for (const unsigned threads : {0u, 1u, 2u, 7u, 64u}) {
    std::vector<int> visits(1003, 0);
    base::parallel_for(visits.size(), 10, threads, [&](std::size_t begin, std::size_t end) {
      ASSERT_LE(end, visits.size());
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(1003, 1)) << threads;
  }
}

TEST(Parallel, DoesNothingForNothing) {
  base::parallel_for(0, 10, 4, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(Parallel, RethrowsTheErrorOfTheLowestChunkThatFailed) {
  // Every chunk fails, so the lowest is always among them.
  try {
    base::parallel_for(100, 10, 4, [](std::size_t begin, std::size_t) {
      throw std::runtime_error(std::to_string(begin));
    });
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "0");
  }
}

TEST(Parallel, BeginsNothingAfterAnError) {
  for (const unsigned threads : {1u, 4u}) {
    std::atomic<int> begun{0};
    const auto body = [&](std::size_t begin, std::size_t) {
      ++begun;
      if (begin == 0) throw std::runtime_error("no");
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    };
    EXPECT_THROW(base::parallel_for(1000, 1, threads, body), std::runtime_error);
    EXPECT_LT(begun, 500) << threads;
  }
}

}  // namespace parallel_test
