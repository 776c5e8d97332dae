#include "map_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/statistics.h"
#include "vehicle/map.h"

namespace identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What is left of `rows` at `value`, over a standard deviation that half of them say.
double spread_of(const VectorXd& left) {
  std::vector<double> size(static_cast<std::size_t>(left.size()));
  for (Index r = 0; r < left.size(); ++r) size[static_cast<std::size_t>(r)] = std::abs(left(r));
  return std::max(1e-9, 1.4826 * base::median(size));
}

/// How much the errors of a block go together: 1 alone.
double together(const VectorXd& left, const std::vector<std::size_t>& block) {
  std::map<std::size_t, double> sum;
  for (Index r = 0; r < left.size(); ++r) sum[block[static_cast<std::size_t>(r)]] += left(r);
  double square = 0.0;
  for (const auto& [name, s] : sum) square += s * s;
  return std::max(1.0, square / std::max(1e-300, left.squaredNorm()));
}

/// The inverse of the prior's covariance; a millionth of each variance keeps it from being
/// singular.
MatrixXd inverse_of(const MatrixXd& prior) {
  MatrixXd wider = prior;
  wider.diagonal() *= 1.0 + 1e-6;
  return wider.ldlt().solve(MatrixXd::Identity(prior.rows(), prior.cols()));
}

}  // namespace

std::vector<std::pair<std::size_t, double>> map_weights(const std::vector<double>& x_axis,
                                                        const std::vector<double>& y_axis, double x,
                                                        double y) {
  const auto i = vehicle::map_detail::place(x_axis, x), j = vehicle::map_detail::place(y_axis, y);
  std::vector<std::pair<std::size_t, double>> out;
  for (const std::size_t a : {0u, 1u})
    for (const std::size_t b : {0u, 1u}) {
      const double weight =
          (a == 0 ? 1.0 - i.fraction : i.fraction) * (b == 0 ? 1.0 - j.fraction : j.fraction);
      if (weight > 0.0) out.emplace_back((i.cell + a) * y_axis.size() + j.cell + b, weight);
    }
  return out;
}

MatrixXd map_covariance(const std::vector<double>& x_axis, const std::vector<double>& y_axis,
                        const VectorXd& size) {
  constexpr double kLevel = 0.3, kShape = 0.1;    // standard deviations
  constexpr double kReachX = 0.2, kReachY = 0.3;  // over which places go together, of the axes
  const double wide = x_axis.back() - x_axis.front(), high = y_axis.back() - y_axis.front();
  const std::size_t n = y_axis.size();
  MatrixXd out(size.size(), size.size());
  for (Index p = 0; p < size.size(); ++p)
    for (Index q = 0; q < size.size(); ++q) {
      const auto a = static_cast<std::size_t>(p), b = static_cast<std::size_t>(q);
      const double dx = (x_axis[a / n] - x_axis[b / n]) / (kReachX * wide),
                   dy = (y_axis[a % n] - y_axis[b % n]) / (kReachY * high);
      out(p, q) = size(p) * size(q) *
                  (kLevel * kLevel + kShape * kShape * std::exp(-0.5 * (dx * dx + dy * dy)));
    }
  return out;
}

