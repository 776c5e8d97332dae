// The demo circuit as tests take it, who need a circuit and not its every bend.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/places.h"

namespace support {

/// A third of the demo circuit, of the same name: quicker to build, to draw and to drive.
/// KERBSTONE_HEAVY=1: the demo circuit itself.
inline std::string demo_circuit() {
  return places::source() + (std::getenv("KERBSTONE_HEAVY") != nullptr
                                 ? "/tracks/kerbstone-ring/circuit.yaml"
                                 : "/tests/view/oval.yaml");
}

/// That circuit where the commands of a document look for the demo's: in tracks/ of this folder.
inline void put_demo_circuit(const std::string& folder) {
  const std::string track = folder + "/tracks/kerbstone-ring";
  std::filesystem::create_directories(track);
  std::filesystem::copy(demo_circuit(), track + "/circuit.yaml");
}

}  // namespace support
