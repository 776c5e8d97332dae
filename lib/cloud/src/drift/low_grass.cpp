#include <algorithm>
#include <cmath>
#include <utility>

#include "verge_columns.h"

namespace cloud {
namespace {

constexpr double kTimesLow = 1.1;  // low grass as a whole; the lane's measure is good to that
constexpr double kSure = 3.0;      // deviations of what chance makes

/// Columns that may be low grass, with those of 20 m before and behind.
std::vector<VergeColumn> pooled(const std::vector<VergeColumn>& columns, std::size_t along,
                                std::size_t across, bool closed) {
  constexpr std::size_t kReach = 2;
  std::vector<VergeColumn> out(columns);
  for (std::size_t i = 0; i < along; ++i)
    for (std::size_t j = 0; j < across; ++j) {
      VergeColumn& sum = out[i * across + j];
      if (!sum.is_low()) {
        sum.freedom = 0.0;
        continue;
      }
      const auto add = [&](const VergeColumn& other) {
        if (!other.is_low()) return;
        sum.freedom += other.freedom, sum.square_m2 += other.square_m2;
        sum.expected_m2 += other.expected_m2;
      };
      for (std::size_t away = 1; away <= kReach && 2 * away < along; ++away) {
        if (closed || i >= away) add(columns[(i + along - away) % along * across + j]);
        if (closed || i + away < along) add(columns[(i + away) % along * across + j]);
      }
    }
  return out;
}

/// Grass as low as the noise of single columns: from the outside inwards, as long as what has been
/// passed scatters more than the lane by more than chance makes. `of`: the column of that number,
/// counted from the outside. Returns how many are grass, and how much more each scatters.
template <typename Of>
std::pair<std::size_t, double> low_grass(const Of& of, std::size_t count) {
  double sum = 0.0, chance2 = 0.0, most = 0.0, square = 0.0, expected = 0.0, freedom = 0.0;
  double largest = 0.0;  // of a kerb, perhaps
  std::pair<std::size_t, double> out{0, 0.0};
  for (std::size_t k = 0; k < count && of(k).lane == 0.0; ++k) {
    const VergeColumn& column = of(k);
    if (!column.is_low()) continue;
    const double more = column.square_m2 - kTimesLow * column.expected_m2;
    sum += more, chance2 += 2.0 * column.expected_m2 * column.expected_m2 / column.freedom;
    square += column.square_m2, expected += column.expected_m2, freedom += column.freedom;
    largest = std::max(largest, more);
    if (sum > most && sum - largest > kSure * std::sqrt(chance2))
      most = sum, out = {k + 1, std::max(0.0, square - expected) / freedom};
  }
  return out;
}

}  // namespace

std::size_t lane_of(const VergeColumn* row, std::size_t across) {
  std::size_t lane = across;
  double most = 0.0;
  for (std::size_t j = 0; j < across; ++j)
    if (row[j].lane > most && !row[j].grass) most = row[j].lane, lane = j;
  return lane;
}

void look_for_low_grass(std::vector<VergeColumn>& columns, std::size_t along, std::size_t across,
                        bool closed) {
  const std::vector<VergeColumn> seen = pooled(columns, along, across, closed);
  for (std::size_t i = 0; i < along; ++i) {
    VergeColumn* const row = columns.data() + i * across;
    const std::size_t lane = lane_of(row, across);
    if (lane == across) continue;
    const auto mark = [&](const auto& place, std::size_t count) {
      const auto [run, excess_m2] = low_grass(
          [&](std::size_t k) -> const VergeColumn& { return seen[i * across + place(k)]; }, count);
      for (std::size_t k = 0; k < run; ++k)
        if (VergeColumn& column = row[place(k)]; !column.grass) {
          column.beyond = true;
          if (column.square_m2 <= kMostLow * column.expected_m2) column.excess_m2 = excess_m2;
        }
    };
    mark([](std::size_t k) { return k; }, lane);
    mark([across](std::size_t k) { return across - 1 - k; }, across - 1 - lane);
  }
}

}  // namespace cloud
