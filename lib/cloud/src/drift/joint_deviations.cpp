// What the residuals tell about the scales, and what the normal equations tell about deviations.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/parallel.h"
#include "base/statistics.h"
#include "joint.h"

namespace cloud {
namespace {

constexpr double kBlock_m = 4.0;
constexpr double kSurelyRoad_m = 1.2;  // to both sides of the sensor: surely road
constexpr std::size_t kEnough = 100;   // cells of it

/// base::median_or of values that are not negative: their bits have the same order, so that those
/// near it are found by counting. 0 of none.
float median_by_bits(std::vector<float>&& values) {
  if (values.empty()) return 0.0f;
  constexpr unsigned kShift = 19;
  const auto bin_of = [](float value) { return std::bit_cast<std::uint32_t>(value) >> kShift; };
  std::array<std::uint32_t, 1u << (32 - kShift)> count{};
  for (const float value : values) ++count[bin_of(value)];
  std::size_t bin = 0, place = values.size() / 2;
  while (place >= count[bin]) place -= count[bin++];
  std::erase_if(values, [&](float value) { return bin_of(value) != bin; });
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

/// What some cells show, to be sorted.
struct JointProblem::Samples {
  enum { cells, lane, views, views_m, residuals, passes, noise, lane_noise, kinds };
  std::array<std::vector<float>, kinds> of;
  std::vector<double> of_cell;  ///< residuals of the cell at hand
  double believed = 0.0, all = 0.0;
  bool for_report = false;  ///< residuals and passes too, which no scale follows

  void add(std::size_t kind, double value) { of[kind].push_back(static_cast<float>(value)); }
  void add(const Samples& other) {
    for (std::size_t k = 0; k < kinds; ++k)
      of[k].insert(of[k].end(), other.of[k].begin(), other.of[k].end());
    believed += other.believed, all += other.all;
  }
};

void JointProblem::sample(std::size_t from, std::size_t to, const std::vector<Correction>& now,
                          const JointScales& scales, Samples& out) const {
  const std::uint32_t cell = views_[order_[from]].cell;
  const CellNodes nodes = nodes_of(cell);
  std::vector<double>& residuals = out.of_cell;
  residuals.clear();
  double sum = 0.0, weights = 0.0;
  double pass_sum[2] = {0.0, 0.0}, pass_weight[2] = {0.0, 0.0};
  int first_pass = -1, second_pass = -1;
  bool driven = false;
  for (std::size_t i = from; i < to; ++i) {
    const View& view = views_[order_[i]];
    const double r = residual_of(view, nodes, now);
    residuals.push_back(r);
    double w = static_cast<double>(view.weight);
    const Section& section = sections_.list[view.section];
    const int pass = section.pass;
    driven |= !section.ahead.isZero() && std::abs(nodes.v_m - section.v_m) < kSurelyRoad_m;
    if (first_pass < 0) first_pass = pass;
    if (pass != first_pass && second_pass < 0) second_pass = pass;
    if (pass == first_pass || pass == second_pass)
      pass_sum[pass == first_pass ? 0 : 1] += w * r, pass_weight[pass == first_pass ? 0 : 1] += w;
    if (weighed_) w *= geman_mcclure(r - static_cast<double>(cells_[cell].height_m), scales.view_m);
    sum += w * r, weights += w;
    if (out.for_report) out.add(Samples::residuals, std::abs(r - common_slope_ * nodes.v_m));
  }
  const double mean = weights > 0.0 ? sum / weights : 0.0, uneven = mean - even_error(cell);
  out.add(Samples::cells, std::abs(uneven));
  if (driven) out.add(Samples::lane, std::abs(uneven));
  if (weights > 0.0) {
    out.add(Samples::noise, 1.0 / std::sqrt(weights));
    if (driven) out.add(Samples::lane_noise, 1.0 / std::sqrt(weights));
  }
  const auto n = static_cast<double>(to - from);
  if (n > 1.0)
    for (std::size_t i = from; i < to; ++i) {
      const View& view = views_[order_[i]];
      // The mean follows its views.
      const double e = std::abs(residuals[i - from] - mean) * std::sqrt(n / (n - 1.0));
      out.add(Samples::views, e * std::sqrt(static_cast<double>(view.weight)));
      out.add(Samples::views_m, e);
    }
  if (second_pass >= 0 && out.for_report)
    out.add(Samples::passes, std::abs(pass_sum[0] / pass_weight[0] - pass_sum[1] / pass_weight[1]));
  out.believed += belief(cells_[cell], uneven, scales) > 0.25 ? 1.0 : 0.0, out.all += 1.0;
}

JointFacts JointProblem::facts(const std::vector<Correction>& now, const JointScales& scales,
                               bool for_report) {
  // A part of the cells is enough for medians.
  const std::size_t every = 1 + order_.size() / 500'000;
  std::vector<Samples> seen(stretches_);
  base::parallel_for(stretches_, 1, options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      std::size_t index = 0;
      seen[s].for_report = for_report;
      each_cell(s, [&](std::size_t from, std::size_t to) {
        if (++index % every == 0) sample(from, to, now, scales, seen[s]);
      });
    }
  });
  Samples all;
  for (const Samples& samples : seen) all.add(samples);
  std::vector<float> heights, slopes;
  for (const Node& node : nodes_)
    if (node.height_m != 0.0)
      heights.push_back(static_cast<float>(std::abs(node.height_m))),
          slopes.push_back(static_cast<float>(std::abs(node.slope - common_slope_)));
  // What lies beside the road, and is not what the base says, must not widen what is believed.
  const bool by_lane = all.of[Samples::lane].size() >= kEnough;
  if (by_lane) all.of[Samples::cells].clear(), all.of[Samples::noise].clear();
  std::array<double, Samples::kinds> median{};
  base::parallel_for(Samples::kinds, 1, options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      median[k] = static_cast<double>(median_by_bits(std::move(all.of[k])));
  });
  constexpr double kOfMad = 1.4826;
  JointFacts facts;
  facts.node_mad_m = kOfMad * static_cast<double>(base::median_or(0.0f, std::move(heights)));
  facts.node_slope_mad = kOfMad * static_cast<double>(base::median_or(0.0f, std::move(slopes)));
  facts.base_mad_m = kOfMad * median[by_lane ? Samples::lane : Samples::cells];
  facts.cell_noise_m = median[by_lane ? Samples::lane_noise : Samples::noise];
  facts.view_mad = kOfMad * median[Samples::views];
  facts.view_mad_m = kOfMad * median[Samples::views_m];
  facts.residual_m = kOfMad * median[Samples::residuals];
  facts.between_passes_m = kOfMad * median[Samples::passes];
  facts.believed = all.all > 0.0 ? all.believed / all.all : 0.0;
  return facts;
}

