// The steps of explain() and what they hand on.
#pragma once

#include <map>
#include <optional>
#include <set>

#include "explain/explain.h"
#include "led_car.h"
#include "search.h"

namespace explain {

/// What was added to the simulation so far.
struct Accepted {
  std::size_t unknown = 0;
  double amount = 0.0;            ///< of an unknown that acts everywhere
  bool kinematic = false;         ///< a sensor that relations without forces judge: they alone say how much
  Eigen::MatrixXd columns;        ///< of a road unknown: one per cell or shape, not whitened
  std::vector<int> cells;         ///< of a stretch: those of the columns
  Eigen::VectorXd precision;      ///< 1 / width^2 of the prior of each column
  Eigen::MatrixXd shapes;         ///< of a profile over the whole lap: value at each place per column
  Eigen::VectorXd amounts;        ///< of its columns, as the setting has them
  bool by_cost = false;           ///< found where forces count as few: so are its limits
};

/// Acts everywhere with one amount.
inline bool has_one_amount(const Accepted& a) { return a.columns.cols() == 0; }

/// What an amount that is free would save of the loss.
struct Saved {
  double amount = 0.0, gain = 0.0;
  Eigen::VectorXd column;         ///< what it does per unit, whitened
};

class Analysis {
 public:
  Analysis(const std::vector<Signals>& logs, const vehicle::Vehicle& car, const ExplainOptions& options);
  Findings run();

 private:
  using Index = Eigen::Index;
  struct Model {
    Fitted fitted;
    Eigen::VectorXd precision;
  };
  void refit(int rounds);                       ///< Gauss-Newton of parameters, curves and what was accepted
  void weigh();                                 ///< by what the model leaves now
  void find_road_profiles(Findings& out);       ///< what sensors alone say about the whole lap
  Model model(const Eigen::VectorXd& weights) const;  ///< parameters and curves first
  Model model() const { return model(weights()); }
  Model careful_model() const { return model(careful_weights()); }
  std::vector<Family> candidates() const;
  std::vector<Family> structures() const;
  bool step(Findings& out, bool first);         ///< finds and adds one; false: nothing more
  Eigen::VectorXd weights() const;              ///< of the rows that the present stage looks at
  bool in_stage(std::size_t candidate) const;
  bool kinematic_ = false;                      ///< sensors and road, in relations without tyres and forces
  /// One that was accepted and that later ones made too small, of the wrong sign, or no more than it may be
  /// wrong by.
  std::optional<std::size_t> faded(const Findings& out) const;
  void drop_faded(Findings& out);
  void untouched(Findings& out) const;          ///< lists what left no trace
  struct Freed {
    std::size_t place = 0;                      ///< in refit_
    std::vector<std::size_t> rivals;            ///< places that would have done as well
    double saved = 0.0;                         ///< of loss; 0: none
  };
  struct Weighed {
    std::size_t unknown = 0;
    Saved saved;
  };
  static Saved saved_by(const Model& m, Eigen::VectorXd column);
  /// The column as a secant to the best amount, in these weights; gain 0: none.
  Saved exact(std::size_t unknown, double start, const Model& m, const Eigen::VectorXd& weights) const;
  /// Whether a stretch of road is more than what the stated curves get wrong elsewhere, and saves enough where
  /// forces count as few.
  bool stands_out(const Family& along, const Test& stretch, double threshold) const;
  double best_stretch(const Model& m) const;    ///< gain of the best stretch of road where forces count as few
  Eigen::VectorXd careful_column(std::size_t unknown) const;  ///< of a candidate, where forces count as few
  std::vector<Family> families_by_cost() const; ///< mechanisms of car and air
  Freed best_parameter(const Model& m) const;   ///< whose freedom saves most
  std::vector<Weighed> mechanisms_by_cost(const Model& m) const;  ///< of car and air, that which saves most first
  void free_parameters();                       ///< lets those go that are far from their stated values, but not where a mechanism does better
  bool apart_from_curves(std::size_t unknown) const;  ///< enough of it is left to test
  double alarms_by_cost() const;                ///< share of nulls in which a mechanism would save enough
  void let_go(const Freed& f);
  static double limit(const Unknown& u);        ///< of a parameter's change in the refit
  double width(std::size_t place) const;        ///< of the prior in the refit
  bool step_by_cost(Findings& out);             ///< frees a parameter or adds a mechanism, whichever saves more; false: nothing more
  bool used(const Unknown& u) const;            ///< already accepted
  Finding finding_of(std::size_t unknown) const;
  double stability(const Fitted& model, const Eigen::VectorXd& column, double amount) const;
  void accept(Findings& out, Finding found, Accepted a);
  Eigen::VectorXd careful_weights() const;      ///< with forces counting as few
  Eigen::VectorXd careful_;                     ///< those at the first fit
  void describe(Findings& out) const;
  void leftovers(Findings& out);
  void prove(Findings& out);
  Setting stated_;                              ///< the car as stated, in steps that are short enough
  void choose_substeps();
  std::vector<std::string> remarks_;
  Setting setting_with(const Eigen::VectorXd& amounts) const;
  Eigen::VectorXd rows_at(const Setting& setting) const;
  void look();                                  ///< rows and drives at the amounts
  void progress(const std::string& stage, double share) const {
    if (options_.progress) options_.progress(stage, share);
  }

  const std::vector<Signals>& logs_;
  const vehicle::Vehicle& car_;
  const ExplainOptions& options_;
  Inventory inventory_;
  Rows rows_;
  std::vector<bool> training_;
  std::vector<std::size_t> refit_;              ///< places of parameters and curves
  std::set<std::size_t> undetermined_;          ///< places that ran to their limit when let go
  std::vector<Freed> freed_;
  Eigen::VectorXd amounts_;                     ///< of refit_, then of accepted_ that act everywhere
  std::vector<Accepted> accepted_;
  Eigen::VectorXd r_;                           ///< rows at the current setting, not whitened
  std::vector<KnownDrive> drives_;              ///< of the recordings there
  Eigen::VectorXd stated_rows_;
  Eigen::MatrixXd moves_;                       ///< columns of refit_ and accepted_ there
  Eigen::MatrixXd candidate_moves_;             ///< columns of the candidates, at the first fit
  std::vector<std::size_t> candidate_;
  Eigen::VectorXd weight_;                      ///< of each row, 1 / standard deviation
  std::array<double, kRelationCount> sigma_{}, spread_{};
  static constexpr double kCell_m = 10.0;
  int cells_ = 0;
  static constexpr double kStretch_m = 40.0;
  Index stretches() const { return static_cast<Index>(cells_ * kCell_m / kStretch_m) + 2; }
  static Index stretch(const Row& row) { return static_cast<Index>(row.u_m / kStretch_m); }
};

}  // namespace explain
