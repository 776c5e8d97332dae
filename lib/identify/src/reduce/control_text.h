// The lines of control_*.inc as text; CMake puts them into a source.
#pragma once

namespace identify {

extern const char* const kControlCar;     ///< types, curves, loads, differential
extern const char* const kControlSingle;  ///< control_single_track()
extern const char* const kControlDouble;  ///< control_double_track()

}  // namespace identify
