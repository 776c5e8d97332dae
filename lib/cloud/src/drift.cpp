#include "drift.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "height_cells.h"
#include "road/parallel.h"

namespace cloud {
namespace {

constexpr int kRounds = 12;
constexpr int kBankings = 14;  // of the base, each over 5 m of the 70 m that a section sees
constexpr std::size_t kAroundBanking = 7;  // sections whose view reaches into a wrong banking
constexpr double kGradientReach_m = 0.25;
constexpr double kSharedErrors =
    3.0;  // sections in a row see the same road: so many share an error of the base

/// One number that a section's fit gives: row * correction (of its group) = value.
struct Observation {
  int group = 0;                           ///< 0: z, roll, pitch; 1: x, y, yaw
  int kind = 0;                            ///< 0 height, 1 roll, 2 pitch, 3 along, 4 across, 5 yaw
  std::ptrdiff_t section = 0, other = -1;  ///< other: the value is the difference to this section
  Eigen::Vector3d row = Eigen::Vector3d::Zero(), other_row = Eigen::Vector3d::Zero();
  double value = 0.0, variance = 0.0;  ///< of the fit alone
  double weight = 1.0;
};

/// Entries of a correction that belong to a group.
constexpr int kGroup[2][3] = {{2, 3, 4}, {0, 1, 5}};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A cell of a section against the reference: height difference and how it answers to a correction.
struct Row {
  Eigen::Matrix<double, 6, 1> jacobian;
  double residual = 0.0, weight = 0.0;
  double v_m = 0.0;  ///< of the cell
  int banking = 0;   ///< which stretch of the road it lies on
};

using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct Fit {
  Correction change = Correction::Zero();  ///< with the ridge
  Correction data_change =
      Correction::Zero();                 ///< what the cells alone say, for directions they fix
  Matrix6 information = Matrix6::Zero();  ///< of the cells alone
  Correction ridge = Correction::Zero();
  double rms_m = 0.0;
  std::size_t cells = 0;
};

/// Makes variances of open directions large, not infinite.
Correction weak_ridge() {
  Correction ridge;
  ridge << 1, 1, 1, 1e2, 1e2, 1e2;
  return ridge;
}

constexpr double kWideScales[] = {0.3, 0.15, 0.08, 0.04, 0.02, 0.015, 0.012},
                 kNarrowScales[] = {0.04, 0.02, 0.015, 0.012};

/// Robust fit of a correction, starting wide or narrow; Tukey's biweight. With N > 6 the base's
/// cross slope is unknown, too, stretch by stretch: it turns about the road's middle.
template <int N>
Fit fit_rows(const std::vector<Row>& rows, bool first, bool wide) {
  Fit fit;
  fit.cells = rows.size();
  if (rows.size() < 50) return fit;
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  // How well the plan is known beforehand: the drift at first, then the spline through all
  // sections. A road hardly fixes it over one section, and on a grade an error of the plan would be
  // one of the height.
  const double plan = first ? 0.1 : 0.02, yaw = first ? 0.005 : 0.0005;
  fit.ridge << 1 / (plan * plan), 1 / (plan * plan), 1 / 0.25, 1 / 1e-4, 1 / 1e-4, 1 / (yaw * yaw);
  Vector ridge = Vector::Constant(1 / (0.05 * 0.05)), change = Vector::Zero(), b;
  ridge.template head<6>() = fit.ridge;
  Matrix h;
  double unit_variance = 1.0;  // the cells' own scatter against what their weights assume
  const std::span<const double> scales =
      wide ? std::span<const double>(kWideScales) : std::span<const double>(kNarrowScales);
  for (const double scale : scales) {
    h.setZero(), b.setZero();
    double sum = 0.0, weights = 0.0, chi2 = 0.0;
    for (const Row& row : rows) {
      double r = row.residual + row.jacobian.dot(change.template head<6>());
      if constexpr (N > 6) r -= change[6 + row.banking] * row.v_m;
      const double t = r / scale;
      if (std::abs(t) >= 1.0) continue;
      const double robust = (1.0 - t * t) * (1.0 - t * t), w = row.weight * robust;
      h.template topLeftCorner<6, 6>().noalias() += w * row.jacobian * row.jacobian.transpose();
      b.template head<6>().noalias() -= w * row.residual * row.jacobian;
      if constexpr (N > 6) {
        const int k = 6 + row.banking;
        h.col(k).template head<6>() -= w * row.v_m * row.jacobian;
        h(k, k) += w * row.v_m * row.v_m;
        b[k] += w * row.residual * row.v_m;
      }
      sum += robust * r * r, weights += robust, chi2 += w * r * r;
    }
    if constexpr (N > 6)
      h.template bottomLeftCorner<N - 6, 6>() = h.template topRightCorner<6, N - 6>().transpose();
    const Matrix with_ridge = h + Matrix(ridge.asDiagonal());
    change = with_ridge.ldlt().solve(b);
    fit.rms_m = weights > 0.0 ? std::sqrt(sum / weights) : 0.0;
    unit_variance = weights > 0.0 ? std::clamp(chi2 / weights, 0.05, 20.0) : 1.0;
  }
  // What the bankings leave of the information on the six.
  fit.change = change.template head<6>();
  fit.information = h.template topLeftCorner<6, 6>();
  Correction right = b.template head<6>();
  if constexpr (N > 6) {
    Eigen::Matrix<double, N - 6, N - 6> inner = h.template bottomRightCorner<N - 6, N - 6>();
    inner.diagonal() += ridge.template tail<N - 6>();
    const Eigen::Matrix<double, 6, N - 6> gain =
        h.template topRightCorner<6, N - 6>() * inner.inverse();
    fit.information -= gain * h.template bottomLeftCorner<N - 6, 6>();
    right -= gain * b.template tail<N - 6>();
  }
  fit.information /= unit_variance, right /= unit_variance;
  Matrix6 alone = fit.information;
  alone.diagonal() += weak_ridge();
  fit.data_change = alone.ldlt().solve(right);
  return fit;
}

/// The numbers of a fit, as observations of the correction itself.
void observe(const Section& section, std::ptrdiff_t index, std::ptrdiff_t other,
             const Section* other_section, const Correction& now, const Correction& other_now,
             const Fit& fit, const Fit* roll_fit, std::vector<Observation>& out) {
  if (fit.cells < 50) return;
  Matrix6 with_plan = fit.information, alone = fit.information;
  with_plan.diagonal() += fit.ridge;
  alone.diagonal() += weak_ridge();
  // Heights lean on the plan of all sections; the plan must not lean on itself.
  const Matrix6 covariances[2] = {with_plan.inverse(), alone.inverse()};
  const Correction* const changes[2] = {&fit.change, &fit.data_change};
  const double c = std::cos(section.heading_rad), s = std::sin(section.heading_rad);
  const auto add = [&](int group, int kind, const Eigen::Vector3d& row,
                       const Eigen::Vector3d& other_row) {
    Correction full = Correction::Zero();
    Eigen::Vector3d here, there;
    for (int k = 0; k < 3; ++k)
      full[kGroup[group][k]] = row[k],
      here[k] = now[kGroup[group][k]] + (*changes[group])[kGroup[group][k]],
      there[k] = other_now[kGroup[group][k]];
    Observation o;
    o.group = group, o.kind = kind, o.section = index, o.other = other, o.row = row,
    o.other_row = other_row;
    o.value = row.dot(here) - (other >= 0 ? other_row.dot(there) : 0.0);
    o.variance = full.dot(covariances[group] * full);
    const double largest = kind == 0 ? 0.02 : kind == 3 || kind == 4 ? 0.1 : 0.005;
    if (o.variance < largest * largest) out.push_back(o);
  };
  // Heights are taken where the road's middle is: a wrong banking of the base turns about it.
  add(0, 0, {1.0, -section.v_m, 0.0}, {1.0, other_section ? -other_section->v_m : 0.0, 0.0});
  if (roll_fit == nullptr) add(0, 1, Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitY());
  add(0, 2, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ());
  add(1, 3, {c, s, 0.0}, {c, s, 0.0});
  add(1, 4, {-s, c, 0.0}, {-s, c, 0.0});
  add(1, 5, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ());
  if (roll_fit == nullptr) return;
  std::vector<Observation> all;
  observe(section, index, other, other_section, now, other_now, *roll_fit, nullptr, all);
  for (const Observation& o : all)
    if (o.kind == 1) out.push_back(o);
}

using SparseMatrix = Eigen::SparseMatrix<double>;

/// The spline of one group through its observations. Unknowns: 3 per section.
class Spline {
 public:
  Spline(const Sections& sections, int group, const MapOptions& options)
      : sections_(sections), group_(group) {
    const double h = kSectionLength_m;
    for (int k = 0; k < 3; ++k) {
      // Slopes averaged over 50 m by a raised cosine: an rms change of 1 over 100 m is a slope of
      // 1/53 per m whose own slope is 0.073 of it per m.
      const double slope =
          (kGroup[group][k] < 3 ? options.drift_m_per_100m : options.drift_rad_per_100m) / 53.0;
      first_[k] = slope * h;
      second_[k] = 0.073 * slope * h * h;
    }
  }

