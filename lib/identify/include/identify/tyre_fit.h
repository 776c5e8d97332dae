// A tyre from measured forces and moments: its rows, what is fitted, where the fit holds.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "recording/table.h"
#include "vehicle/magic_formula.h"
#include "vehicle/tyre_file.h"

namespace identify {

/// Which slips a coefficient belongs to; of the aligning moment: to any, or to the arm of the
/// longitudinal force, which shows in combined slip.
enum class SlipKind { kLateral, kLongitudinal, kCombined, kAligning, kAligningArm };

/// What has to vary in the data, beside the slip, for a coefficient to be found.
enum class Needs { kSlip, kLoad, kCamber, kPressure };

struct TyreUnknown {
  const char* keyword;  ///< in the .tir file
  double vehicle::TyreCoefficients::*member;
  SlipKind kind;
  Needs needs;
  /// Standard deviation of what is believed before the data about the distance to the reference
  /// tyre; that of a coefficient with a large value is half the value.
  double spread;
  double low, high;   ///< bounds; a reference outside moves them
  bool in_52, in_6x;  ///< versions of the formula that have it
};

/// All of them, in the order of their kinds.
std::span<const TyreUnknown> tyre_unknowns();

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

/// What of a kind of slip stays the reference's: nothing, shape and peak of the curves, or all.
enum class TyreHold { kNothing, kPeak, kAll };

struct TyreFitOptions {
  vehicle::AlphaConvention alpha = vehicle::AlphaConvention::kTangent;
  int starts = 8;  ///< of every stage: the reference, and others around it; the best is kept
  std::uint64_t seed = 1;
  std::size_t most_rows = 6000;    ///< rows that the fit looks at; more are thinned evenly
  unsigned threads = 0;            ///< 0: all cores; any number gives the same result
  std::array<TyreHold, 3> hold{};  ///< of kLateral, kLongitudinal, kCombined
};

struct FittedCoefficient {
  std::string keyword;
  SlipKind kind = SlipKind::kLateral;
  double value = 0.0, reference = 0.0;
  double sd = 0.0;  ///< standard deviation; the 90 % interval is value +- 1.645 sd
  /// Share of the prior variance that the data took away: near 0 the value is the reference tyre's
  /// word and not the data's.
  double from_data = 0.0;
  bool at_bound = false;  ///< the interval is not to be trusted
};

struct TyreStage {
  SlipKind kind = SlipKind::kLateral;
  std::size_t rows = 0;
  int starts = 0, agreeing = 0;  ///< starts that came within 1 % of the best one's cost
  std::string why_not;           ///< not empty: nothing of this kind was fitted
};

/// How one force or moment fits, in N or Nm.
struct TyreResiduals {
  std::size_t rows = 0;
  double rms = 0.0;    ///< measured less fitted, all rows
  double size = 0.0;   ///< root mean square of what was measured
  double noise = 0.0;  ///< robust standard deviation of measured less fitted
  double far =
      0.0;  ///< share of rows further than four of these away: outliers, or a formula that cannot
  double repeats =
      1.0;  ///< rows that count as one in the intervals: (1 + r) / (1 - r), r from row to row
};

struct TyreFit {
  vehicle::TyreCoefficients tyre;  ///< the reference with the fitted values
  vehicle::AlphaConvention alpha = vehicle::AlphaConvention::kTangent;
  std::vector<FittedCoefficient> coefficients;
  /// Of coefficients[i] and [j] at i * n + j, with what all forces may be off together.
  std::vector<double> covariance;
  std::vector<TyreStage> stages;
  TyreResiduals fx, fy, mz;
  std::size_t rows = 0;  ///< that the fit looked at
  /// Camber goes with side slip and load in these rows: its coefficients are the reference's, and
  /// half their spread counts in the covariance.
  bool camber_follows = false;
};

/// Fits in stages: pure side slip (|kappa| <= 0.02), pure longitudinal slip (|tan alpha| <= 0.02),
/// combined slip, then everything together. Minimises Cauchy's loss of the forces over their noise,
/// which is estimated on the way, plus the squared distance of every coefficient to the reference
/// over its spread (tyre_unknowns.h), plus a penalty on friction and stiffness that vanish within
/// 0.1 nominal loads and 1.5 times the greatest load of the data. Coefficients of load, camber and
/// pressure take part only where 5 % and 95 % of the rows are 0.2 nominal loads, 1 degree and 5 %
/// of the pressure apart; those of camber only where it is as far from what side slip and load tell
/// of it. Then, where there are 30 rows of it, the aligning moment, with the forces as fitted. The
/// other moments and the rolling radius stay the reference's.
/// Throws base::Error when no stage has what it needs (30 rows that differ in slip) and when forces
/// run against the reference's, which are then of other axes.
TyreFit fit_tyre(const TyreSamples& samples, const vehicle::TyreCoefficients& reference,
                 const TyreFitOptions& options = {});

/// Fitted forces and aligning moment at a condition and their standard deviations from those of the
/// coefficients; that of the moment is 0 where none was fitted.
struct ForceBand {
  double fx_n = 0.0, fy_n = 0.0, mz_nm = 0.0;
  double fx_sd_n = 0.0, fy_sd_n = 0.0, mz_sd_nm = 0.0;
};
ForceBand force_band(const TyreFit& fit, const vehicle::TyreInput<double>& condition);

/// Where a tyre is looked at.
struct TyreRange {
  double fz_low_n = 0.0, fz_high_n = 0.0;
  double gamma_low_rad = 0.0, gamma_high_rad = 0.0;
  double kappa_most = 1.0, tan_alpha_most = 0.6;
};

struct TyreFault {
  std::string what;  ///< in words
  double fz_n = 0.0, gamma_rad = 0.0;
};

/// Pure slip, both directions, at nine loads and three cambers: friction and stiffness are there,
/// the force rises to one peak, falls or stays behind it (a rise of 0.2 % of the peak is let
/// through) and does not turn its sign there. One fault for each load and camber at most, loads
/// ascending; empty: none found. The lower loads are not those below a tenth of the nominal load.
std::vector<TyreFault> scan_tyre(
    const vehicle::TyreCoefficients& tyre, const TyreRange& range,
    vehicle::AlphaConvention alpha = vehicle::AlphaConvention::kTangent);

/// Slip (tangent of the angle, or kappa) of the largest force of the upright tyre, both directions
/// together. kMostSlip: the force still rises there, and no peak is known.
inline constexpr double kMostSlip = 1.0;
double peak_slip(const vehicle::TyreCoefficients& tyre, vehicle::AlphaConvention alpha, double fz_n,
                 bool lateral);

// Edges of the cells; the last of each is open.
inline constexpr std::array<double, 5> kLoadEdges{0.0, 0.5, 0.85, 1.2,
                                                  1.6};  ///< of the nominal load
inline constexpr std::array<double, 5> kCamberEdges_deg{-90.0, -3.0, -1.0, 1.0, 3.0};
/// Slip over that of the fitted peak at that load, upright; combined: root of the sum of squares.
inline constexpr std::array<double, 4> kSlipEdges{0.0, 0.35, 0.75, 1.05};

/// Rows in each cell; slip of kinds kLateral, kLongitudinal and kCombined, a tenth of the other
/// direction's peak being the limit of purity.
struct ConditionCell {
  SlipKind kind = SlipKind::kLateral;
  std::size_t load = 0, camber = 0, slip = 0;  ///< indices of the lower edges
  std::size_t rows = 0;
  double fx_left_n = NAN, fy_left_n = NAN;  ///< root mean square of measured less fitted force
};

/// A peak of a fitted curve of pure slip, and whether the rows went past it.
struct PeakReach {
  SlipKind kind = SlipKind::kLateral;
  std::size_t load = 0;
  double peak_slip =
      0.0;  ///< tan alpha or kappa, of the upright tyre in the middle of the load cell
  double measured_slip = 0.0;  ///< the largest, 99 % of the rows below
  double peak_n = 0.0, sd_n = 0.0;
  /// False: the force is known up to the measured slip, and the fitted peak is no more than a bound
  /// with what the reference tyre says. A peak_slip of kMostSlip: the fitted force only rises.
  bool reached = false;
};

/// The condition at which a row more would tell most, of loads, cambers and slips within the range.
struct NextMeasurement {
  SlipKind kind = SlipKind::kLateral;
  vehicle::TyreInput<double> condition;
  double force_n = 0.0, sd_n = 0.0;  ///< of the fitted force with the larger standard deviation
};

struct TyreConditions {
  TyreRange measured;                ///< loads and cambers of the rows
  std::vector<ConditionCell> cells;  ///< every one, in the order of kind, load, camber, slip
  std::vector<PeakReach> peaks;      ///< load cells with rows of a kind that was fitted
  NextMeasurement next;
};

TyreConditions tyre_conditions(const TyreFit& fit, const TyreSamples& samples);

}  // namespace identify
