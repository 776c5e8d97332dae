// Types of FMI 3.0 (section 2 of the standard) as this unit needs them.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {
using fmi3Instance = void*;
using fmi3InstanceEnvironment = void*;
using fmi3FMUState = void*;
using fmi3ValueReference = std::uint32_t;
using fmi3Float32 = float;
using fmi3Float64 = double;
using fmi3Boolean = bool;
using fmi3String = const char*;
using fmi3Byte = std::uint8_t;
using fmi3Binary = const fmi3Byte*;
using fmi3Clock = bool;
using fmi3Status = int;             // fmi3OK 0, Warning 1, Discard 2, Error 3, Fatal 4
using fmi3DependencyKind = int;     // independent 0 ...
using fmi3IntervalQualifier = int;  // not yet known 0 ...

using fmi3LogMessageCallback = void (*)(fmi3InstanceEnvironment, fmi3Status, fmi3String category,
                                        fmi3String message);
using fmi3IntermediateUpdateCallback = void (*)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean,
                                                fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean*,
                                                fmi3Float64*);
using fmi3ClockUpdateCallback = void (*)(fmi3InstanceEnvironment);
using fmi3PreemptionCallback = void (*)();
}