std::vector<float> JointProblem::heights_at(const std::vector<Correction>& now,
                                            const JointScales& scales) const {
  std::vector<float> heights(cells_.size(), 0.0f);
  // While the poses still move a base damps the steps, and weights that wait for them do so too.
  if (options_.trust_base && !fine_) {
    for (std::size_t k = 0; k < cells_.size(); ++k) heights[k] = cells_[k].height_m;
    return heights;
  }
  base::parallel_for(stretches_, 1, options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      each_cell(s, [&](std::size_t from, std::size_t to) {
        const std::uint32_t cell = views_[order_[from]].cell;
        const CellNodes nodes = nodes_of(cell);
        double sum = 0.0, weights = 0.0;
        for (std::size_t i = from; i < to; ++i) {
          const View& view = views_[order_[i]];
          const double r = residual_of(view, nodes, now);
          const double w =
              static_cast<double>(view.weight) *
              geman_mcclure(r - static_cast<double>(cells_[cell].height_m), scales.view_m);
          sum += w * r, weights += w;
        }
        heights[cell] = weights > 0.0 ? static_cast<float>(sum / weights) : cells_[cell].height_m;
      });
  });
  return heights;
}

namespace {

/// What all cells of a block have in common may be of the poses, which still move by so much when
/// they count as right: many passes hold together and would leave the base for it, round by round.
/// One or two weigh no more than the base.
double of_poses_m2(const Sections& sections) {
  constexpr double kMove_m = 2e-4, kAsTheBase = 2.0;
  double passes = 1.0;
  for (const Section& section : sections.list) passes = std::max(passes, section.pass + 1.0);
  return kMove_m * kMove_m * std::max(0.0, 1.0 - kAsTheBase / passes);
}

}  // namespace

