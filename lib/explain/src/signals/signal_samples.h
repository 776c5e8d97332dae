// One channel's measurements, and the smooth signal that they are a sample of.
#pragma once

#include <string>
#include <vector>

#include "explain/mapping.h"
#include "recording/table.h"

namespace explain {

/// Measurements of one channel, each with its own time.
struct Samples {
  std::vector<double> t, x;
  std::string column;
};

/// Mapped values with their own clock; repeats and empty cells left out. `time_s` is the log's
/// clock, row by row.
Samples samples_of(const recording::Table& table, const Mapping& mapping,
                   const std::string& channel, const std::vector<double>& time_s);

/// Single samples and pairs that leap from their neighbours by 20 times what samples usually differ
/// from them by, and by what no car can do within a sample, `impossible`: taken out. Returns their
/// times. Where nothing is `impossible` (infinite), by over half of the channel's range, and only
/// from 45 samples a second on: below it a sample lasts as long as what a car does.
std::vector<double> take_out_spikes(Samples& samples, double impossible);

/// Its rate of change at step i, from two steps to both sides; NaN without them.
double rate_at(const std::vector<double>& x, std::size_t i);

/// Value of a local quadratic with triangular weights at `n` steps of Signals::kStep_s from `t0`,
/// and its derivative. NaN where samples are few or lie on one side.
void smooth(const Samples& samples, double t0, std::size_t n, double half_s, std::vector<double>& x,
            std::vector<double>& dx);

/// A draw of noise at the times of the samples, as large as theirs against what smooth() made of
/// them, `x`, and smoothed like them from 0. Always the same draw.
std::vector<double> noise_like(const Samples& samples, double half_s, const std::vector<double>& x);

}  // namespace explain
