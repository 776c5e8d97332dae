#pragma once

#include <array>
#include <string_view>

namespace cloud::fuzz {

/// Endings of file names that choose a reader.
inline constexpr std::array<std::string_view, 6> kKinds = {"las", "ply", "pcd",
                                                           "bin", "xyz", "csv"};

/// Reads the bytes as a cloud; aborts when a refusal does not name the file, an answer is not
/// finite, or the arrays do not fit each other.
void run(std::string_view kind, std::string_view bytes);

}  // namespace cloud::fuzz
