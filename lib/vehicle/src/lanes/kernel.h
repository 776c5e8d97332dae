// What steps a pack of cars: one class for each instruction set, behind an interface of plain
// numbers, so that no code of packs exists outside the source that is compiled for them.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "vehicle/step.h"

namespace vehicle::many {

/// One car of a pack during a step.
struct Lane {
  const Car<double>* car = nullptr;
  Simulation<double>* sim = nullptr;
  const Inputs<double>* in = nullptr;  ///< of this step
  Detail<double>* detail = nullptr;    ///< null: not wanted
  StepResult result;                   ///< kNoRoad is set
  bool moved = false;                  ///< its state went on
  bool suspect = false;                ///< and should be judged
};

/// Where one wheel of each of four cars asks for the ground.
struct FourAsk {
  std::array<double, 4> x_m, y_m, z_near_m, heading_x, heading_y;
};

/// The ground under a wheel of four cars: ground_under() of the single step. Cars without a `sim`
/// have none.
void ground_of(std::span<Lane, 4> lanes, const Road& road, std::size_t wheel, const FourAsk& ask,
               std::span<RoadPoint, 4> points);

/// settle_ledges() of the single step, for one car that met one.
void settle_ledges_of(Lane& lane, double step_s, const State<double>& s, State<double>& rate,
                      Detail<double>& detail);

inline constexpr std::size_t kMostLanes = 8;

/// Steps up to as many cars as it has lanes; the cars' parameters are inside.
class Kernel {
 public:
  virtual ~Kernel();  // not here: others would share its code
  /// Lanes in the order of the cars; one without anything to step has no `sim`, but not all.
  virtual void step(std::span<Lane, kMostLanes> lanes, const Road& road,
                    const StepOptions& options) = 0;
  /// These parameters of its cars, in their order, as they are now.
  virtual void take(std::span<const Car<double>* const> cars, std::span<const Parameter> which) = 0;
};

/// For at most four and eight cars.
std::unique_ptr<Kernel> make_avx2_kernel(std::span<const Car<double>* const> cars);
std::unique_ptr<Kernel> make_avx512_kernel(std::span<const Car<double>* const> cars);

}  // namespace vehicle::many
