// One run of the mesh fuzz target: read a file of the given kind, clean it. Used by libFuzzer and
// by the replay under ctest.
#pragma once

#include <string>
#include <string_view>

namespace road::fuzz {

/// The kinds of file that run() takes, by their endings.
inline constexpr std::string_view kKinds[] = {"stl", "ply", "obj", "acc", "glb"};

/// Aborts when a file is neither read nor refused with an Error that names it, or when what is read
/// or cleaned contradicts itself (indices out of range, coordinates not finite, faces down).
void run(std::string_view kind, std::string_view bytes);

}  // namespace road::fuzz
