// Lines of setup sheets.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "identify/drive_fit.h"

namespace identify {

/// `key = value prior p` with the prior that the found deviation makes (two of them, as a share of
/// the value), or a remark why there is no number. `value`: f.value in the key's own terms.
inline std::string sheet_line(const Found& f, const std::string& key, double value) {
  if (!f.unseen.empty()) return fmt::format("# {} not observable: {}\n", key, f.unseen);
  const double prior = 2.0 * f.sd / std::abs(f.value);
  if (!(prior > 0.0) || !std::isfinite(prior) || value == 0.0)
    return fmt::format("{} = {:.6g}\n", key, value);
  return fmt::format("{} = {:.6g} prior {:.3g}\n", key, value, prior);
}

/// Lines without priors, the names' first _ as the key's point; factors on a map are remarks.
inline std::string plain_sheet(const std::vector<Found>& found) {
  std::string out;
  for (const Found& f : found) {
    std::string key = f.name;
    key[key.find('_')] = '.';
    out += !f.unseen.empty() ? fmt::format("# {} not observable: {}\n", key, f.unseen)
           : f.unit == "1"
               ? fmt::format("# {}: {:.4g} times the vehicle file's map\n", key, f.value)
               : fmt::format("{} = {:.6g}\n", key, f.value);
  }
  return out;
}

}  // namespace identify
