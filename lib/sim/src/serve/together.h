// What the units of one run tell each other, each from a process of its own: where they are at each
// step, and whether somebody drives them. Private to serve_unit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sim {

/// Of a unit at the begin of a step.
struct Standing {
  bool is_there = false;  ///< on the road, at this place
  double x_m = 0.0, y_m = 0.0;
  bool is_driven = false;
};

/// Memory that the processes of a run share. Nobody holds a lock in it, so that a process which
/// crashes leaves it sound. A unit calls leave() when it ends; for one that crashed somebody else
/// does.
class Together {
 public:
  static constexpr std::size_t kMost = 16;

  /// Before the processes are made. At most kMost units.
  explicit Together(std::size_t units);
  Together(const Together&) = delete;
  Together& operator=(const Together&) = delete;
  ~Together();

  std::size_t size() const { return standings_.size(); }

  /// Waits until every unit called this. Gives when the clock begins (now_s()): one time for all.
  double begin();

  /// Of all units at the begin of step `step`, counted from 0: waits for those that have not come
  /// there. Who left before is not there. Kept until the next call.
  std::span<const Standing> meet(std::size_t unit, std::uint64_t step, const Standing& own);
  /// The same without waiting: where they are now.
  std::span<const Standing> look(std::size_t unit, std::uint64_t step, const Standing& own);
  void leave(std::size_t unit);

  void pause(bool is_paused);  ///< the clock, for all
  bool is_paused() const;

 private:
  struct Shared;

  void tell(std::size_t unit, std::uint64_t step, const Standing& own);
  void ring();
  template <class IsSo>
  void wait_until(const IsSo& is_so);
  Standing told(std::size_t unit, std::uint64_t step) const;

  Shared* shared_;
  std::vector<Standing> standings_;
};

}  // namespace sim
