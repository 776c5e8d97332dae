// Sensors that look at the road while a unit is stepped. Private to serve_unit.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <vector>

#include "base/random.h"
#include "crg/surface.h"
#include "nearby_road.h"
#include "sim/sights.h"
#include "vehicle/road_sensors.h"
#include "worker.h"

namespace sim {

/// Of the car on the map: x, y, z in m; roll (left side up positive), pitch (nose down positive),
/// yaw in rad.
using Pose = std::array<double, 6>;

/// All beams at once. Numbers are drawn for every beam, whatever it hits.
Scan scan_road(NearbyRoad& road, const vehicle::ScanSensor& sensor, const Pose& pose,
               base::Random random);

/// The drivable area is what the road has heights for, from the column nearest to the reference
/// line outwards to the first hole. Nothing hides anything.
Edges see_edges(const crg::Surface& road, const vehicle::EdgeSensor& sensor, const Pose& pose,
                base::Random random);

class RoadDevices {
  struct Look {
    std::uint64_t due_step = 0;
    std::shared_future<ToldSight> sight;
  };

 public:
  /// What changes from step to step: looks that are on the way, and how many there were.
  struct Progress {
    std::uint64_t steps = 0;           ///< step() was called so often
    std::vector<std::uint64_t> looks;  ///< of each scan, then of each camera
    std::deque<Look> on_the_way;
  };

  /// `step_s` is the time from one step() to the next. Throws Error for a sensor that looks more
  /// often than that, and where there are sensors and no road.
  /// `waits`: for what a sensor sees, when its time has come; else it comes when it is ready, and
  /// looks are left out while kMostLate are late.
  RoadDevices(std::shared_ptr<const crg::Surface> road, const vehicle::RoadSensorFile& file,
              std::uint64_t seed, double step_s, bool waits);
  static constexpr std::size_t kMostLate = 20;

  bool empty() const { return file_.empty(); }
  void restart();  ///< as before the first step(), with the same noise

  const Progress& progress() const { return is_; }
  void restore(const Progress& progress) { is_ = progress; }

  /// First at time 0. What a sensor sees is worked out beside this thread, by the time at which it
  /// is told if `delay_s` leaves enough; each look has random numbers of its own, by the seed, the
  /// sensor's name and how many looks there were before. The first looks are waited for: they make
  /// the road around the car.
  void step(const Pose& pose);
  /// What is told now.
  std::vector<ToldSight> arrived();
  std::uint64_t late() const { return late_; }          ///< told after their time
  std::uint64_t left_out() const { return left_out_; }  ///< looks

 private:
  bool is_due(const vehicle::SensorClock& clock, std::uint64_t looks) const;
  template <class Sees>
  void look(const vehicle::SensorClock& clock, Sees sees);
  base::Random random_of(const std::string& name, std::uint64_t look) const;

  std::shared_ptr<const crg::Surface> road_;
  vehicle::RoadSensorFile file_;
  std::uint64_t seed_;
  double step_s_;
  bool waits_;
  std::uint64_t late_ = 0, left_out_ = 0;
  Progress is_;
  std::unique_ptr<NearbyRoad> triangles_;
  std::unique_ptr<Worker> worker_;  ///< last: it uses the others
};

}  // namespace sim
