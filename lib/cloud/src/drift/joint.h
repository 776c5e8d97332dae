// The least-squares problem of all corrections and all cells of the road: what each section sees of
// each cell, made linear, and the normal equations with the cells' heights eliminated.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "block_matrix.h"
#include "drift.h"

namespace cloud {

/// Nothing is known of where a pose lies.
inline constexpr double kAnywhere_m = 3.0;

/// One cell seen from one section: height over the base, and how it answers to the correction.
struct View {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  float jacobian[6];
  float residual_m = 0.0f;
  float weight = 0.0f;               ///< 1 / variance assumed at first
  float beside_m = 0.0f, on = 0.0f;  ///< from the cell's middle: across, and along in node spacings
  std::uint32_t cell = kNone, section = 0;
};

/// Scales of the robust weights, and how far the assumed variances are off.
struct JointScales {
  double base_m = 0.1, view_m = 0.1;       ///< beyond these the weight falls off
  double base_stddev_m = 0.03;             ///< of the base's cells that are believed
  double node_m = 0.1, node_slope = 0.03;  ///< the same for its even error
  double node_stddev_m = 0.03, node_slope_stddev = 0.01;
  double common_slope = 0.03,
         common_slope_stddev = 0.01;  ///< of the cross slope that all nodes share
  double view_factor = 1.0;           ///< variance of views over 1 / weight
  /// How many cells' worth of error comes at once, as errors of neighbours go together.
  double base_together = 1.0, view_together = 1.0;
};

/// What one look at the residuals tells about the scales.
struct JointFacts {
  double base_mad_m = 0.0;    ///< robust deviation of cells from the base, less its even error
  double cell_noise_m = 0.0;  ///< typical deviation of means of a cell's views, as assumed
  double node_mad_m = 0.0, node_slope_mad = 0.0;  ///< of that; slopes about what they share
  double view_mad = 0.0;    ///< of views from their cells, in assumed deviations
  double view_mad_m = 0.0;  ///< the same in metres
  double residual_m = 0.0;  ///< of views from the base, tilted as a whole as it should be
  double between_passes_m = 0.0;
  double believed = 0.0;  ///< share of the cells whose base is believed
};

/// Weight of a residual: Geman and McClure's loss.
inline double geman_mcclure(double residual, double scale) {
  const double a = 1.0 + residual * residual / (scale * scale);
  return 1.0 / (a * a);
}

class JointProblem {
 public:
  /// `before`: corrections that the sections' poses already have; empty: none. The trajectory's
  /// stiffness holds for the sum.
  JointProblem(const Sections& sections, const RoadFrame& frame, const MapOptions& options,
               std::vector<Correction> before);

