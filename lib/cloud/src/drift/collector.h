// Points of a reading fall on the cells of their sections, whose means are made when others have
// taken their place.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "lane_scatter.h"
#include "overhang.h"
#include "sections.h"
#include "visits.h"

namespace cloud {

/// Where a point falls.
struct Fall {
  enum : std::uint8_t { no_pose, off_road, too_low, beside, on_cell, above_cell } how = no_pose;
  std::uint8_t visit = 0;  ///< where that is known
  std::uint32_t section = 0, cell = 0;
  Eigen::Vector3d place_m;      ///< from the section's sensor position
  double on_m = 0.0;            ///< from the section's middle to where it was seen from
  double height_m = 0.0;        ///< over the base
  double a_m = 0.0, b_m = 0.0;  ///< from the cell's middle along and across the road
  double sine2 = 0.0;           ///< of the angle between ray and road, squared; 0: no sensor
};

/// The base's slope over its cells, in map axes; zero where it has none.
class CellSlopes {
 public:
  CellSlopes(const RoadFrame& frame, unsigned threads);
  Eigen::Vector2d at(const GridPlace& place) const;

 private:
  double cell_rows_ = 1.0, v_begin_m_ = 0.0;
  std::size_t along_ = 0, across_ = 0;
  std::vector<Eigen::Vector2f> slopes_;
};

/// From a cell's middle along and across the road: where points lie that stand on the road.
struct StandingBox {
  float low_a_m = std::numeric_limits<float>::infinity(), low_b_m = low_a_m, high_a_m = -low_a_m,
        high_b_m = -low_a_m;
  void add(float a_m, float b_m);
  bool is_near(float a_m, float b_m) const;
};

/// Points farther than this from what their cell showed before are kept apart.
inline constexpr double kStray_m = 0.03;

class Collector {
 public:
  Collector(const RoadFrame& frame, const RoadTrajectory* trajectory, const MapOptions& options,
            bool visits_known, Look& look);

  /// Where a point falls, wherever others do: for many threads.
  Fall fall_of(Placer& placer, const Cloud& chunk, std::size_t i) const;
  /// Points in the order in which they were measured.
  void add(const Fall& fall);
  void close_all();

 private:
  /// Sums of one cell while its section is open.
  struct Sum {
    double x = 0.0, y = 0.0, z = 0.0, driven = 0.0, driven2 = 0.0, height = 0.0, height2 = 0.0;
    double a = 0.0, b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0, ah = 0.0,
           bh = 0.0;  ///< about the middle
    double sine2 = 0.0;
    std::uint32_t points = 0, kept = 0;  ///< `kept` of them have a shape together
    std::int32_t last = -1;              ///< of these, in OpenSection::points
    std::int32_t last_stray = -1;        ///< there, too
    std::int32_t tall = -1;              ///< in OpenSection::tall
    float cut_above_m = 0.0f, cut_points = 0.0f;
    Sheet sheet = {};
    bool obstacle = false, doubtful = false;
    bool beside = false;  ///< an obstacle: its own ground
    void take_away(const Sum& other);
  };
  /// A point of a cell, and the kept one and the stray before it in the same cell; -1: none.
  struct KeptPoint {
    Fall fall;
    std::int32_t before = -1, stray_before = -1;
  };
  /// The points of a cell over the gate.
  struct Tall {
    std::uint32_t cell = 0, points = 0;
    StandingBox box;
    double b = 0.0, bb = 0.0;  ///< sums across the road
  };
  struct OpenSection {
    std::vector<Sum> sums;
    std::vector<KeptPoint> points;
    std::vector<Tall> tall;
    std::uint8_t visit = 0;
  };
  static double about_plane(const Sum& sum);
  static double freedom_of(const Sum& sum);
  static double square_of(const Sum& sum);
  void add(const Fall& fall, const Section& section, Sum& sum) const;
  double v_of(std::size_t column) const;  ///< of its middle
  bool in_lane(std::size_t column, const Section& section) const;
  /// The kept points of a cell, and after them those of `reach` cells before and behind.
  std::vector<EdgePoint> points_in(const OpenSection& open, std::size_t cell,
                                   std::size_t reach) const;
  /// What the road under the wheels scatters as this section sees it.
  LaneScatter lane_of(const Section& section, const OpenSection& open) const;
  /// What a cell of asphalt or kerb may scatter.
  double noise_m(const Section& section, const LaneScatter& lane, const OpenSection& open,
                 std::size_t cell) const;
  enum class Scatter : std::uint8_t { unknown, calm, some, as_grass };
  std::vector<Scatter> scatter_of(const Section& section, const LaneScatter& lane,
                                  const OpenSection& open) const;
  /// A cell, or one near beyond it as seen from the sensor, scatters as grass.
  bool before_grass(const std::vector<Scatter>& scatter, std::size_t cell, bool to_left) const;
  /// A cell without the points that hang over its ground; as it is, and doubtful, without one.
  Sum ground_of(const Section& section, const OpenSection& open, std::size_t cell, double noise_m,
                Scatter scatter) const;
  /// Blades that hang over kerb and asphalt go.
  void leave_out_overhang(const Section& section, OpenSection& open) const;
  /// A point of a section came, whether it falls on a cell or not.
  void come(const Fall& fall);
  OpenSection& open_section(std::size_t index);
  void close_one(std::size_t index);
  /// Cells above which something stands: not single drops.
  void find_obstacles(OpenSection& open) const;
  /// Where it rains, points that lie apart from all others of their cell.
  void leave_out_drops(const Section& section, OpenSection& open) const;
  void leave_out_drops(const Section& section, const OpenSection& open, Sum& sum) const;
  bool near_obstacle(const OpenSection& open, std::size_t i, std::size_t j) const;
  /// The cell's points that lie on a ground of their own, and not where something stands.
  Sum ground_beside_obstacle(const Section& section, const OpenSection& open, std::size_t cell,
                             double noise_m) const;
  /// Cells within 1 m of obstacles keep their ground; those without one are obstacles, too.
  void leave_out_obstacles(const Section& section, OpenSection& open) const;
  void close(std::size_t index, OpenSection& open);

  const RoadFrame& frame_;
  const RoadTrajectory* trajectory_;
  double gate_m_, edge_m_;
  bool visits_known_;
  Sections& sections_;
  Standing& standing_;
  CellSlopes slopes_;
  std::size_t across_ = 0, along_ = 0;
  Visits visits_;
  std::uint8_t visit_ = 0;  ///< of the point that came last, as its section
  std::optional<std::uint32_t> came_;
  OpenSection* open_here_ = nullptr;  ///< that of came_, once something fell on it
  std::map<std::size_t, OpenSection> open_;
  std::vector<OpenSection> spare_;  ///< closed, for their memory
};

}  // namespace cloud