  /// With the weights as they are. `stddev` gets the posterior where wanted.
  Eigen::VectorXd solve(const std::vector<Observation>& observations,
                        const std::array<double, 6>& trust, std::vector<Correction>* stddev) const {
    const auto n = static_cast<std::ptrdiff_t>(sections_.list.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * n);
    const auto penalise = [&](std::initializer_list<std::pair<std::ptrdiff_t, double>> terms, int k,
                              double sigma) {
      for (const auto& [i, a] : terms)
        for (const auto& [j, b] : terms)
          entries.emplace_back(3 * i + k, 3 * j + k, a * b / (sigma * sigma));
    };
    for (std::ptrdiff_t i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) {
        entries.emplace_back(3 * i + k, 3 * i + k,
                             kGroup[group_][k] < 3 ? 0.1 : 1e3);  // 3 m, 30 mrad
        const auto together = [&](std::ptrdiff_t a) {
          return a < n && sections_.list[static_cast<std::size_t>(a)].piece ==
                              sections_.list[static_cast<std::size_t>(i)].piece;
        };
        if (together(i + 1)) penalise({{i, -1.0}, {i + 1, 1.0}}, k, first_[k]);
        if (together(i + 2)) penalise({{i, 1.0}, {i + 1, -2.0}, {i + 2, 1.0}}, k, second_[k]);
      }
    for (const Observation& o : observations) {
      if (o.group != group_ || o.weight < 1e-6) continue;
      const double w = o.weight / (o.variance + trust[static_cast<std::size_t>(o.kind)] *
                                                    trust[static_cast<std::size_t>(o.kind)]);
      for (int a = 0; a < 3; ++a) {
        right[3 * o.section + a] += w * o.row[a] * o.value;
        if (o.other >= 0) right[3 * o.other + a] -= w * o.other_row[a] * o.value;
        for (int b = 0; b < 3; ++b) {
          entries.emplace_back(3 * o.section + a, 3 * o.section + b, w * o.row[a] * o.row[b]);
          if (o.other < 0) continue;
          entries.emplace_back(3 * o.other + a, 3 * o.other + b,
                               w * o.other_row[a] * o.other_row[b]);
          entries.emplace_back(3 * o.section + a, 3 * o.other + b, -w * o.row[a] * o.other_row[b]);
          entries.emplace_back(3 * o.other + a, 3 * o.section + b, -w * o.other_row[a] * o.row[b]);
        }
      }
    }
    SparseMatrix matrix(3 * n, 3 * n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<SparseMatrix> solver(matrix);
    if (stddev != nullptr)
      for (std::ptrdiff_t i = 0; i < 3 * n; ++i) {
        Eigen::VectorXd unit = Eigen::VectorXd::Zero(3 * n);
        unit[i] = 1.0;
        (*stddev)[static_cast<std::size_t>(i / 3)][kGroup[group_][i % 3]] =
            std::sqrt(kSharedErrors * std::max(0.0, solver.solve(unit)[i]));
      }
    return solver.solve(right);
  }

 private:
  const Sections& sections_;
  int group_;
  double second_[3], first_[3];
};

double residual_of(const Observation& o, const Eigen::VectorXd& x) {
  double r = o.row.dot(x.segment<3>(3 * o.section)) - o.value;
  if (o.other >= 0) r -= o.other_row.dot(x.segment<3>(3 * o.other));
  return r;
}

/// Height differences of a section's cells to the base, and with `pass` to the cells of that pass.
void rows_of(const Sections& sections, std::size_t index,
             const std::vector<Correction>& corrections, const RoadFrame& frame,
             const HeightCells* pass, const WrongPlaces* wrong, std::vector<Row>& rows) {
  rows.clear();
  const Section& section = sections.list[index];
  const Mover move(sections, corrections, index);
  const double c = std::cos(section.heading_rad), s = std::sin(section.heading_rad);
  for (const SectionCell& cell : section.cells) {
    const Eigen::Vector3d p = move(cell);
    const std::optional<GridPlace> place = frame.project(p.x(), p.y(), section.row);
    if (!place || (wrong != nullptr && wrong->contains(*place))) continue;
    double base = frame.height(*place);
    const Eigen::Vector2d g = frame.gradient(*place, kGradientReach_m);
    if (pass != nullptr) base += pass->at(*place);
    if (!std::isfinite(base) || !g.allFinite() || g.norm() > 0.5) continue;
    Row row;
    const Eigen::Vector3d normal(-g.x(), -g.y(), 1.0),
        arm = p - section.position_m - corrections[index].head<3>();
    const Eigen::Vector3d moment = arm.cross(normal);
    row.jacobian << normal, c * moment.x() + s * moment.y(), -s * moment.x() + c * moment.y(),
        moment.z();
    row.residual = p.z() - frame.z_origin_m() - base;
    const double n = static_cast<double>(cell.points);
    row.v_m = place->v_m;
    double ahead = place->row - section.row;
    if (frame.closed())
      ahead -= static_cast<double>(frame.rows() - 1) *
               std::round(ahead / static_cast<double>(frame.rows() - 1));
    row.banking =
        std::clamp(static_cast<int>((ahead * frame.u_step_m() + 35.0) / 5.0), 0, kBankings - 1);
    row.weight = 1.0 / (0.004 * 0.004 / n + 0.0015 * 0.0015);
    rows.push_back(row);
  }
}

struct RoundResult {
  std::vector<Observation> observations;
  std::vector<double> base_rms, pass_rms;
};

RoundResult observe_all(const Sections& sections, const RoadFrame& frame,
                        const std::vector<Correction>& now, const std::vector<bool>& banking_open,
                        const WrongPlaces& wrong, const MapOptions& options, bool first) {
  const std::size_t n = sections.list.size();
  int passes = 0;
  for (const Section& section : sections.list) passes = std::max(passes, section.pass + 1);
  std::vector<HeightCells> cells;  // of each pass but the last, which nobody looks at
  for (int pass = 0; pass + 1 < passes; ++pass)
    cells.push_back(cells_of(sections, now, frame, pass, options.threads));
  std::vector<std::vector<Observation>> found(n);
  std::vector<double> base_rms(n, -1.0), pass_rms(n, -1.0);
  road::parallel_for(n, 1, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Row> rows;
    for (std::size_t i = begin; i < end; ++i) {
      const Section& section = sections.list[i];
      if (!section.has_data()) continue;
      if (options.trust_base) {
        rows_of(sections, i, now, frame, nullptr, &wrong, rows);
        const Fit fit = fit_rows<6>(rows, first, first);
        if (banking_open[i])
          observe(section, static_cast<std::ptrdiff_t>(i), -1, nullptr, now[i], now[i],
                  fit_rows<6 + kBankings>(rows, first, true), &fit, found[i]);
        else
          observe(section, static_cast<std::ptrdiff_t>(i), -1, nullptr, now[i], now[i], fit,
                  nullptr, found[i]);
        if (fit.cells >= 50) base_rms[i] = fit.rms_m;
      }
      if (section.pass == 0) continue;
      // The section of the pass before that drove nearest to here.
      std::ptrdiff_t other = -1;
      double nearest = 1.5 * kSectionLength_m / frame.u_step_m();
      for (std::size_t k = 0; k < n; ++k) {
        double d = sections.list[k].row - section.row;
        if (frame.closed())
          d -= static_cast<double>(frame.rows() - 1) *
               std::round(d / static_cast<double>(frame.rows() - 1));
        if (sections.list[k].pass == section.pass - 1 && sections.list[k].has_data() &&
            std::abs(d) < nearest)
          nearest = std::abs(d), other = static_cast<std::ptrdiff_t>(k);
      }
      if (other < 0) continue;
      rows_of(sections, i, now, frame, &cells[static_cast<std::size_t>(section.pass - 1)], nullptr,
              rows);
      const Fit fit = fit_rows<6>(rows, first, first);
      observe(section, static_cast<std::ptrdiff_t>(i), other,
              &sections.list[static_cast<std::size_t>(other)], now[i],
              now[static_cast<std::size_t>(other)], fit, nullptr, found[i]);
      if (fit.cells >= 50) pass_rms[i] = fit.rms_m;
    }
  });
  RoundResult result;
  for (std::size_t i = 0; i < n; ++i) {
    result.observations.insert(result.observations.end(), found[i].begin(), found[i].end());
    if (base_rms[i] >= 0.0) result.base_rms.push_back(base_rms[i]);
    if (pass_rms[i] >= 0.0) result.pass_rms.push_back(pass_rms[i]);
  }
  return result;
}

}  // namespace

Mover::Mover(const Sections& sections, const std::vector<Correction>& corrections,
             std::size_t index)
    : section_(sections.list[index]), here_(corrections[index]) {
  const std::size_t n = sections.list.size();
  const std::size_t before =
      index > 0 && sections.list[index - 1].piece == section_.piece ? index - 1 : index;
  const std::size_t after =
      index + 1 < n && sections.list[index + 1].piece == section_.piece ? index + 1 : index;
  if (after > before)
    slope_ = (corrections[after] - corrections[before]) /
             (sections.centre_m[after] - sections.centre_m[before]);
  turn_ = rotation_of(here_, section_.heading_rad);
  const double c = std::cos(section_.heading_rad), s = std::sin(section_.heading_rad);
  pivot_slope_ =
      section_.ahead - turn_ * section_.ahead;  // each point turns about where it was seen from
  turn_slope_ = {c * slope_[3] - s * slope_[4], s * slope_[3] + c * slope_[4], slope_[5]};
}

Eigen::Vector3d Mover::operator()(const SectionCell& cell) const {
  const Eigen::Vector3d local(static_cast<double>(cell.x_m), static_cast<double>(cell.y_m),
                              static_cast<double>(cell.z_m));
  const Eigen::Vector3d turned = turn_ * local;
  const auto on = static_cast<double>(cell.driven_m);
  return section_.position_m + here_.head<3>() + turned +
         on * (slope_.head<3>() + pivot_slope_ + turn_slope_.cross(turned));
}

Drift estimate_drift(const Sections& sections, const RoadFrame& frame, const MapOptions& options,
                     MapReport& report) {
  const std::size_t n = sections.list.size();
  Drift drift;
  drift.correction.assign(n, Correction::Zero());
  drift.stddev.assign(n, Correction::Zero());
  // How far the base may be wrong over a section, by kind; narrowed to what the spline finds.
  const std::array<double, 6> trust_first = {0.002, 0.0002, 0.0002, 0.02, 0.01, 0.0005},
                              trust_least = {0.0002, 0.00002, 0.00002, 0.002, 0.001, 0.00005};
  std::array<double, 6> trust = trust_first, found = trust_first;
  std::vector<Observation> observations;
  std::vector<bool> banking_open(n, false);
  WrongPlaces wrong;
  for (int round = 0; round < kRounds && !report.converged; ++round) {
    RoundResult seen =
        observe_all(sections, frame, drift.correction, banking_open, wrong, options, round == 0);
    observations = std::move(seen.observations);
    report.iterations = round + 1;
    Eigen::VectorXd x[2];
    for (int group = 0; group < 2; ++group) {
      const Spline spline(sections, group, options);
      // Which numbers to believe is decided with the trust that a base deserves at first: a spline
      // that followed closely would follow a wrong base, too.
      for (double mu = 256.0; mu >= 1.0; mu /= 2.0) {
        x[group] = spline.solve(observations, trust_first, nullptr);
        for (Observation& o : observations) {
          if (o.group != group) continue;
          const double r = residual_of(o, x[group]),
                       t = trust_first[static_cast<std::size_t>(o.kind)];
          const double m2 = r * r / (o.variance + t * t) / 9.0;
          o.weight = mu * mu / ((mu + m2) * (mu + m2));
        }
      }
      // How well the base is right where it is, from what the spline leaves; then, step by step,
      // the same question again with that trust: the fringes of a wrong place are only a little
      // wrong.
      trust = trust_first;
      for (int step = 0; step < 6; ++step) {
        x[group] = spline.solve(observations, trust, nullptr);
        for (std::size_t kind = 0; kind < 6; ++kind) {
          std::vector<double> residuals;
          for (const Observation& o : observations)
            if (o.group == group && static_cast<std::size_t>(o.kind) == kind && o.weight > 0.5)
              residuals.push_back(std::abs(residual_of(o, x[group])));
          if (residuals.size() >= 20)
            trust[kind] =
                std::clamp(1.4826 * 1.5 * median(residuals),
                           std::max(trust_least[kind], 0.6 * trust[kind]), trust_first[kind]);
        }
        for (Observation& o : observations) {
          if (o.group != group) continue;
          const double r = residual_of(o, x[group]), t = trust[static_cast<std::size_t>(o.kind)];
          const double m2 = r * r / (o.variance + t * t) / 9.0;
          o.weight = 1.0 / ((1.0 + m2) * (1.0 + m2));
        }
      }
      for (const int k : {0, 1, 2, 3, 4, 5})
        if ((k >= 3) == (group == 1))
          found[static_cast<std::size_t>(k)] = trust[static_cast<std::size_t>(k)];
      x[group] = spline.solve(observations, trust, nullptr);
    }
    double moved = 0.0, turned = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      Correction next;
      for (int group = 0; group < 2; ++group)
        for (int k = 0; k < 3; ++k)
          next[kGroup[group][k]] = x[group][3 * static_cast<std::ptrdiff_t>(i) + k];
      if (sections.list[i].has_data()) {
        const Correction change = next - drift.correction[i];
        moved = std::max(moved, std::abs(change[2])),
        turned = std::max({turned, std::abs(change[3]), std::abs(change[4])});
      }
      drift.correction[i] = next;
    }
    report.converged = moved < 2e-4 && turned < 2e-5;
    wrong = wrong_places(cells_of(sections, drift.correction, frame, -1, options.threads),
                         options.threads);
    // Where the cross slope of the base is not believed, it is unknown for all who see that place.
    std::fill(banking_open.begin(), banking_open.end(), false);
    for (const Observation& o : observations) {
      if (o.other >= 0 || o.kind != 1 || o.weight > 0.25) continue;
      const auto at = static_cast<std::size_t>(o.section);
      for (std::size_t k = at - std::min(at, kAroundBanking);
           k <= std::min(at + kAroundBanking, n - 1); ++k)
        banking_open[k] = true;
    }
  }
  for (int group = 0; group < 2; ++group)
    Spline(sections, group, options).solve(observations, found, &drift.stddev);

