#include "fleet_joint.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::LLT;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr auto kKinds = static_cast<Index>(kRoadKinds);
constexpr double kAlike_m = 100.0;
constexpr double kNoMean = 1e4;  ///< in deviations: what sums to nothing along a lap
constexpr double kNone = 1e-4;   ///< of a step: the size of a profile that is not there

double size_of(const Sizes& sizes, std::size_t kind) {
  return std::max(sizes[kind], kNone * kRoad[kind].step);
}

LLT<MatrixXd> solved(const MatrixXd& normal, const std::string& what) {
  LLT<MatrixXd> out(normal);
  if (out.info() != Eigen::Success || !out.matrixLLT().diagonal().allFinite())
    throw vehicle::Error(what +
                         ": the sums of its summaries are none of a fit; make them anew "
                         "with crgexplain summary");
  return out;
}

double log_determinant_of(const LLT<MatrixXd>& solver) {
  return 2 * solver.matrixLLT().diagonal().array().log().sum();
}

/// Road, own profile, columns in: places in the car's sums.
std::vector<Index> places_of(Index road, const std::vector<std::size_t>& in, Index first) {
  std::vector<Index> out;
  for (Index k = first; k < 2 * road; ++k) out.push_back(k);
  for (const std::size_t k : in) out.push_back(2 * road + static_cast<Index>(k));
  return out;
}

/// Their products, both halves, with the priors of own profile and columns.
MatrixXd normal_of(const CarSums& car, const RoadShape& shape, const Sizes& own,
                   const std::vector<Index>& places, Index road) {
  MatrixXd out(static_cast<Index>(places.size()), static_cast<Index>(places.size()));
  for (Index k = 0; k < out.rows(); ++k)
    for (Index l = 0; l <= k; ++l)
      out(k, l) = out(l, k) = car.normal(
          std::max(places[static_cast<std::size_t>(k)], places[static_cast<std::size_t>(l)]),
          std::min(places[static_cast<std::size_t>(k)], places[static_cast<std::size_t>(l)]));
  const Index own_at = places.front() == 0 ? road : 0;
  out.block(own_at, own_at, road, road) += precision_of(shape, own, false);
  for (Index k = own_at + road; k < out.rows(); ++k) {
    const SummaryColumn& c =
        car.columns[static_cast<std::size_t>(places[static_cast<std::size_t>(k)] - 2 * road)];
    if (!c.candidate) out(k, k) += 1 / (c.deviation * c.deviation);
  }
  return out;
}

}  // namespace

RoadShape road_shape(std::size_t knots, double length_m, bool closed) {
  const auto n = static_cast<Index>(knots);
  const double space_m = length_m / static_cast<double>(closed ? n : n - 1);
  MatrixXd covariance(n, n);
  for (Index k = 0; k < n; ++k)
    for (Index l = 0; l < n; ++l) {
      const Index apart = std::abs(k - l), near = closed ? std::min(apart, n - apart) : apart;
      covariance(k, l) = std::exp(-static_cast<double>(near) * space_m / kAlike_m);
    }
  const MatrixXd inverse = covariance.llt().solve(MatrixXd::Identity(n, n));
  RoadShape out;
  out.knots = knots;
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
    out.own[kind] = out.common[kind] = inverse;
    if (closed && kRoad[kind].sums_to_nothing)
      out.common[kind] += MatrixXd::Constant(n, n, kNoMean / static_cast<double>(n));
  }
  return out;
}

MatrixXd precision_of(const RoadShape& shape, const Sizes& sizes, bool common) {
  const auto knots = static_cast<Index>(shape.knots);
  MatrixXd out = MatrixXd::Zero(knots * kKinds, knots * kKinds);
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
    const double size = size_of(sizes, kind);
    const auto at = Eigen::seqN(static_cast<Index>(kind), knots, kKinds);
    out(at, at) = (common ? shape.common : shape.own)[kind] / (size * size);
  }
  return out;
}

double log_determinant(const RoadShape& shape, const Sizes& sizes, bool common) {
  double out = 0;
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    out += log_determinant_of(LLT<MatrixXd>((common ? shape.common : shape.own)[kind])) -
           2 * static_cast<double>(shape.knots) * std::log(size_of(sizes, kind));
  return out;
}

