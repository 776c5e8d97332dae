// The aligning moment's part of a fit of a tyre.
#pragma once

#include "identify/tyre_fit.h"

namespace identify {

/// Fits what turns the fitted forces into the measured aligning moments, and appends stage,
/// coefficients and residuals to the fit. The forces stay: what they are off by is not in the
/// intervals of these coefficients.
void fit_aligning(const TyreSamples& rows, const vehicle::TyreCoefficients& reference,
                  const TyreFitOptions& options, TyreFit& fit);

}  // namespace identify
