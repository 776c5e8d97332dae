// Every stage between the sampled heights and the file. A new one is a file of this folder and its
// name here, twice.
#include "grid_stage.h"

namespace road {

GridStage kerb_stage(), smooth_stage(), patch_stage(), roughen(), friction_stage();

const std::vector<GridStage>& grid_stages() {
  static const std::vector<GridStage> all{kerb_stage(), smooth_stage(), patch_stage(), roughen(),
                                          friction_stage()};
  return all;
}

}  // namespace road
