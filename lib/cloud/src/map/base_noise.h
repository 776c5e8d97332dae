// Errors of a base from node to node, which heights over it bring into the road.
#pragma once

#include <functional>

#include "crg/file.h"

namespace cloud {

/// Of a base whose nodes err each by itself: a mean of heights over it holds a half of the error of
/// its node, and not more.
class BaseNoise {
 public:
  /// `closed`: the first row goes on from the last but one. `seen_m`: how much the points lie over
  /// the base at a node, NaN without points: how much of its roughness the road does not have.
  BaseNoise(const crg::Grid& base, bool closed, const std::function<double(std::size_t)>& seen_m);
  /// Of a node, metres; 0 where the base is smooth along the road, or as rough as that.
  double stddev_m() const { return stddev_m_; }
  /// What is too much in the base's height there over its own mean about the node, metres. 0 where
  /// that is more than chance, as at a kerb's edge.
  double over_mean_m(std::size_t row, std::size_t column) const;

 private:
  const crg::Grid& base_;
  std::size_t rows_;
  bool closed_;
  double stddev_m_ = 0.0, share_ = 0.0;  ///< of what the base has, that is error
};

}  // namespace cloud
