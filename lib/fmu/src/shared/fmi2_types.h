// Types of FMI 2.0 (section 2 of the standard) as this unit needs them.
#pragma once

#include <cstddef>

extern "C" {
using fmi2Component = void*;
using fmi2ComponentEnvironment = void*;
using fmi2FMUstate = void*;
using fmi2ValueReference = unsigned int;
using fmi2Real = double;
using fmi2Integer = int;
using fmi2Boolean = int;
using fmi2Char = char;
using fmi2String = const char*;
using fmi2Byte = char;
using fmi2Status = int;      // fmi2OK 0, Warning 1, Discard 2, Error 3, Fatal 4, Pending 5
using fmi2Type = int;        // model exchange 0, co-simulation 1
using fmi2StatusKind = int;  // DoStepStatus 0, PendingStatus 1, LastSuccessfulTime 2, Terminated 3

struct fmi2CallbackFunctions {  // NOLINT(readability-identifier-naming): of the standard
  void (*logger)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category,
                 fmi2String message, ...);
  void* (*allocateMemory)(std::size_t, std::size_t);
  void (*freeMemory)(void*);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment environment;
};
}
