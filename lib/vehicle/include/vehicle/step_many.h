// Many cars one step on: in packs of as many as the processor computes at once.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "vehicle/step.h"

namespace vehicle {

/// What a pack is computed by. kBest: the widest that this processor has.
enum class Lanes {
  kOne,     ///< vehicle::step, car by car
  kAvx2,    ///< four cars at once
  kAvx512,  ///< eight
  kBest
};

/// Whether this processor has them.
bool has_lanes(Lanes lanes);

namespace many {
class Kernel;
}

/// Cars made ready to be stepped together. Refers to them and their files, which must outlive it;
/// takes their parameters as they are now. Cars share a pack where they have the same files, kind
/// of contact and tyre options, and where the same terms and parameters are off or fully on. Not
/// for two threads at once: each thread has packs of its own.
class CarPacks {
 public:
  /// All steps will have the length `step_s`. Throws Error when `lanes` are none of this processor.
  CarPacks(std::span<const Car<double>* const> cars, double step_s, Lanes lanes = Lanes::kBest);
  ~CarPacks();
  CarPacks(CarPacks&&) noexcept;
  CarPacks& operator=(CarPacks&&) noexcept;

  std::size_t cars() const { return cars_.size(); }
  /// Takes these parameters of all cars as they are now. What make_car() and the actuators made of
  /// them stays as it was; none may go to 0 or come from it.
  void take(std::span<const Parameter> which);
  std::size_t packs() const { return packs_.size(); }

 private:
  struct Pack {
    std::vector<std::size_t> cars;
    std::ptrdiff_t least = 0;              ///< of fewer cars each is stepped by itself
    std::unique_ptr<many::Kernel> kernel;  ///< none: one by one
  };
  friend void step_many(CarPacks&, std::span<Simulation<double>>, std::span<const Controls<double>>,
                        const Road&, const StepOptions&, std::span<StepResult>,
                        std::span<Detail<double>>);

  double step_s_;
  std::vector<const Car<double>*> cars_;
  std::vector<Responses<double>> responses_;
  std::vector<Pack> packs_;
};

/// One step of every car, on one road. `sims`, `controls` and `results` have one entry for each
/// car, in the order of the cars; so has `details`, or none. A car whose result is not ok stays as
/// it is; each of the others goes bit for bit where step() would take it, and its result says how
/// that ended. Throws Error when a size or the length of the step does not fit; allocates nothing.
void step_many(CarPacks& packs, std::span<Simulation<double>> sims,
               std::span<const Controls<double>> controls, const Road& road,
               const StepOptions& options, std::span<StepResult> results,
               std::span<Detail<double>> details = {});

}  // namespace vehicle
