// Measured tyre forces with the conditions that they were measured in.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "recording/table.h"
#include "vehicle/magic_formula.h"

namespace identify {

/// Rows of a tyre bench in the axes and signs of the tyre's file (vehicle/magic_formula.h).
struct TyreSamples {
  std::vector<vehicle::TyreInput<double>> conditions;
  std::vector<double> fx_n, fy_n;        ///< of each condition; NaN: not measured
  std::vector<double> mz_nm;             ///< the same; empty: nowhere
  std::vector<double> fx_more, fy_more;  ///< how much noisier than the others; empty: as noisy
  /// By how much all forces may be off together, as shares; standard deviations.
  double fx_share = 0.0, fy_share = 0.0;
  std::size_t left_out = 0;  ///< rows of the tables without a load, a condition or a force

  std::size_t rows() const { return conditions.size(); }
  /// Appends a row of `from` as far as that has it.
  void add_row(const TyreSamples& from, std::size_t row);
};

/// Appends the rows of a table with the columns fz_n, kappa, alpha_rad, gamma_rad, vx_mps, fx_n
/// and/or fy_n, and mz_nm and pressure_pa where they were measured: the columns that `crgdrive
/// tyre` writes. Rows with an empty condition, without any force or with a load at or below zero
/// are counted and left out. Throws base::Error, `name` standing for the table: a column is
/// missing, a slip angle is a right angle or more, a value is none of SI units (forces above 1e6 N,
/// say).
void add_tyre_samples(TyreSamples& samples, const recording::Table& table, const std::string& name);

/// Every n-th row, the first among them, so that at most `most` are left; `most` above 0.
TyreSamples thinned(const TyreSamples& samples, std::size_t most);

}  // namespace identify