  // The report.
  std::vector<std::array<bool, 6>> trusted(n, {false, false, false, false, false, false});
  double inliers = 0.0, all = 0.0;
  for (const Observation& o : observations) {
    if (o.other >= 0) continue;
    trusted[static_cast<std::size_t>(o.section)][static_cast<std::size_t>(o.kind)] =
        o.weight > 0.25;
    inliers += o.weight > 0.25 ? 1.0 : 0.0, all += 1.0;
  }
  report.inlier_share = all > 0.0 ? inliers / all : 0.0;
  const std::vector<Correction> none(n, Correction::Zero());
  const auto robust_rms = [&](const std::vector<Correction>& at, int pass) {
    std::vector<double> heights;
    std::vector<Row> rows;
    HeightCells cells;
    if (pass > 0) cells = cells_of(sections, at, frame, pass - 1, options.threads);
    for (std::size_t i = 0; i < n; ++i) {
      if (!sections.list[i].has_data() ||
          (pass > 0 ? sections.list[i].pass != pass : !trusted[i][0]))
        continue;
      rows_of(sections, i, at, frame, pass > 0 ? &cells : nullptr, nullptr, rows);
      for (std::size_t k = 0; k < rows.size(); k += 7)
        heights.push_back(std::abs(rows[k].residual));
    }
    return 1.4826 * median(std::move(heights));
  };
  report.rms_before_m = robust_rms(none, 0), report.rms_after_m = robust_rms(drift.correction, 0);
  report.sections = 0, report.passes = 0;
  std::array<std::vector<double>, 6> deviations;
  for (std::size_t i = 0; i < n; ++i) {
    const Section& section = sections.list[i];
    if (!section.has_data()) continue;
    ++report.sections;
    report.passes = std::max(report.passes, static_cast<std::size_t>(section.pass) + 1);
    DriftStation station;
    station.piece = section.piece, station.pass = section.pass;
    station.driven_m = sections.centre_m[i],
    station.u_m = frame.u_begin_m() + section.row * frame.u_step_m();
    for (std::size_t k = 0; k < 6; ++k) {
      const auto e = static_cast<Eigen::Index>(k);
      station.correction[k] = drift.correction[i][e], station.stddev[k] = drift.stddev[i][e];
      deviations[k].push_back(drift.stddev[i][e]);
    }
    station.base_trusted = trusted[i][0], station.banking_trusted = trusted[i][1];
    report.drift.push_back(station);
  }
  if (report.passes > 1)
    report.pass_rms_before_m = robust_rms(none, 1),
    report.pass_rms_after_m = robust_rms(drift.correction, 1);
  const char* const names[] = {"x", "y", "z", "roll", "pitch", "yaw"};
  for (std::size_t k = 0; k < 6; ++k) {
    report.typical_stddev[k] = median(deviations[k]);
    if (report.typical_stddev[k] > (k < 2 ? 0.05 : k == 2 ? 0.02 : 0.005))
      report.unfixed.push_back(names[k]);
  }
  return drift;
}

}  // namespace cloud
