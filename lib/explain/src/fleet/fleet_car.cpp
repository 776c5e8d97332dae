#include "fleet_car.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "information.h"
#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Places of a drive's columns: the car's, and its own.
struct Split {
  std::vector<Index> of_car, of_drive;  // in the whole matrix
  std::vector<std::size_t> own_columns;
};

Split split(const DriveSummary& drive) {
  Split out;
  const auto road = static_cast<Index>(drive.road_columns());
  for (std::size_t k = 0; k < drive.columns.size(); ++k) {
    if (drive.columns[k].of_car) {
      out.of_car.push_back(road + static_cast<Index>(k));
    } else {
      out.of_drive.push_back(road + static_cast<Index>(k));
      out.own_columns.push_back(k);
    }
  }
  return out;
}

VectorXd right_of(const Information& sums) {
  return Eigen::Map<const VectorXd>(sums.right.data(), static_cast<Index>(sums.right.size()));
}

/// Of the car's unknowns: the road by all rows, by those with forces, columns of the car.
std::vector<Index> places_in_car(const std::vector<std::size_t>& places, Index road) {
  std::vector<Index> out;
  out.reserve(places.size());
  for (const std::size_t p : places) out.push_back(2 * road + static_cast<Index>(p));
  return out;
}

}  // namespace

std::vector<std::size_t> join_columns(CarSums& car, const DriveSummary& drive) {
  std::vector<std::size_t> out;
  for (const SummaryColumn& c : drive.columns) {
    if (!c.of_car) continue;
    const auto known = std::find_if(car.columns.begin(), car.columns.end(),
                                    [&](const SummaryColumn& o) { return o.key == c.key; });
    out.push_back(static_cast<std::size_t>(known - car.columns.begin()));
    if (known == car.columns.end()) {
      car.columns.push_back(c);
    } else if (!(*known == c)) {
      throw vehicle::Error(fmt::format(
          "{}: {} is stated otherwise than in another drive of the same car; make the summaries "
          "anew with one program",
          drive.recording, c.name));
    }
  }
  std::vector<std::size_t> sorted = out;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw vehicle::Error(drive.recording + ": the summary has an unknown twice");
  return out;
}

namespace {

/// A drive's sums as matrices: of all rows, and of those with forces.
struct Whole {
  explicit Whole(const DriveSummary& drive)
      : forces(whole_matrix(drive.by_forces, drive)),
        all(whole_matrix(drive.by_sensors, drive) + forces),
        right_forces(right_of(drive.by_forces)),
        right(right_of(drive.by_sensors) + right_forces),
        road(static_cast<Index>(drive.road_columns())),
        at(split(drive)) {}
  MatrixXd forces, all;
  VectorXd right_forces, right;
  Index road;
  Split at;
};

OwnOfDrive own_of(const DriveSummary& drive, const Whole& whole,
                  const std::vector<std::size_t>& places, std::size_t width) {
  const auto& [forces, all, right_forces, right, road, at] = whole;
  const auto own = static_cast<Index>(at.of_drive.size());
  OwnOfDrive out;
  out.column = at.own_columns;
  if (own == 0) return out;
  out.normal = all(at.of_drive, at.of_drive);
  for (Index k = 0; k < own; ++k) {
    const double deviation = drive.columns[at.own_columns[static_cast<std::size_t>(k)]].deviation;
    out.normal(k, k) += 1 / (deviation * deviation);
  }
  out.with = MatrixXd::Zero(2 * road + static_cast<Index>(width), own);
  out.with.topRows(road) = all(Eigen::seqN(0, road), at.of_drive);
  out.with.middleRows(road, road) = forces(Eigen::seqN(0, road), at.of_drive);
  out.with(places_in_car(places, road), Eigen::all) = all(at.of_car, at.of_drive);
  out.right = right(at.of_drive);
  return out;
}

}  // namespace

OwnOfDrive own_of(const DriveSummary& drive, const std::vector<std::size_t>& places,
                  std::size_t width) {
  return own_of(drive, Whole(drive), places, width);
}

Reduced reduce(const DriveSummary& drive, const std::vector<std::size_t>& places,
               std::size_t width) {
  const Whole whole(drive);
  const auto& [forces, all, right_forces, right, road, at] = whole;
  const Index n = 2 * road + static_cast<Index>(width);
  const auto at_road = Eigen::seqN(0, road);
  const std::vector<Index> in_car = places_in_car(places, road);
  Reduced out{MatrixXd::Zero(n, n), VectorXd::Zero(n)};
  out.normal.topLeftCorner(road, road) = all(at_road, at_road);
  out.normal.block(road, 0, road, road) = forces(at_road, at_road);
  out.normal.block(road, road, road, road) = forces(at_road, at_road);
  out.normal(in_car, at_road) = all(at.of_car, at_road);
  out.normal(in_car, Eigen::seqN(road, road)) = forces(at.of_car, at_road);
  out.normal(in_car, in_car) = all(at.of_car, at.of_car);
  out.right.head(road) = right(at_road);
  out.right.segment(road, road) = right_forces(at_road);
  out.right(in_car) = right(at.of_car);
  const OwnOfDrive own = own_of(drive, whole, places, width);
  if (own.column.empty()) return out;
  const Eigen::LLT<MatrixXd> solver(own.normal);
  if (solver.info() != Eigen::Success || !solver.matrixLLT().diagonal().allFinite())
    throw vehicle::Error(drive.recording +
                         ": the sums of the summary are none of a fit; make it anew with "
                         "crgexplain summary");
  const MatrixXd w = solver.matrixL().solve(own.with.transpose());
  const VectorXd b = solver.matrixL().solve(own.right);
  out.normal.selfadjointView<Eigen::Lower>().rankUpdate(w.transpose(), -1.0);
  out.right -= w.transpose() * b;
  return out;
}

void add(CarSums& car, const Reduced& drive, std::size_t road) {
  const auto wanted = static_cast<Index>(2 * road + car.columns.size()), there = car.normal.rows(),
             n = drive.normal.rows();
  if (there < wanted) {
    car.normal.conservativeResize(wanted, wanted);
    car.normal.bottomRows(wanted - there).setZero();
    car.normal.rightCols(wanted - there).setZero();
    car.right.conservativeResize(wanted);
    car.right.tail(wanted - there).setZero();
  }
  car.normal.topLeftCorner(n, n) += drive.normal;
  car.right.head(n) += drive.right;
}

}  // namespace explain
