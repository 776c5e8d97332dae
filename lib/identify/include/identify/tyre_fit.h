// The Magic Formula that fits measured forces, near a reference tyre where the data say nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "identify/tyre_samples.h"
#include "identify/tyre_unknowns.h"
#include "vehicle/magic_formula.h"

namespace identify {

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

}  // namespace identify
