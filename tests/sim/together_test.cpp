#include "together.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <thread>

#include "real_time.h"

namespace together_test {

using sim::Standing, sim::Together;

/// Exit code of a process that does this.
class Process {
 public:
  explicit Process(const std::function<int()>& work) : id_(::fork()) {
    if (id_ == 0) ::_exit(work());
  }
  int wait() const {
    int status = 0;
    ::waitpid(id_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }

 private:
  pid_t id_;
};

/// A thousand steps, of which every one has to know where the others are.
int go(Together& together, std::size_t own, std::uint64_t steps, unsigned rest_us) {
  together.begin();
  for (std::uint64_t step = 0; step < steps; ++step) {
    if (step % 100 == own) ::usleep(rest_us);
    const double at = static_cast<double>(1000 * own + step);
    const auto all = together.meet(own, step, {true, at, -at, true});
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double wanted = static_cast<double>(1000 * k + step);
      if (all[k].is_there && (all[k].x_m != wanted || all[k].y_m != -wanted)) return 2;
      if (!all[k].is_there && all[k].is_driven) return 3;
      if (!all[k].is_there && k != 2) return 4;
      if (k == 2 && all[k].is_there != (step < 500)) return 5;
    }
  }
  return 0;
}

TEST(Together, EveryoneKnowsOfEveryStepWhereTheOthersAre) {
  Together together(3);
  const Process first([&] { return go(together, 0, 1000, 300); }),
      second([&] { return go(together, 1, 1000, 700); }), third([&] {
        const int code = go(together, 2, 500, 0);
        if (code == 0) together.leave(2);
        return code;
      });
  EXPECT_EQ(third.wait(), 0);
  EXPECT_EQ(second.wait(), 0);
  EXPECT_EQ(first.wait(), 0);
}

TEST(Together, WhoCrashedIsNotWaitedForWhenSomebodySaysSo) {
  Together together(2);
  const Process crashes([&] {
    together.begin();
    together.meet(0, 0, {true, 1.0, 2.0, true});
    ::_exit(9);
    return 0;
  });
  const Process goes_on([&] {
    together.begin();
    if (!together.meet(1, 0, {true, 3.0, 4.0, true})[0].is_there) return 2;
    return together.meet(1, 1, {true, 3.0, 4.0, true})[0].is_there ? 3 : 0;
  });
  EXPECT_EQ(crashes.wait(), 9);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  together.leave(0);
  EXPECT_EQ(goes_on.wait(), 0);
}

TEST(Together, AllBeginAtOneTimeAndLookWithoutWaiting) {
  Together together(2);
  const double before_s = sim::now_s();
  const Process other([&] {
    const double begin_s = together.begin();
    // Places that belong together, however fast they change.
    for (std::uint64_t step = 0; step < 200000; ++step)
      together.look(1, step,
                    {true, begin_s + static_cast<double>(step), static_cast<double>(step), true});
    return 0;
  });
  const double begin_s = together.begin();
  EXPECT_GE(begin_s, before_s);
  EXPECT_LE(begin_s, sim::now_s());
  for (std::uint64_t step = 0; step < 100000; ++step) {
    const Standing is = together.look(0, step, {})[1];
    ASSERT_TRUE(!is.is_there || is.x_m == begin_s + is.y_m);
  }
  EXPECT_EQ(other.wait(), 0);
  EXPECT_TRUE(together.look(0, 100000, {})[1].is_there);
  together.leave(1);
  EXPECT_FALSE(together.look(0, 100001, {})[1].is_there);
}

}  // namespace together_test
