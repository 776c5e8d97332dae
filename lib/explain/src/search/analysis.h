// The steps of explain_relations() and what they hand on. Where each stands: the model and its
// refit in analysis.cpp; look.cpp; road_profiles.cpp; by_score.cpp; by_cost.cpp; drop_faded.cpp;
// describe.cpp; leftovers.cpp; prove.cpp.
#pragma once

#include <map>
#include <optional>
#include <set>

#include "explain/explain.h"
#include "led_car.h"
#include "search.h"
#include "selection.h"

namespace explain {

struct DriveSummary;  // explain/summary.h

/// What was added to the simulation so far.
struct Accepted {
  std::size_t unknown = 0;
  double amount = 0.0;        ///< of an unknown that acts everywhere
  bool kinematic = false;     ///< relations without forces judge it: they alone say how much
  Eigen::MatrixXd columns;    ///< of a road unknown: one per cell or shape, not whitened
  std::vector<int> cells;     ///< of a stretch: those of the columns
  Eigen::VectorXd precision;  ///< 1 / width^2 of the prior of each column
  Eigen::MatrixXd shapes;     ///< of a profile over the whole lap: value at each place per column
  Eigen::VectorXd amounts;    ///< of its columns, as the rows have them; empty: not at all
  bool by_cost = false;       ///< found where forces count as few: so are its limits
};

/// Acts everywhere with one amount.
inline bool has_one_amount(const Accepted& a) { return a.columns.cols() == 0; }

inline bool is_kinematic_stretch(const Accepted& a) { return a.kinematic && !a.cells.empty(); }

/// Which rows judge.
enum class Stage {
  kSensors,  ///< sensors and road, in relations without tyres and forces
  kForces    ///< everything, in all relations
};

/// A rival's experiment beside the own one, where it is another.
std::string experiment_between(const Unknown& u, const Unknown& rival);

/// Whether a mechanism is among the finding's rivals, in whatever channel.
bool is_rival(const Finding& f, const std::string& mechanism);

/// What an amount that is free would save of the loss.
struct Saved {
  double amount = 0.0, gain = 0.0;
  Eigen::VectorXd column;  ///< what it does per unit, whitened
};

/// An amount of an unknown to begin from.
struct Start {
  std::size_t unknown = 0;
  double amount = 0.0;
};

/// Whether the first amount of a finding is more than chance beside all others that are free: its
/// 90 % interval has no zero. A road is believed last: twice the interval has none.
bool lasts(const Finding& finding);

class Analysis {
 public:
  /// The car as stated, led along the recordings in steps that are short enough.
  Analysis(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
           const ExplainOptions& options);
  /// Whether those that choose are as many as an analysis wants; with forces they are.
  bool enough_rows() const;
  /// Laps, and remarks about logs and car.
  Findings begin() const;
  /// What the turning of the cars alone says about banking along the lap, where nothing measures
  /// it.
  void find_banking_by_turning(Findings& out);
  /// Adds it to the findings that were described.
  void tell_banking_by_turning(Findings& out) const;
  /// What sensors alone say about the road along the whole lap.
  void find_road_profiles(Findings& out);
  /// Gauss-Newton of parameters, curves and what was accepted.
  void refit(int rounds);
  /// One derivative of all rows per mechanism.
  void differentiate_candidates();
  /// Lets those parameters go that are far from their stated values, but not where a mechanism does
  /// better.
  void free_parameters();
  /// Adds mechanisms one by one as their scores against null replicates say.
  void name_by_score(Findings& out, Stage stage);
  /// The columns where the amounts are now: what was found moves them, and what was let go may be
  /// far from where they were taken.
  void move_columns();
  /// Adds mechanisms, or frees parameters, as what each saves where forces count as few says.
  void name_by_cost(Findings& out);
  /// Lets those parameters go that something else kept back which was not named in the end.
  void free_what_was_kept_back();
  /// Lets those parameters go that came out beyond their prior width although they were held, the
  /// farthest first: what the page calls beyond its prior is named.
  void free_what_is_beyond();
  /// Drops what later ones made too small, of the wrong sign, or no more than it may be wrong by.
  void drop_faded(Findings& out);
  /// Lists what was asked and left no trace.
  void list_untouched(Findings& out) const;
  /// Sizes with their intervals, and the parameters.
  void describe(Findings& out) const;
  /// Significant patterns that nothing explains, and where the stated simulation was off.
  void find_leftovers(Findings& out) const;
  /// Every lap predicted from the others, before and after.
  void prove(Findings& out) const;
  /// What the rows say at the stated inputs, as sums (summary.cpp).
  void summarise(DriveSummary& out);
  /// Lists what these logs cannot speak about.
  void list_untestable(Findings& out) const;

