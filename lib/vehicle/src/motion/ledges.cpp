#include "vehicle/ledges.h"

#include <fmt/format.h>

namespace vehicle {

std::string ledge_warning(const laws::LedgeTotal& total) {
  constexpr double kWorthSaying_j = 100.0;  // about what the springs of four standing wheels hold
  if (!(total.most_j > kWorthSaying_j)) return {};
  return fmt::format(
      "ledges: planes under the wheels that turn at once would have done {:.2f} kJ of work, most "
      "({:.2f} kJ) at u = {:.2f} m, v = {:.2f} m; it was taken from the motion or left out. Loads "
      "there are those of a plane: contact strip follows the ledge's shape",
      total.work_j / 1e3, total.most_j / 1e3, total.u_m, total.v_m);
}

}  // namespace vehicle