MapFit map_fit(const MatrixXd& rows, const VectorXd& wanted, const std::vector<std::size_t>& block,
               const MatrixXd& prior) {
  constexpr int kRounds = 12;
  constexpr double kFar = 3.0;  // noises at which a row counts half
  const MatrixXd held = inverse_of(prior);
  MapFit out;
  out.value = VectorXd::Zero(rows.cols());
  out.weight = VectorXd::Ones(rows.rows());
  MatrixXd normal;
  double variance = 0.0;
  // The first noise is that of the stated map: too large, and smaller with every round.
  for (int round = 0; round < kRounds; ++round) {
    const VectorXd left = wanted - rows * out.value;
    out.sd = spread_of(left);
    for (Index r = 0; r < left.size(); ++r)
      out.weight(r) = 1.0 / (1.0 + std::pow(left(r) / (kFar * out.sd), 2.0));
    const VectorXd counted = left.cwiseProduct(out.weight.cwiseSqrt());
    variance = out.sd * out.sd * together(counted, block);
    normal = held + rows.transpose() * (out.weight / variance).asDiagonal() * rows;
    out.value =
        normal.ldlt().solve(rows.transpose() * (out.weight / variance).cwiseProduct(wanted));
  }
  out.sd = std::sqrt(variance);
  const MatrixXd open = normal.ldlt().solve(held);
  out.prior_left = open * prior * open.transpose();
  std::map<std::size_t, std::vector<Index>> rows_of;
  for (Index r = 0; r < rows.rows(); ++r) rows_of[block[static_cast<std::size_t>(r)]].push_back(r);
  const VectorXd right = rows.transpose() * (out.weight / variance).cwiseProduct(wanted);
  out.blocks = rows_of.size();
  const auto g = static_cast<double>(out.blocks);
  out.noise = MatrixXd::Zero(rows.cols(), rows.cols());
  for (const auto& [name, left_out] : rows_of) {
    MatrixXd others = normal;
    VectorXd theirs = right;
    for (const Index r : left_out) {
      const double w = out.weight(r) / variance;
      others.noalias() -= w * rows.row(r).transpose() * rows.row(r);
      theirs -= w * wanted(r) * rows.row(r).transpose();
    }
    const VectorXd off = others.ldlt().solve(theirs) - out.value;
    out.noise += (g - 1.0) / g * off * off.transpose();
  }
  return out;
}

VectorXd map_fit_again(const MatrixXd& rows, const VectorXd& wanted, const MatrixXd& prior,
                       const MapFit& like) {
  const VectorXd weight = like.weight / (like.sd * like.sd);
  return (inverse_of(prior) + rows.transpose() * weight.asDiagonal() * rows)
      .ldlt()
      .solve(rows.transpose() * weight.cwiseProduct(wanted));
}

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Found map_factor(std::string name, const VectorXd& weights, const MapSolved& solved) {
  Found f = found_of(std::move(name), "1", 1.0);
  set_found(f, 1.0 + weights.dot(solved.fit.value), static_cast<double>(solved.fit.blocks) - 2.0,
            std::sqrt(weights.dot(solved.fit.noise * weights)),
            std::sqrt(weights.dot((solved.fit.prior_left + solved.granted) * weights)));
  return f;
}

PlaceFinder::PlaceFinder(const vehicle::Map2& stated, const MapSolved& solved, std::size_t counts,
                         FoundMap& out)
    : out_(out), from_(stated.z.size()) {
  out.x = stated.x;
  out.y = stated.y;
  for (std::size_t k = 0; k < stated.z.size(); ++k) {
    const Found f =
        map_factor({}, VectorXd::Unit(solved.fit.value.size(), static_cast<Index>(k)), solved);
    out.places.push_back({stated.x[k / stated.y.size()],
                          stated.y[k % stated.y.size()],
                          stated.z[k] + solved.fit.value(static_cast<Index>(k)),
                          f.sd,
                          f.within,
                          stated.z[k],
                          std::vector<double>(counts),
                          {}});
  }
}

void PlaceFinder::near(double x, double y, std::size_t count, double seconds, std::size_t block) {
  for (const auto& [place, weight] : map_weights(out_.x, out_.y, x, y)) {
    out_.places[place].seconds[count] += weight * seconds;
    if (weight > 0.2) from_[place].insert(block);
  }
}

void PlaceFinder::hide(double least, const char* of, const char* unit) {
  for (std::size_t k = 0; k < out_.places.size(); ++k) {
    MapPlace& place = out_.places[k];
    const double all = std::accumulate(place.seconds.begin(), place.seconds.end(), 0.0);
    if (all < 1.0 || from_[k].size() < 2)
      place.unseen =
          fmt::format("{:.1f} s {}near it, at {} places of the road", all, of, from_[k].size());
    else if (place.within > 0.1 * std::max(std::abs(place.value), least))
      place.unseen =
          fmt::format("its 90 % interval would be {:.2g}{} either way", place.within, unit);
  }
}

}  // namespace identify