  /// Told by the caller's thread what share of a step of solve() is done.
  void on_progress(std::function<void(double share)> tell) { tell_ = std::move(tell); }
  /// Residuals and Jacobians at these corrections.
  void linearise(const std::vector<Correction>& at);
  /// `for_report`: residual_m and between_passes_m too; 0 without.
  JointFacts facts(const std::vector<Correction>& now, const JointScales& scales, bool for_report);
  /// Errors that neighbours share: variance of means of 4 m x 4 m over what independent cells give.
  void measure_together(const std::vector<Correction>& now, JointScales& scales) const;
  /// One standard deviation of where each pose lies beside the stated place, m, before points tell.
  void hold_aside(double stddev_m) { aside_m_ = stddev_m; }
  /// One step: new weights at `now`, then the corrections that minimise.
  std::vector<Correction> solve(const std::vector<Correction>& now, const JointScales& scales);
  /// Without a base the points tell nothing about where the road lies and how it is turned as a
  /// whole: moves all poses together to where the trajectory's stiffness wants them.
  void hold_as_a_whole(std::vector<Correction>& now) const;
  /// From the normal equations of the last solve, with a whole road that may be tilted by so much,
  /// and points that fit `times` as well as the equations assume (variances).
  void deviations(double common_slope_stddev, double times, const JointScales& scales,
                  Drift& drift);
  /// Once the poses are nearly right: the base may be tilted as a whole, and views know of its even
  /// error within their cells. (Far away these freedoms lead astray.)
  void refine();
  /// The same from the beginning, as an estimate before found the tilt.
  void refine_at(double base_tilt);
  bool is_fine() const { return fine_; }
  double common_slope() const { return common_slope_; }
  double common_slope_stddev() const { return common_slope_stddev_; }
  /// What the base lacks in fall to both sides of the line, m/m: no pose looks like that. 0 where
  /// the first look does not tell.
  double crown() const { return crown_; }
  /// Share of a section's views that lie on cells whose base is believed.
  double believed_share(std::size_t section) const;

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  struct Seen;
  struct Stretch;
  struct Gone;
  struct Samples;
  /// Error of the base that is even over metres: height and cross slope at a place along the road.
  struct Node {
    double height_m = 0.0, slope = 0.0;
    double height_weight = 1.0, slope_weight = 1.0;  ///< robust: is there no such error?
  };
  struct Cell {
    float height_m = 0.0f;  ///< mean of its views
    float slant_m = 0.0f;   ///< how much of that changes to the next across, beyond what all do
    float believed = 1.0f;  ///< robust weight of the base
  };
  /// The node before a cell, the one after it, the share of the latter; its middle across the road.
  struct CellNodes {
    std::size_t before = 0, after = 0;
    double share = 0.0, v_m = 0.0;
  };
  CellNodes nodes_of(std::size_t cell) const {
    const std::size_t i = cell / across_, j = cell % across_;
    const double at =
        (static_cast<double>(i) + 0.5) / (0.5 * static_cast<double>(rows_per_stretch_));
    CellNodes nodes;
    nodes.before = static_cast<std::size_t>(at), nodes.after = nodes.before + 1;
    nodes.share = at - static_cast<double>(nodes.before);
    // The last stretch of a closed road may be short: its end is the road's beginning.
    if (frame_.closed() && nodes.after * rows_per_stretch_ / 2 >= along_) nodes.after = 0;
    nodes.v_m = frame_.v_m().front() + (static_cast<double>(j) + 0.5) * kSectionCell_m;
    return nodes;
  }
  /// Even error of the base at the middle of a cell.
  double even_error(std::size_t cell) const;
  /// Robust weight of the base at a cell that lies so high over it and its even error.
  double belief(const Cell& cell, double uneven_m, const JointScales& scales) const {
    constexpr double kNoise = 0.65;  // of the base's scale: sparse cells slant as much by chance
    const double slant_m =
        std::max(0.0, std::abs(static_cast<double>(cell.slant_m)) - kNoise * scales.base_m);
    return geman_mcclure(std::hypot(uneven_m, slant_m), scales.base_m);
  }
  /// Of all cells, by the heights of the step before. Where the base has another shape, as of a
  /// kerb, some height agrees with it wherever the poses lie: that moved them aside.
  void find_slants();
  /// Residuals and Jacobians of the views of a section, without what the base's crown lacks.
  void linearise(std::size_t section, const std::vector<Correction>& at);
  /// Of the first look at all views.
  void find_crown();
  /// How the even error at a view's own place differs from that at the middle of its cell, by the
  /// height and slope of the node before and of the node after.
  static Eigen::Vector4d within_cell(const View& view, const CellNodes& nodes);
  /// `nodes`: of the view's cell.
  double residual_of(const View& view, const CellNodes& nodes,
                     const std::vector<Correction>& now) const;
  /// The sections that see a stretch, and its nodes.
  void unknowns_of(std::size_t stretch, Stretch& out) const;
  void assemble(std::size_t stretch, const std::vector<Correction>& now, const JointScales& scales,
                Stretch& out);
  /// Eliminates the height of a cell, by what it takes away of each section and of the nodes.
  static void take_away(const std::vector<Gone>& gone, const Eigen::Vector4d& of_nodes, double pull,
                        Stretch& out);
  /// Into the equations of a stretch, and empties it for its next half.
  static void put_seen(Eigen::Index node, Stretch& out);
  /// All stretches at these corrections, without what is known before; new weights.
  void assemble_all(const std::vector<Correction>& now, const JointScales& scales);
  void add(const Stretch& stretch);
  /// Of the stretches with what is known before; throws Misfit.
  void factorise(const std::vector<Eigen::Triplet<double>>& known);
  /// Unknown of that number: the sections' corrections in all, the nodes, the common slope.
  double value_of(std::size_t unknown, const std::vector<Correction>& now) const;
  /// The corrections after a step of all unknowns; nodes and common slope take theirs.
  std::vector<Correction> stepped(std::vector<Correction> now, const Eigen::VectorXd& step);
  /// Calls what(from, to) with the places in order_ of each cell of a stretch that has views.
  template <typename What>
  void each_cell(std::size_t stretch, const What& what) const {
    const std::size_t end = stretch_begin_[stretch + 1];
    for (std::size_t from = stretch_begin_[stretch], to = from; from < end; from = to) {
      const std::uint32_t cell = views_[order_[from]].cell;
      while (to < end && views_[order_[to]].cell == cell) ++to;
      what(from, to);
    }
  }
  /// What the views of one cell show.
  void sample(std::size_t from, std::size_t to, const std::vector<Correction>& now,
              const JointScales& scales, Samples& out) const;
  /// Means of the cells' views at these corrections; 0 without views.
  std::vector<float> heights_at(const std::vector<Correction>& now,
                                const JointScales& scales) const;
  /// Of the base's even error, across the road.
  double even_slope(std::size_t i) const;
  /// Of a cell's height over that, along and across the road, from its neighbours.
  Eigen::Vector2d slope_of(std::size_t i, std::size_t j) const;
  double points_of(std::uint32_t view) const;
  /// Of the passes that see a stretch, each stretch leaves out another one; -1: fewer than two.
  int pass_left_out(std::size_t stretch) const;
  /// What is left of the drift over a stretch, for the mean of all views; or, with a pass, for the
  /// difference of its views to those of the others. `functional`: room for that, kept.
  StretchDeviation deviation_of(std::size_t stretch, int left_out,
                                Eigen::MatrixXd& functional) const;
  void add_prior(std::vector<Eigen::Triplet<double>>& entries) const;
  /// Robust weights of the nodes and of the tilt, and what they say.
  void add_prior_of_base(const JointScales& scales, std::vector<Eigen::Triplet<double>>& entries);

  const Sections& sections_;
  const RoadFrame& frame_;
  const MapOptions& options_;
  std::function<void(double)> tell_;
  std::size_t along_ = 0, across_ = 0, rows_per_stretch_ = 0, stretches_ = 0;
  double cell_rows_ = 1.0;
  std::vector<View> views_;                 ///< by section
  std::vector<std::size_t> first_;          ///< of each section
  std::vector<std::uint32_t> order_;        ///< of views by cell
  std::vector<std::size_t> stretch_begin_;  ///< into order_
  std::vector<Cell> cells_;
  std::vector<Node> nodes_;                 ///< every half stretch; linear between them
  double common_slope_ = 0.0;               ///< of the base's even error: the whole road tilted
  double crown_ = 0.0, crown_out_m_ = 0.0;  ///< and how far out from the line
  std::vector<Correction> at_, before_;
  bool weighed_ = false, fine_ = false;
  double aside_m_ = kAnywhere_m;
  double common_weight_ = 0.0,
         common_slope_stddev_ = 0.0;  ///< of its prior, in the equations; found
  BlockMatrix matrix_;  ///< of the stretches: sections' corrections, nodes, the common slope
  BlockMatrix factor_;
  Eigen::VectorXd right_;
};

}  // namespace cloud
