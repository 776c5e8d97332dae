// What the process of a unit says to the one that keeps the record. Private to serve_unit.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apart.h"
#include "sim/message.h"
#include "sim/serve_unit.h"
#include "worker.h"

namespace sim {

void count_step(ServeCounts& counts, double took_s);

/// Of the record.
std::vector<double> row_of(const MeasurementMessage& measured, const std::vector<double>& recorded,
                           const std::vector<double>& acts, std::uint64_t resets);

/// In real time beside the loop: its pipe may be full.
class Teller {
 public:
  Teller(const std::function<void(Words)>& say, bool beside) : say_(say) {
    if (beside) worker_.emplace();
  }

  void tell(char kind, std::string_view bytes) {
    if (!worker_) return say_({kind, bytes});
    if (untold_bytes_ > kMostUntold) worker_->finish();
    untold_bytes_ += bytes.size();
    worker_->give([this, kind, kept = std::string(bytes)] {
      say_({kind, kept});
      untold_bytes_ -= kept.size();
    });
  }
  void finish() {
    if (worker_) worker_->finish();
  }

 private:
  static constexpr std::size_t kMostUntold = 1u << 28;
  const std::function<void(Words)>& say_;
  std::atomic<std::size_t> untold_bytes_ = 0;
  std::optional<Worker> worker_;  ///< last: it uses the others
};

}  // namespace sim
