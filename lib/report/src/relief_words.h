// Lines, marks and words on the picture of a relief. Private to relief_png.
#pragma once

#include "relief_frame.h"

typedef struct _cairo cairo_t;

namespace report {

/// Borders, start, distances, title and legends on top of the painted surface.
void draw_words(const ReliefInput& road, const Bounds& bounds, const Frame& frame, cairo_t* pen);

}  // namespace report