CarSays says(const CarSums& car, const RoadShape& shape, const Sizes& own,
             const std::vector<std::size_t>& in) {
  const auto road = static_cast<Index>(shape.knots) * kKinds;
  const std::vector<Index> places = places_of(road, in, road);
  const LLT<MatrixXd> solver = solved(normal_of(car, shape, own, places, road), car.name);
  // Of places below the road all products with it lie in the lower half.
  const MatrixXd with = solver.matrixL().solve(car.normal(places, Eigen::seqN(0, road)));
  const VectorXd right = solver.matrixL().solve(car.right(places));
  CarSays out;
  out.information = car.normal.topLeftCorner(road, road).selfadjointView<Eigen::Lower>();
  out.information.selfadjointView<Eigen::Lower>().rankUpdate(with.transpose(), -1.0);
  out.information = MatrixXd(out.information.selfadjointView<Eigen::Lower>());
  out.right = car.right.head(road) - with.transpose() * right;
  out.evidence = 0.5 * right.squaredNorm() - 0.5 * log_determinant_of(solver) +
                 0.5 * log_determinant(shape, own, false);
  for (const std::size_t k : in)
    if (!car.columns[k].candidate) out.evidence -= std::log(car.columns[k].deviation);
  return out;
}

RoadEstimate road_estimate(const std::vector<const CarSays*>& cars, const RoadShape& shape,
                           const Sizes& sizes) {
  RoadEstimate out;
  out.precision = precision_of(shape, sizes, true);
  out.right = VectorXd::Zero(out.precision.rows());
  for (const CarSays* car : cars) out.precision += car->information, out.right += car->right;
  const LLT<MatrixXd> solver = solved(out.precision, "the road");
  out.amounts = solver.solve(out.right);
  out.evidence = 0.5 * out.right.dot(out.amounts) - 0.5 * log_determinant_of(solver) +
                 0.5 * log_determinant(shape, sizes, true);
  return out;
}

CarEstimate estimate(const CarSums& car, const RoadShape& shape, const Sizes& own,
                     const std::vector<std::size_t>& in, const RoadEstimate& others) {
  const auto road = static_cast<Index>(shape.knots) * kKinds;
  CarEstimate out;
  out.places = places_of(road, in, 0);
  MatrixXd normal = normal_of(car, shape, own, out.places, road);
  normal.topLeftCorner(road, road) += others.precision;
  VectorXd right = car.right(out.places);
  right.head(road) += others.right;
  out.solver = solved(normal, car.name);
  out.amounts = out.solver.solve(right);
  return out;
}

CarTests test_columns(const CarSums& car, const RoadShape& shape, const Sizes& own,
                      const std::vector<std::size_t>& in, const std::vector<std::size_t>& tested,
                      const RoadEstimate& others) {
  const auto road = static_cast<Index>(shape.knots) * kKinds;
  const auto& [places, solver, amounts] = estimate(car, shape, own, in, others);
  CarTests out;
  out.amounts = amounts;
  const auto t = static_cast<Index>(tested.size());
  MatrixXd with(amounts.size(), t), among(t, t);
  VectorXd own_right(t);
  for (Index k = 0; k < t; ++k) {
    const Index at = 2 * road + static_cast<Index>(tested[static_cast<std::size_t>(k)]);
    for (Index l = 0; l < with.rows(); ++l) {
      const Index other = places[static_cast<std::size_t>(l)];
      with(l, k) = car.normal(std::max(at, other), std::min(at, other));
    }
    for (Index l = 0; l < t; ++l) {
      const Index other = 2 * road + static_cast<Index>(tested[static_cast<std::size_t>(l)]);
      among(k, l) = car.normal(std::max(at, other), std::min(at, other));
    }
    own_right[k] = car.right[at];
  }
  if (t > 0) {
    const MatrixXd half = solver.matrixL().solve(with);
    out.left = among - half.transpose() * half;
    own_right -= with.transpose() * out.amounts;
  }
  for (Index k = 0; k < t; ++k) {
    ColumnTest test;
    test.column = tested[static_cast<std::size_t>(k)];
    // What is left of next to nothing is rounding, or what the model can do already.
    constexpr double kLeastLeft = 0.015;
    if (out.left(k, k) > kLeastLeft * among(k, k) && among(k, k) > 0) {
      test.amount = own_right[k] / out.left(k, k);
      test.deviation = 1 / std::sqrt(out.left(k, k));
      test.gain = own_right[k] * test.amount;
    }
    out.test.push_back(test);
  }
  const Index first = 2 * road;
  for (std::size_t k = 0; k < in.size(); ++k) {
    const Index at = first + static_cast<Index>(k);
    const double mean = out.amounts[at],
                 variance = solver.solve(VectorXd::Unit(amounts.size(), at))[at];
    out.mean.push_back(mean);
    out.variance.push_back(variance);
    const SummaryColumn& c = car.columns[in[k]];
    const double prior = c.candidate ? 0.0 : 1 / (c.deviation * c.deviation);
    const double left = 1 / variance - prior, push = mean / variance;
    ColumnTest freed{in[k], 0.0, 0.0, 0.0};
    if (left > 1e-6 * prior) {
      freed.amount = push / left;
      freed.deviation = 1 / std::sqrt(left);
      // From where the prior holds it.
      freed.gain = push * push / left - push * push / (left + prior);
      if (prior == 0.0) freed.gain = push * push / left;
    }
    out.refitted.push_back(freed);
  }
  return out;
}

}  // namespace explain
