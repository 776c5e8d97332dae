// The pieces of a log that are smoothed, one by one, and the noises that they are smoothed with.
// Private to forces.cpp.
#pragma once

#include <utility>
#include <vector>

#include "force_channels.h"
#include "identify/forces.h"

namespace identify {

/// Rows [from, to) are smoothed, [begin, end) of them are kept.
struct Piece {
  std::size_t from = 0, begin = 0, end = 0, to = 0;
};

/// Everything that a piece is smoothed with.
struct Work {
  const CarMotion& motion;
  const recording::Recording& recording;
  const ForcesOptions& options;
  ForceChannels channels;
  PlaceVector stated_sd;  ///< before anything is known of the log
  PlaceVector begin_sd;
  PlaceVector mean;  ///< of what stays as it is, from kPlaceSteerOffset on
  bool steer_offset_known = false;
  std::vector<double> x_m, y_m, yaw_rad, vx_mps, vy_mps, yaw_rate_radps;  ///< without empty cells
  /// Temperatures, fuel and boost that a simulation without smoothing goes through, by state.
  std::vector<std::pair<std::size_t, std::vector<double>>> kept;
};

/// The channels and what the car goes through where no sensor looks. Throws base::Error where a
/// channel is missing.
Work make_work(const CarMotion& motion, const vehicle::Car<double>& car, const vehicle::Road& road,
               const recording::Recording& recording, const ForcesOptions& options);

/// Pieces of a few seconds in which the car drives; counts the rows left out in `out`.
std::vector<Piece> pieces_of(const Work& work, Forces& out);

/// `most_wild`: as SmootherBegin has it.
Smoothed smooth_piece(const Work& work, const Piece& piece, double most_wild);

/// Noises by expectation maximisation, and what the car's parts are off on the whole, from a part
/// of the pieces.
void learn_noises(Work& work, const std::vector<Piece>& pieces);

}  // namespace identify
