// The blind trials: what is wrong, how large, and what the log shows of it, all from one seed.
#pragma once

#include <filesystem>

namespace trials {

/// Writes trial `id` of a seed: recording, road and stated car to folder/NNNN, the truth and the
/// same drive without the effect to folder/sealed. `third_share` of the trials are driven by the
/// third car, the others by the second, whose drives do not depend on it.
void draw_blind(int id, unsigned long long seed, double third_share,
                const std::filesystem::path& folder);

}  // namespace trials
