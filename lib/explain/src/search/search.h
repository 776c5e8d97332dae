// Score tests of many alternatives against one fitted model, with their joint null distribution.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "rows.h"

namespace explain {

/// A ridge fit in whitened rows: e = r - X beta.
struct Fitted {
  Eigen::MatrixXd x;       ///< whitened columns
  Eigen::VectorXd r, e;    ///< whitened residual before and after
  Eigen::VectorXd amount;  ///< of each column
  Eigen::LDLT<Eigen::MatrixXd> normal;
  double loss = 0.0;  ///< e'e plus the prior's part
};

/// Keeps a normal matrix solvable; relative to each column, whose units differ by many powers of
/// ten.
void steady(Eigen::MatrixXd& normal);

/// `precision` is the prior's 1/width^2, `before` the amounts already spent.
Fitted fit(const Eigen::MatrixXd& x, const Eigen::VectorXd& r, const Eigen::VectorXd& precision,
           const Eigen::VectorXd& before);

/// One whitened column that may be switched on over a run of cells.
struct Family {
  std::size_t id = 0;      ///< the caller's
  Eigen::VectorXd column;  ///< whitened
  std::vector<int> cell;   ///< per row; -1: in none. Empty: one test of the whole column
  int cells = 0;
  std::vector<int> lengths;  ///< of the runs that are tried
  int sign = 0;              ///< +1: only a positive amount counts
  double least_left = 0.05;  ///< share of the column's square that the model must leave to it;
                             ///< less: it can do this already
};

struct Test {
  std::size_t family = 0;
  int begin = 0, end = 0;  ///< cells
  double amount = 0.0, gain = 0.0;
  double z = 0.0;  ///< of a run as it was scanned, before its ends were moved
  double local_z =
      0.0;  ///< z over the spread of z of the other places, where that is wider than noise
};

struct Scan {
  std::vector<Test> best;        ///< the best of each family
  double threshold = 0.0;        ///< of |z|: exceeded by 0.45 % of the nulls, over all families
  double false_alarms = 0.0;     ///< share of as many other nulls that exceed it
  std::vector<double> null_max;  ///< sorted
};

/// Every family's best run, and the distribution of the largest |z| of all when the signs of the
/// blocks of the residual are flipped at random (fixed seed). Errors of the stated curves return
/// every lap at many places: a place must stand out from the others (local_z), not only from noise.
/// `noise`: the residual that is flipped.
Scan scan(const Fitted& model, const std::vector<Family>& families, const Rows& rows,
          std::size_t nulls, const Eigen::VectorXd& noise);

/// A family's column where it acts on cells begin to end - 1; zero elsewhere. A family without
/// cells acts everywhere.
Eigen::VectorXd within(const Eigen::VectorXd& column, const std::vector<int>& cell, int begin,
                       int end);

/// The residual without what the best test explains, and the best of what is left, as long as that
/// is more than noise gives: flipped with them, effects would hide themselves and one another.
Eigen::VectorXd without_what_stands_out(const Fitted& model, const std::vector<Family>& families,
                                        const Rows& rows);

/// Loss saved by the columns `more` on folds that were left out: one value per fold whose rows have
/// weight.
std::vector<double> cross_validate(const Fitted& model, const Eigen::MatrixXd& more,
                                   const Eigen::VectorXd& precision,
                                   const Eigen::VectorXd& more_precision, const Rows& rows);

/// What is added to the covariance of the fitted amounts where a prior is narrower than the amount
/// may be off by. `beyond`: of each column, the variance that its prior leaves out; 0: none.
Eigen::MatrixXd held_too_near(const Fitted& model, const Eigen::VectorXd& precision,
                              const Eigen::VectorXd& beyond);

/// The column without what the model's columns can do.
Eigen::VectorXd beyond(const Fitted& model, const Eigen::VectorXd& column);

}  // namespace explain