 private:
  using Index = Eigen::Index;
  struct Model {
    Fitted fitted;
    Eigen::VectorXd precision;
  };
  /// A mechanism that was tried, at its best place or amount.
  struct Tried {
    std::size_t family = 0, unknown = 0;
    Test test;
    double gain = 0.0, amount = 0.0;
    Eigen::VectorXd column;
  };
  /// What is tried in one step of name_by_score().
  struct Trial {
    Stage stage;
    Model model;
    std::vector<Family> families;
    Scan scan;
    std::vector<Tried> tried;  ///< that which gains most first
  };
  struct Freed {
    std::size_t place = 0;               ///< in refit_
    std::vector<std::size_t> rivals;     ///< places that would have done as well
    std::optional<std::size_t> instead;  ///< unknown of what does as well and was not named
    double saved = 0.0;                  ///< of loss; 0: none
  };
  struct Weighed {
    std::size_t unknown = 0;
    Saved saved;
  };
  /// Covariances of the fitted amounts: of the noise, between stretches of road, and where forces
  /// count as few.
  struct Spread {
    Model model, careful;
    Eigen::MatrixXd covariance, careful_covariance;
    Eigen::VectorXd by_stretch, by_held, careful_by_held;
    double deviation(Index column) const;
    double careful_deviation(Index column) const;
  };
  /// What each lap is predicted as from the others, in the relations' units, and the weights.
  struct Predicted {
    Eigen::VectorXd before, after, weight;
    std::vector<bool> judged;
  };

  // The model (analysis.cpp).
  /// Drives as stated in steps that are short enough; stated_ and drives_ get longer ones that are
  /// roughly enough.
  std::vector<KnownDrive> choose_substeps();
  void find_what_fine_steps_add();
  Setting setting_with(const Eigen::VectorXd& amounts) const;
  Eigen::VectorXd rows_at(const Setting& setting) const;
  std::vector<Eigen::VectorXd> rows_at(const std::vector<Setting>& settings,
                                       const std::function<void(double)>& progress = {}) const;
  /// Takes what stretches of road do that relations without forces judge.
  void take_stretches(Eigen::VectorXd& rows) const;
  /// Leaves to columns of what is kinematic the rows without forces alone.
  void leave_exact_rows(Eigen::MatrixXd& columns) const;
  /// Of relations that need no forces; the others as they are.
  Eigen::VectorXd rows_without_drive(const Setting& setting) const;
  /// What an earlier run kept at this place, or what `make` gives now, kept if it took long.
  Eigen::MatrixXd kept(const std::function<Eigen::MatrixXd()>& make) const;
  Eigen::MatrixXd columns_of(const std::vector<const Unknown*>& unknowns, const char* stage) const;
  void look();                                        ///< rows and drives at the amounts
  void weigh();                                       ///< by what the model leaves now
  void update_moves(std::size_t from);                ///< columns of what is free, from this one on
  void widen_forms();                                 ///< by errors of the tyres' curves
  void move_amounts();                                ///< by one step of the model
  Model model(const Eigen::VectorXd& weights) const;  ///< parameters and curves first
  Model model(Stage stage = Stage::kForces) const { return model(weights(stage)); }
  Model careful_model(Stage stage = Stage::kForces) const { return model(careful_weights(stage)); }
  Eigen::VectorXd weights(Stage stage) const;
  /// With forces counting as few.
  Eigen::VectorXd careful_weights(Stage stage = Stage::kForces) const;
  std::vector<const Unknown*> free_unknowns() const;
  static double limit(const Unknown& u);  ///< of a parameter's change in the refit
  double width(std::size_t place) const;  ///< of the prior in the refit
  bool used(const Unknown& u) const;      ///< already accepted, or settled
  bool settled(const Unknown& u) const;   ///< by what turning told of the banking
  Finding finding_of(std::size_t unknown) const;
  void accept(Findings& out, Finding found, Accepted a);

  // By score (by_score.cpp).
  bool in_stage(std::size_t candidate, Stage stage) const;
  std::vector<Family> candidates(Stage stage) const;
  bool add_by_score(Findings& out, Stage stage, bool first);  ///< false: nothing more
  Trial trial(Stage stage) const;
  std::vector<double> gains(const Trial& trial, const Tried& t) const;  ///< on folds left out
  void list_evidence(Findings& out, const Trial& trial) const;
  std::optional<Finding> judged(const Trial& trial, const Tried& t) const;
  bool comes_back(const Trial& trial, const Tried& t) const;
  /// Whether what a road does to motion and sensors is not there, where forces ask for it.
  bool is_denied(const Trial& trial, const Tried& t) const;
  void add_rivals(Finding& found, const Trial& trial, const Tried& t) const;
  Accepted accepted_of(const Trial& trial, const Tried& t) const;
  double stability(const Fitted& model, const Eigen::VectorXd& column, double amount) const;
  /// Loss that noise of a sensor costs more than before once its error in time is taken out.
  double louder(const Unknown& u, double amount, const Eigen::VectorXd& weights) const;

