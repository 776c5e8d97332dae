// Is a file consistent with itself and with the standard? The findings as data.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "crg/file.h"

namespace crg {

enum class Severity {
  Note,     ///< worth knowing; every reader gives the same answers
  Warning,  ///< readers may differ, or the data are probably not what was meant
  Error     ///< the file breaks the standard or cannot be evaluated
};

struct Finding {
  Severity severity = Severity::Note;
  std::string rule = {};                ///< short stable name, e.g. "curvature.global"
  std::string message = {};             ///< value seen and value wanted, with units
  std::optional<std::size_t> row = {};  ///< first grid row concerned
  std::size_t count = 1;                ///< how often it occurs
};

struct CheckReport {
  std::vector<Finding> findings;
  std::size_t count(Severity severity) const;
  bool passed() const { return count(Severity::Error) == 0; }
};

/// Checks everything the reference implementations check: increments, ranges, header against data,
/// curvature against the v range globally and where there are heights, closure, NaN rules, options,
/// modifiers, projection and WGS84 values. The tolerances are the file's own CHECK_* options. Never
/// throws for what a file may contain. Values are taken as stored, modifiers not applied.
CheckReport check(const Crg& crg);

const char* name_of(Severity severity);

}  // namespace crg
