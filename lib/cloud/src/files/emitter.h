// From raw values of a file to chunks of a cloud.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cloud/read_cloud.h"

namespace cloud {

constexpr std::size_t kRoles = 13;

/// Raw values of a chunk, one array per role; empty where the file has no such field.
struct Raw {
  std::array<std::vector<double>, kRoles> of;
  std::size_t size = 0;
};

/// Units, origin, points that are not numbers; then the sink.
class Emitter {
 public:
  Emitter(const std::string& name, const CloudReadOptions& options, CloudReadReport& report,
          const ChunkSink& sink);
  /// `share`: how much of the file these and those before are.
  void operator()(const Raw& raw, double share);
  /// Throws Error where no point was handed out.
  void finish() const;
  /// The farthest from 0 of an axis among those handed out, as the file has it.
  double largest(Eigen::Index axis) const { return largest_[axis]; }

 private:
  void look_for_degrees(const Raw& raw);
  /// Counts the point; whether it is to be left out.
  bool left_out_by_marks(const Raw& raw, std::size_t i);
  void hand_out(const Raw& raw);

  const std::string& name_;
  const CloudReadOptions& options_;
  CloudReadReport& report_;
  const ChunkSink& sink_;
  std::optional<Eigen::Vector3d> origin_;
  bool looked_ = false;
  Eigen::Array3d largest_ = Eigen::Array3d::Zero();
};

}  // namespace cloud
