#pragma once

#include <string>

#include "explain/findings.h"

namespace explain {

/// The first section of the page: the verdict, what it means, how often it is wrong by noise, and
/// the remarks about the analysis.
std::string verdict_box(const Findings& findings);

}  // namespace explain
