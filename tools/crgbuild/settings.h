// --set KEY=VALUE: options and modifiers from the command line.
#pragma once

#include <string>
#include <vector>

#include "crg/surface.h"

namespace crgbuild {

/// The file with its modifiers chosen by `use` and the settings on top; evaluate it as in the file.
/// Throws UsageError for a setting that is no KEY=VALUE with a key of the standard and a number.
crg::Crg with_settings(crg::Crg crg, crg::ModifierUse use,
                       const std::vector<std::string>& settings);

}  // namespace crgbuild
