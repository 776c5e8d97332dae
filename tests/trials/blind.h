// The blind trials: what is wrong, how large, and what the log shows of it, all from one seed.
#pragma once

#include <filesystem>

namespace trials {

/// Writes trial `id` of a seed: recording, road and stated car to folder/NNNN, the truth and the
/// same drive without the effect to folder/sealed.
void draw_blind(int id, unsigned long long seed, const std::filesystem::path& folder);

}  // namespace trials