void JointProblem::measure_together(const std::vector<Correction>& now, JointScales& scales) const {
  // Those of the cells are of the step before: what moved since would look like errors in common.
  const std::vector<float> heights = heights_at(now, scales);
  const auto block = static_cast<std::size_t>(kBlock_m / kSectionCell_m + 0.5);
  // Means of blocks against what their cells scatter by.
  const auto ratio = [](double n_mean2, double mean_square, double blocks) {
    return blocks > 10.0 && mean_square > 0.0 ? std::max(1.0, n_mean2 / mean_square) : 1.0;
  };
  const double poses_m2 = of_poses_m2(sections_);
  double n_mean2 = 0.0, square = 0.0, blocks = 0.0;
  for (std::size_t i = 0; i < along_; i += block)
    for (std::size_t j = 0; j < across_; j += block) {
      double n = 0.0, sum = 0.0, sum2 = 0.0;
      for (std::size_t k = i; k < std::min(i + block, along_); ++k)
        for (std::size_t l = j; l < std::min(j + block, across_); ++l) {
          const float height = heights[k * across_ + l];
          const double h = static_cast<double>(height) - even_error(k * across_ + l);
          if (!(std::abs(h) < scales.base_m) || height == 0.0f) continue;
          n += 1.0, sum += h, sum2 += h * h;
        }
      if (n < 0.5 * static_cast<double>(block * block)) continue;
      blocks += 1.0, square += sum2 / n;
      n_mean2 += std::max(0.0, sum * sum / n - n * poses_m2);
    }
  scales.base_together = ratio(n_mean2, square, blocks);

  // Blocks of views of one section: how many, n times the squares of means, mean squares.
  std::vector<std::array<double, 3>> seen(sections_.list.size());
  const std::size_t around = along_ / block + 1, beside = across_ / block + 1;
  base::parallel_for(seen.size(), 16, options_.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<std::array<double, 3>> sums(around * beside);
    std::vector<std::size_t> touched;
    for (std::size_t s = begin; s < end; ++s) {
      touched.clear();
      for (std::size_t k = first_[s]; k < first_[s + 1]; ++k) {
        const View& view = views_[k];
        if (view.cell == View::kNone) continue;
        const double e = (residual_of(view, nodes_of(view.cell), now) -
                          static_cast<double>(heights[view.cell])) *
                         std::sqrt(static_cast<double>(view.weight) / scales.view_factor);
        if (!(std::abs(e) < 3.0)) continue;
        const std::size_t at = view.cell / across_ / block * beside + view.cell % across_ / block;
        if (sums[at][0] == 0.0) touched.push_back(at);
        sums[at][0] += 1.0, sums[at][1] += e, sums[at][2] += e * e;
      }
      for (const std::size_t at : touched) {
        const auto& [n, sum, sum2] = sums[at];
        if (n >= 0.5 * static_cast<double>(block * block))
          seen[s][0] += 1.0, seen[s][1] += sum * sum / n, seen[s][2] += sum2 / n;
        sums[at] = {0.0, 0.0, 0.0};
      }
    }
  });
  n_mean2 = square = blocks = 0.0;
  for (const auto& [count, mean2, of_all] : seen)
    blocks += count, n_mean2 += mean2, square += of_all;
  scales.view_together = ratio(n_mean2, square, blocks);
}

double JointProblem::believed_share(std::size_t section) const {
  double believed = 0.0, all = 0.0;
  for (std::size_t k = first_[section]; k < first_[section + 1]; ++k)
    if (views_[k].cell != View::kNone)
      believed += cells_[views_[k].cell].believed > 0.25f ? 1.0 : 0.0, all += 1.0;
  return all > 0.0 ? believed / all : 0.0;
}

void JointProblem::deviations(double common_slope_stddev, double times, const JointScales& scales,
                              Drift& drift) {
  const std::size_t n = sections_.list.size();
  const Eigen::Index dimension = matrix_.unknowns();
  const int common = static_cast<int>(dimension) - 1;
  std::vector<Eigen::Triplet<double>> entries;
  add_prior(entries);
  add_prior_of_base(scales, entries);
  entries.emplace_back(common, common,
                       1.0 / (common_slope_stddev * common_slope_stddev) - common_weight_);
  matrix_.scale(times);
  factorise(entries);
  common_slope_stddev_ =
      std::sqrt(factor_.covariance(Eigen::VectorXd::Unit(dimension, common)).value());
  drift.stddev.assign(n, Correction::Zero());
  base::parallel_for(n, 4, options_.threads, [&](std::size_t from, std::size_t to) {
    Eigen::MatrixXd unit(dimension, 6);
    for (std::size_t s = from; s < to; ++s) {
      unit.setZero();
      unit.block<6, 6>(static_cast<Eigen::Index>(6 * s), 0).setIdentity();
      drift.stddev[s] = factor_.covariance(unit).diagonal().cwiseSqrt();
    }
  });
  drift.stretch.assign(stretches_, {}), drift.apart.assign(stretches_, {});
  base::parallel_for(stretches_, 1, options_.threads, [&](std::size_t from, std::size_t to) {
    Eigen::MatrixXd functional(dimension, 4);
    for (std::size_t k = from; k < to; ++k) {
      drift.stretch[k] = deviation_of(k, -1, functional);
      PassApart& apart = drift.apart[k];
      apart.pass = pass_left_out(k);
      if (apart.pass >= 0) apart.deviation = deviation_of(k, apart.pass, functional);
    }
  });
}

