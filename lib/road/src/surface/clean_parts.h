// Which connected piece of a cleaned surface is the road. Private to cleaning.
#pragma once

#include <optional>
#include <vector>

#include "base/answer.h"
#include "clean_gaps.h"
#include "clean_soup.h"

namespace road {

/// Keeps every piece of the surface that has road in it.
void keep_what_touches_road(Soup& soup, CleanReport& facts);

/// Keeps the connected surface that carries the most road; a refusal where it would have to choose
/// between circuits.
std::optional<base::Refusal> keep_one_circuit(Soup& soup, const std::vector<Bridge>& bridges,
                                              const Eigen::Vector3d& origin_m,
                                              const CleanOptions& options, CleanReport& facts);

}  // namespace road