  // By cost (by_cost.cpp).
  static Saved saved_by(const Model& m, Eigen::VectorXd column);
  /// The columns as secants to the best amounts from these, in these weights; gain 0: none.
  /// Where `stage` has no forces no car is driven.
  std::vector<Saved> exact(const std::vector<Start>& from, const Model& m,
                           const Eigen::VectorXd& weights, Stage stage) const;
  /// Whether a stretch of road is more than what the stated curves get wrong elsewhere, and saves
  /// enough where forces count as few.
  bool stands_out(const Trial& trial, const Tried& stretch) const;
  /// The best, and its gain where forces count as few.
  struct Stretch {
    std::size_t unknown = 0;
    double gain = 0.0;
    Eigen::VectorXd column;
  };
  Stretch best_stretch(const Model& m) const;
  /// By a stretch that saves more and, once it is in, leaves the parameter little to save.
  bool is_kept_back(const Model& m, const Freed& f) const;
  /// Of a candidate, where forces count as few.
  Eigen::VectorXd careful_column(std::size_t unknown, Stage stage = Stage::kForces) const;
  std::vector<Family> families_by_cost() const;                   ///< mechanisms of car and air
  Freed best_parameter(const Model& m) const;                     ///< whose freedom saves most
  std::vector<Weighed> mechanisms_by_cost(const Model& m) const;  ///< that which saves most first
  bool apart_from_curves(std::size_t unknown) const;              ///< enough of it is left to test
  double alarms_by_cost() const;  ///< share of nulls in which a mechanism would save enough
  void let_go(const Freed& f);
  bool add_by_cost(Findings& out);  ///< false: nothing more

  // What is reported (drop_faded.cpp, describe.cpp, leftovers.cpp, prove.cpp).
  std::optional<std::size_t> faded(const Findings& out) const;
  void drop(std::size_t k, Findings& out);
  Spread spread() const;
  /// What parameters that are held nearer to their stated values than they may be off add.
  Eigen::MatrixXd held_too_near(const Model& m) const;
  void describe_parameters(Findings& out, const Spread& s) const;
  ParameterValue parameter_value(std::size_t place, const Spread& s) const;
  Finding freed_parameter(std::size_t place, const Freed& freed, const ParameterValue& p,
                          const Spread& s) const;
  void describe_amount(Finding& f, const Accepted& a, Index column, const Spread& s) const;
  void describe_stretch(Finding& f, const Accepted& a, Index column, const Spread& s) const;
  /// A road along the whole lap that one kind of measurement shows, in laps of one speed, is a tie:
  /// what the car does there comes back every lap as well.
  void tie_with_the_car(Finding& f, const Fitted& model, const Accepted& a, Index column) const;
  /// Of the laps in the same places, as a share of it.
  double spread_of_speeds() const;
  std::vector<Family> structures() const;
  Unexplained leftover(const Fitted& m, const Family& f, const Test& t) const;
  void find_mismatches(Findings& out, const std::vector<Family>& families) const;
  Mismatch mismatch(const Family& f, const Test& t, const Eigen::VectorXd& residual) const;
  Eigen::VectorXd proof_weights() const;
  /// Columns of all that is free, and the amounts of what was found among them.
  Eigen::MatrixXd all_moves(Eigen::VectorXd& found) const;
  Predicted predicted() const;
  std::optional<HeldOut> held_out(Relation relation, const Predicted& p) const;

  void progress(const std::string& stage, double share) const {
    if (options_.progress) options_.progress(stage, share);
  }

  const std::vector<Signals>& logs_;
  const vehicle::Vehicle& car_;
  const ExplainOptions& options_;
  mutable std::size_t asked_ = 0;  ///< of kept()
  Inventory inventory_;
  Rows rows_;
  std::vector<bool> training_;
  std::vector<std::string> remarks_;
  Setting stated_;                  ///< the car as stated, in steps that are roughly short enough
  int fine_substeps_ = 0;           ///< that are short enough
  Eigen::VectorXd fine_adds_;       ///< to the rows; held while the amounts move
  std::vector<std::size_t> refit_;  ///< places of parameters and curves
  std::vector<std::size_t> candidate_;  ///< of the others
  std::set<std::size_t> undetermined_;  ///< places that ran to their limit when let go
  std::vector<Freed> freed_;
  Eigen::VectorXd amounts_;  ///< of refit_, then of accepted_ that act everywhere
  std::vector<Accepted> accepted_;
  std::optional<Finding> by_turning_;  ///< banking: stays as it was found
  bool judged_by_turning_ = false;     ///< it was looked for there
  RoadProfiles turning_road_;          ///< that banking, with the grade of the line v = 0
  Eigen::VectorXd r_;                  ///< rows at the current setting, not whitened
  std::vector<KnownDrive> drives_;     ///< of the recordings there
  Eigen::VectorXd stated_rows_;
  Eigen::MatrixXd moves_;            ///< columns of refit_ and accepted_ there
  Eigen::MatrixXd candidate_moves_;  ///< columns of the candidates, at the first fit
  Eigen::VectorXd careful_;          ///< careful weights at the first fit
  Eigen::VectorXd weight_;           ///< of each row, 1 / standard deviation
  std::array<double, kRelationCount> sigma_{}, spread_{};
  static constexpr double kCell_m = 10.0;
  int cells_ = 0;
  static constexpr double kStretch_m = 40.0;
  Index stretches() const { return static_cast<Index>(cells_ * kCell_m / kStretch_m) + 2; }
  static Index stretch(const Row& row) { return static_cast<Index>(row.u_m / kStretch_m); }
};

}  // namespace explain
