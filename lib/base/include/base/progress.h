#pragma once

#include <functional>
#include <string>

namespace base {

/// How far long work has come: called at the start of each stage and from time to time inside long
/// ones, possibly from several threads; share in [0, 1] of the whole. An empty one is not called.
using Progress = std::function<void(const std::string& stage, double share)>;

}  // namespace base
