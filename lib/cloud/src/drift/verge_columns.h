// The road and its verge by columns of cells, as verge.cpp and low_grass.cpp judge them.
#pragma once

#include <cstddef>
#include <vector>

namespace cloud {

constexpr double kMostLow = 3.0;  // of what is expected: grass that scatters more is told by itself
constexpr double kRelief_m = 0.004;  // bend of the base over 0.25 m to both sides: a kerb

/// kVergeStretch_m along the road and kSectionCell_m across it.
struct VergeColumn {
  double freedom = 0.0, square_m2 = 0.0, expected_m2 = 0.0, points = 0.0;
  double bent_m2 = 0.0;        ///< of what is expected: where the base bends, it may bend elsewhere
  double lane = 0.0;           ///< points of the lane
  double scattering = 0.0;     ///< freedom of cells that scatter by themselves
  double scattering_m2 = 0.0;  ///< the square of these
  double doubtful_freedom = 0.0, doubtful_m2 = 0.0;  ///< of that: cells that blades hang over
  double overhung = 0.0;                             ///< points that were cut off over ground
  double relief_m = 0.0;
  enum { unknown, calm, scatters } is = unknown;
  bool grass = false, beyond = false;
  bool paved = false;      ///< it is said to be no grass
  double excess_m2 = 0.0;  ///< scatter of low grass, where it is told by the verge as a whole
  /// Neither paved, a kerb nor beside what stands high: it may be low grass.
  bool is_low() const {
    return is == calm && !paved && freedom > 0.0 && relief_m <= kRelief_m &&
           square_m2 <= kMostLow * expected_m2;
  }
};

/// The column of a row with most of the lane's points; `across`: none.
std::size_t lane_of(const VergeColumn* row, std::size_t across);

/// Low grass: no single column scatters enough to be told, the verge as a whole does. Such columns
/// say nothing about the trajectory (`beyond`), and stand as high as they scatter (`excess_m2`).
void look_for_low_grass(std::vector<VergeColumn>& columns, std::size_t along, std::size_t across,
                        bool closed);

}  // namespace cloud
