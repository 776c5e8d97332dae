// A circuit made by rule: a mesh such as a simulator exports, and its exact heights.
#pragma once

#include <string>
#include <vector>

#include "crg/file.h"
#include "road/mesh.h"

namespace road {

struct Circuit;  // circuit.yaml, defined in the source file's own header part (synth owner fills this in)

}  // namespace road
