#include <cmath>

#include "base/error.h"
#include "circuit/circuit.h"
#include "fuzz/target.h"

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put("circuit.yaml", bytes);
  try {
    const road::Circuit circuit = road::read_circuit(path);
    require(circuit.length_m() > 0.0 && std::isfinite(circuit.length_m()), "a length");
    for (int k = 0; k <= 20; ++k) {
      const double u = circuit.length_m() * k / 20.0;
      require(std::isfinite(road::true_height(circuit, u, 0.0)), "a height on the reference line");
    }
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
}