int JointProblem::pass_left_out(std::size_t stretch) const {
  std::vector<int> passes;
  for (std::size_t i = stretch_begin_[stretch]; i < stretch_begin_[stretch + 1]; ++i) {
    const int pass = sections_.list[views_[order_[i]].section].pass;
    const auto at = std::lower_bound(passes.begin(), passes.end(), pass);
    if (at == passes.end() || *at != pass) passes.insert(at, pass);
  }
  return passes.size() < 2 ? -1 : passes[stretch % passes.size()];
}

StretchDeviation JointProblem::deviation_of(std::size_t stretch, int left_out,
                                            Eigen::MatrixXd& functional) const {
  functional.setZero();  // height, slope across, along, across
  StretchDeviation out;
  double cells = 0.0, sum_v = 0.0, sum_vv = 0.0;
  const auto is_left_out = [&](std::size_t i) {
    return left_out >= 0 && sections_.list[views_[order_[i]].section].pass == left_out;
  };
  const auto each_cell = [&](const auto& what) {
    for (std::size_t i = stretch_begin_[stretch]; i < stretch_begin_[stretch + 1];) {
      std::size_t end = i;
      const std::uint32_t cell = views_[order_[i]].cell;
      double points[] = {0.0, 0.0};  // of the pass that is left out: the second
      for (; end < stretch_begin_[stretch + 1] && views_[order_[end]].cell == cell; ++end)
        points[is_left_out(end) ? 1 : 0] += points_of(order_[end]);
      if (left_out < 0 || (points[0] > 0.0 && points[1] > 0.0))
        what(i, end, nodes_of(cell).v_m, points);
      i = end;
    }
  };
  each_cell([&](std::size_t, std::size_t, double v, const double*) {
    cells += 1.0, sum_v += v, sum_vv += v * v;
  });
  if (cells < 50.0) return out;
  out.v_m = sum_v / cells;
  const double spread = sum_vv - cells * out.v_m * out.v_m;
  const double heading = frame_.heading_rad((static_cast<double>(stretch) + 0.5) *
                                            static_cast<double>(rows_per_stretch_) * cell_rows_);
  const double c = std::cos(heading), s = std::sin(heading);
  each_cell([&](std::size_t begin, std::size_t end, double v, const double* points) {
    for (std::size_t i = begin; i < end; ++i) {
      const View& view = views_[order_[i]];
      const bool other = is_left_out(i);
      const double share = (other ? -1.0 : 1.0) * points_of(order_[i]) / points[other ? 1 : 0];
      const auto at = static_cast<Eigen::Index>(6 * view.section);
      // Slopes of the ground are not part of this: they differ from node to node.
      for (int e = 0; e < 6; ++e) {
        const double j = e < 2 ? 0.0 : static_cast<double>(view.jacobian[e]);
        functional(at + e, 0) += share * j / cells;
        functional(at + e, 1) += share * j * (v - out.v_m) / spread;
      }
      functional(at, 2) += share * c / cells, functional(at + 1, 2) += share * s / cells;
      functional(at, 3) -= share * s / cells, functional(at + 1, 3) += share * c / cells;
    }
  });
  const Eigen::Matrix4d covariance = factor_.covariance(functional);
  out.var_height = covariance(0, 0), out.cov_height_slope = covariance(0, 1);
  out.var_slope = covariance(1, 1);
  out.var_along = covariance(2, 2), out.var_across = covariance(3, 3);
  out.seen = true;
  return out;
}

double JointProblem::points_of(std::uint32_t view) const {
  const std::size_t section = views_[view].section;
  return static_cast<double>(sections_.list[section].cells[view - first_[section]].points);
}

}  // namespace cloud
