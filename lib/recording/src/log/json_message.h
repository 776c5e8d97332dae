// Numbers out of messages in JSON.
#pragma once

#include <string_view>

#include "topics.h"

namespace recording {

/// Puts every number of a JSON text into the topic's newest row, truth values as 0 and 1, named by
/// the way to it: {"wheel": {"fl": [1, 2]}} gives wheel.fl.0 and wheel.fl.1. Words and null say
/// nothing; of arrays, kMostElements + 1 elements are taken (one more than stays). False when the
/// text is no JSON (what came before stays).
bool read_json(std::string_view text, Topic& topic);

}  // namespace recording
