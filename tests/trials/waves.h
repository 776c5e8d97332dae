// Blind trials of what needs a log with suspension and brake discs in it.
#pragma once

#include <filesystem>

namespace trials {

/// Writes trial `id` of a seed: half of them nothing missing, an eighth each short waves, a kerb
/// that the file has too low, tyres that envelop a kerb, discs that conduct better when hot. Every
/// log has the channels of all of them.
void draw_waves(int id, unsigned long long seed, const std::filesystem::path& folder);

}  // namespace trials
