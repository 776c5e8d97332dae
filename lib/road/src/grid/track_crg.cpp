#include "road/track_crg.h"

#include <utility>

namespace road {

crg::Crg track_crg(const crg::ReferenceLine& line, crg::Grid grid) {
  crg::Crg file = crg::make_crg(line, std::move(grid));
  crg::set_value(file.options, "BORDER_MODE_U", 0.0);
  crg::set_value(file.options, "BORDER_MODE_V", 0.0);
  return file;
}

}  // namespace road
