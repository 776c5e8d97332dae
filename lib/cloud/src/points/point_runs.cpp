#include "point_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <queue>

#include "base/parallel.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr double kPerMetre = 4096.0, kFarthest_m = 1e8;
constexpr std::uint64_t kThird = 0x15555555555;  // of 2^42
constexpr std::size_t kMergeBuffers_bytes = 64u << 20;

struct Placed {
  CurvePlace place;
  std::uint32_t index = 0;
  auto operator<=>(const Placed&) const = default;
};

/// 21 bits, each followed by two zeros.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

/// The same order by any number of threads: no two are equal.
void sort(std::vector<Placed>& values, unsigned threads) {
  constexpr std::size_t kPieces = 4;
  const std::size_t piece = std::max<std::size_t>(1, (values.size() + kPieces - 1) / kPieces);
  const auto at = [&](std::size_t k) {
    return values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size(), k * piece));
  };
  base::parallel_for(kPieces, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) std::sort(at(k), at(k + 1));
  });
  base::parallel_for(2, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      std::inplace_merge(at(2 * k), at(2 * k + 1), at(2 * k + 2));
  });
  std::inplace_merge(at(0), at(2), at(4));
}

/// One run, read piece by piece.
struct RunReader {
  std::uint64_t next = 0, end = 0;  ///< in points of the file
  std::vector<TilePoint> buffer = {};
  std::size_t at = 0;
};

}  // namespace

int levels_in_common(const CurvePlace& a, const CurvePlace& b) {
  if (const std::uint64_t differs = a.high ^ b.high; differs != 0)
    return (std::countl_zero(differs) - 1) / 3;
  if (const std::uint64_t differs = a.low ^ b.low; differs != 0)
    return kCurveLevels / 2 + (std::countl_zero(differs) - 1) / 3;
  return kCurveLevels;
}

PointRuns::PointRuns(const std::string& scratch, std::size_t points_per_run, unsigned threads)
    : points_per_run_(std::clamp<std::size_t>(points_per_run, 1, 1u << 30)),
      threads_(threads),
      file_(scratch) {}

void PointRuns::add(const TilePoint& point) {
  for (const double value : {point.x_m, point.y_m, point.z_m})
    if (!(std::abs(value) < kFarthest_m))
      throw Error(fmt::format(
          "a point at {:g} {:g} {:g} m seen; coordinates below 1e8 m wanted (is the unit right?)",
          point.x_m, point.y_m, point.z_m));
  if (points() == 0) first_ = point;
  waiting_.push_back(point);
  if (waiting_.size() == points_per_run_) sort_and_write();
}

CurvePlace PointRuns::place_of(const TilePoint& point) const {
  const auto cell = [](double value, double first) {
    return kThird + static_cast<std::uint64_t>(
                        static_cast<std::int64_t>(std::floor((value - first) * kPerMetre)));
  };
  const std::uint64_t x = cell(point.x_m, first_.x_m), y = cell(point.y_m, first_.y_m),
                      z = cell(point.z_m, first_.z_m);
  const auto together = [&](int shift) {
    return spread(x >> shift) << 2 | spread(y >> shift) << 1 | spread(z >> shift);
  };
  return {together(kCurveLevels / 2), together(0)};
}

void PointRuns::sort_and_write() {
  if (waiting_.empty()) return;
  std::vector<Placed> order(waiting_.size());
  base::parallel_for(order.size(), 1u << 16, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      order[i] = {place_of(waiting_[i]), static_cast<std::uint32_t>(i)};
  });
  sort(order, threads_);
  std::vector<TilePoint> piece;
  for (std::size_t i = 0; i < order.size(); ++i) {
    piece.push_back(waiting_[order[i].index]);
    if (piece.size() < 16384 && i + 1 < order.size()) continue;
    file_.append({reinterpret_cast<const char*>(piece.data()), piece.size() * sizeof(TilePoint)});
    piece.clear();
  }
  runs_.emplace_back(points_, points_ + waiting_.size());
  points_ += waiting_.size();
  waiting_.clear();
}

void PointRuns::in_order(const std::function<void(const TilePoint&, const CurvePlace&)>& sink) {
  sort_and_write();
  waiting_.shrink_to_fit();
  const std::size_t most = std::clamp<std::size_t>(
      kMergeBuffers_bytes / sizeof(TilePoint) / (runs_.size() + 1), 256, 16384);
  std::vector<RunReader> readers;
  for (const auto& [begin, end] : runs_) readers.push_back({begin, end});
  const auto fill = [&](RunReader& reader) {
    reader.at = 0;
    reader.buffer.resize(std::min<std::uint64_t>(most, reader.end - reader.next));
    file_.read(reader.next * sizeof(TilePoint), reinterpret_cast<char*>(reader.buffer.data()),
               reader.buffer.size() * sizeof(TilePoint));
    reader.next += reader.buffer.size();
    return !reader.buffer.empty();
  };
  std::priority_queue<Placed, std::vector<Placed>, std::greater<>> heads;
  const auto push = [&](std::uint32_t k) {
    RunReader& reader = readers[k];
    if (reader.at == reader.buffer.size() && !fill(reader)) return;
    heads.push({place_of(reader.buffer[reader.at]), k});
  };
  for (std::uint32_t k = 0; k < readers.size(); ++k) push(k);
  while (!heads.empty()) {
    const Placed head = heads.top();
    heads.pop();
    RunReader& reader = readers[head.index];
    sink(reader.buffer[reader.at++], head.place);
    push(head.index);
  }
}

}  // namespace cloud
