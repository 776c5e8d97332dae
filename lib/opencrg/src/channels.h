// A data set as arrays that programs may look into.
#pragma once

#include <vector>

#include "crg/surface.h"
#include "crgBaseLibPrivate.h"

namespace opencrg {

/// The arrays, and the structure of the interface that points to them.
class Channels {
 public:
  /// Takes the data as they are now; pointers to seen() stay what they were.
  void take(const crg::Surface& surface);
  CrgDataStruct* seen() { return &seen_; }

 private:
  std::vector<double> u_m_, v_m_, x_m_, y_m_, line_z_m_;
  std::vector<std::vector<float>> z_m_;
  std::vector<CrgChannelFStruct> z_;
  CrgDataStruct seen_ = {};
};

}  // namespace opencrg
