// The road of a relief as shaded cells. Private to relief_png.
#pragma once

#include <cstddef>
#include <cstdint>

#include "relief_frame.h"

namespace report {

/// Paints frame.height rows of frame.width pixels, 0xRRGGBB; a row begins every `pitch` pixels.
void paint_surface(const ReliefInput& road, const ReliefOptions& options, const Bounds& bounds,
                   const Frame& frame, std::uint32_t* pixels, std::size_t pitch);

}  // namespace report
