// The rows of values behind the header of a file.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "header.h"
#include "input.h"

namespace crg {

/// Puts the values of the payload into header.crg. `begun`: what of it has been read already with
/// the header; the rest comes from `input`. Throws Error naming byte or line where the payload ends
/// too early, a value is no number or none of a road, or a row has none where it needs one.
void read_payload(Header& header, Input& input, std::string begun);

}  // namespace crg
