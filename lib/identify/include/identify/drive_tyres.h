// Rows of a tyre bench out of the forces of a drive.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "identify/tyre_fit.h"
#include "recording/table.h"

namespace identify {

/// The samples of one axle's tyres: to fit, and the last quarter of every drive to judge by.
struct DriveTyres {
  TyreSamples fit, held_out;
  std::vector<bool> fit_right, held_right;  ///< whether a row of these is of the right wheel
  std::vector<double> tyre_k;               ///< temperatures of all rows
};

/// Appends both wheels of an axle (0 front, 1 rear) of a table that forces_table made, `name`
/// standing for it. Forces of the wheel on the other side than the file's are mirrored. Rows count
/// less, the larger the standard deviations of their forces are beside the median one. By as much
/// as the axle's largest forces are uncertain, all of them may be off together. Rows with
/// less than `least_load_n`, without forces, or at the outer hundredths of camber and load (kerbs,
/// which would stretch what counts as measured) are counted and left out. Throws base::Error where
/// columns are missing.
void add_drive_tyres(DriveTyres& out, const recording::Table& forces, std::size_t axle,
                     bool left_side, const std::string& name, double least_load_n = 200.0);

/// Forces of a tyre against samples: root mean square of what is left, and of the forces.
struct HeldOut {
  std::size_t rows = 0;
  double fx_left_n = 0.0, fy_left_n = 0.0, fx_n = 0.0, fy_n = 0.0;
};
HeldOut held_out(const vehicle::TyreCoefficients& tyre, const TyreSamples& samples,
                 vehicle::AlphaConvention alpha, const vehicle::TyreFactors<double>& factors = {});

/// The tyre that fits drives, and no worse than the reference what was kept back of them.
struct DriveTyreFit {
  TyreFit fit;
  HeldOut fitted, reference;      ///< on what was kept back
  std::vector<std::string> kept;  ///< what stays the reference's and why, in sentences
};

/// fit_tyre() of `drives.fit`, where shape and peak stay the reference's as far as slips do not
/// come near its peak (three quarters of that slip) or a coefficient of them ran into its bound,
/// and a direction stays whole where what was kept back is fitted worse than by the reference.
/// Nothing where that is so of both directions, or of the only one that could be fitted. Throws
/// base::Error as fit_tyre().
std::optional<DriveTyreFit> fit_drive_tyres(const DriveTyres& drives,
                                            const vehicle::TyreCoefficients& reference,
                                            TyreFitOptions options = {});

}  // namespace identify
