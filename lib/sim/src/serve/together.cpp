#include "together.h"

#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <climits>
#include <new>

#include "base/error.h"
#include "real_time.h"

namespace sim {
namespace {

/// Lockstep needs two: nobody is more than a step ahead. In real time a reader that was held up
/// sees by the count that its place was written over.
constexpr std::uint64_t kKeptPlaces = 4;

}  // namespace

struct Together::Shared {
  struct Place {
    std::atomic<bool> is_there, is_driven;
    std::atomic<double> x_m, y_m;
  };
  struct Unit {
    std::atomic<std::uint64_t> steps_told;
    std::atomic<bool> has_left;
    std::array<Place, kKeptPlaces> places;
  };
  std::atomic<std::uint32_t> rung, waiting, ready;
  std::atomic<double> begin_s;
  std::atomic<bool> is_paused;
  std::array<Unit, kMost> units;
};

Together::Together(std::size_t units) : standings_(units) {
  static_assert(std::atomic<double>::is_always_lock_free &&
                std::atomic<std::uint64_t>::is_always_lock_free);
  void* const memory =
      ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (units > kMost || memory == MAP_FAILED)
    throw base::Error("no memory that the units of a run share");
  shared_ = new (memory) Shared{};
}

Together::~Together() { ::munmap(shared_, sizeof(Shared)); }

void Together::ring() {
  ++shared_->rung;
  if (shared_->waiting > 0)
    ::syscall(SYS_futex, &shared_->rung, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

template <class IsSo>
void Together::wait_until(const IsSo& is_so) {
  if (is_so()) return;
  ++shared_->waiting;
  while (true) {
    const std::uint32_t rung = shared_->rung;
    if (is_so()) break;
    ::syscall(SYS_futex, &shared_->rung, FUTEX_WAIT, rung, nullptr, nullptr, 0);
  }
  --shared_->waiting;
}

double Together::begin() {
  ++shared_->ready;
  ring();
  wait_until([this] { return shared_->ready >= size(); });
  double not_yet = 0.0;
  shared_->begin_s.compare_exchange_strong(not_yet, now_s());
  return shared_->begin_s;
}

void Together::tell(std::size_t unit, std::uint64_t step, const Standing& own) {
  Shared::Unit& is = shared_->units[unit];
  Shared::Place& place = is.places[step % kKeptPlaces];
  place.is_there = own.is_there;
  place.is_driven = own.is_driven;
  place.x_m = own.x_m;
  place.y_m = own.y_m;
  is.steps_told = step + 1;
}

Standing Together::told(std::size_t unit, std::uint64_t step) const {
  const Shared::Place& place = shared_->units[unit].places[step % kKeptPlaces];
  return {place.is_there, place.x_m, place.y_m, place.is_driven};
}

std::span<const Standing> Together::meet(std::size_t unit, std::uint64_t step,
                                         const Standing& own) {
  tell(unit, step, own);
  if (size() > 1) ring();
  for (std::size_t k = 0; k < size(); ++k) {
    const Shared::Unit& other = shared_->units[k];
    wait_until([&] { return other.steps_told > step || other.has_left; });
    // Who left tells nothing after that.
    standings_[k] = other.steps_told > step ? told(k, step) : Standing{};
  }
  return standings_;
}

std::span<const Standing> Together::look(std::size_t unit, std::uint64_t step,
                                         const Standing& own) {
  tell(unit, step, own);
  for (std::size_t k = 0; k < size(); ++k) {
    const Shared::Unit& other = shared_->units[k];
    standings_[k] = {};
    for (std::uint64_t steps = other.steps_told; steps > 0 && !other.has_left;
         steps = other.steps_told) {
      standings_[k] = told(k, steps - 1);
      if (other.steps_told < steps + kKeptPlaces - 1) break;
    }
  }
  return standings_;
}

void Together::leave(std::size_t unit) {
  shared_->units[unit].has_left = true;
  ring();
}

void Together::pause(bool is_paused) { shared_->is_paused = is_paused; }

bool Together::is_paused() const { return shared_->is_paused; }

}  // namespace sim
