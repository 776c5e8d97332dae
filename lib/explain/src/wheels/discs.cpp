#include "explain/discs.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/interval90.h"
#include "base/random.h"
#include "disc_temperature.h"
#include "mechanism.h"
#include "not_known.h"
#include "selection.h"
#include "vehicle/laws/disc_heat.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double kStep_s = kDiscStep_s, kSample_s = 0.5;
using Amounts = DiscAmounts;
constexpr std::size_t kAmounts = kDiscAmounts;
constexpr std::array<double, kAmounts> kWidth{0.1, 0.2, 0.2, 0.3, 0.5, 0.5, 2.0, 2.0, 2.0};

/// Each axle has amounts of its own; rows are means over kSample_s.
struct Problem {
  const std::vector<Stop>* stops;
  const vehicle::Vehicle* car;
  VectorXd residual(const std::array<Amounts, 2>& a) const {
    std::vector<double> r;
    const auto every = static_cast<std::size_t>(std::lround(kSample_s / kStep_s));
    for (const Stop& s : *stops) {
      const std::vector<double> t = disc_temperature(s, *car, a[s.axle]);
      for (std::size_t i = every / 2; i < t.size(); i += every)
        r.push_back(std::isfinite(s.disc_k[i]) && std::isfinite(t[i]) ? s.disc_k[i] - t[i] : 0.0);
    }
    return Eigen::Map<VectorXd>(r.data(), static_cast<Index>(r.size()));
  }
  std::vector<std::pair<int, int>> lap_and_block() const {
    std::vector<std::pair<int, int>> out;
    const auto every = static_cast<std::size_t>(std::lround(kSample_s / kStep_s));
    for (const Stop& s : *stops)
      for (std::size_t i = every / 2; i < s.disc_k.size(); i += every)
        out.emplace_back(
            s.lap[i],
            static_cast<int>(s.log * 100000 +
                             static_cast<std::size_t>(static_cast<double>(i) * kStep_s / 20.0)));
    return out;
  }
};

struct Fit {
  std::array<Amounts, 2> a{};
  VectorXd e;
  MatrixXd x;  ///< whitened by sigma
  double sigma = 1.0, loss = 0.0;
  Eigen::LDLT<MatrixXd> normal;
};

/// Refits the six common amounts of both axles and `also`, one amount that both axles share.
Fit fit(const Problem& problem, std::size_t also, double sigma, const VectorXd& weight) {
  Fit f;
  f.sigma = sigma;
  const bool more = also < kAmounts;
  const Index columns = 12 + (more ? 1 : 0);
  const auto at = [&](const VectorXd& b) {
    std::array<Amounts, 2> a{};
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t j = 0; j < 6; ++j) a[k][j] = b[static_cast<Index>(k * 6 + j)];
      if (more) a[k][also] = b[12];
    }
    return a;
  };
  VectorXd b = VectorXd::Zero(columns), precision(columns);
  for (Index j = 0; j < columns; ++j) {
    const double width = j < 12 ? kWidth[static_cast<std::size_t>(j) % 6] : kWidth[also];
    precision[j] = 1 / (width * width);
  }
  for (int round = 0; round < 8; ++round) {
    const VectorXd r = problem.residual(at(b));
    MatrixXd x(r.size(), columns);
    for (Index j = 0; j < columns; ++j) {
      VectorXd moved = b;
      constexpr double kMove = 0.02;
      moved[j] += kMove;
      x.col(j) = weight.cwiseProduct(r - problem.residual(at(moved))) / (kMove * sigma);
    }
    const VectorXd target = weight.cwiseProduct(r) / sigma;
    MatrixXd normal = x.transpose() * x;
    normal.diagonal() += precision;
    f.normal.compute(normal);
    const VectorXd step = f.normal.solve(x.transpose() * target - precision.cwiseProduct(b));
    const auto loss_at = [&](const VectorXd& where) {
      return weight.cwiseProduct(problem.residual(at(where))).squaredNorm() / (sigma * sigma) +
             precision.dot(where.cwiseAbs2());
    };
    const double now = target.squaredNorm() + precision.dot(b.cwiseAbs2());
    double share = std::min(1.0, 0.7 / std::max(1e-12, step.cwiseAbs().maxCoeff()));
    while (share > 0.01 && loss_at(b + share * step) > now) share *= 0.4;
    if (share > 0.01) b += share * step;
    f.x = x;
  }
  f.a = at(b);
  f.e = problem.residual(f.a);
  f.loss = weight.cwiseProduct(f.e).squaredNorm() / (sigma * sigma) + precision.dot(b.cwiseAbs2());
  return f;
}

/// What the two axles' discs did in log `k`; without temperatures where the log has none.
std::array<Stop, 2> stops_of(const RecordedLog& log, std::size_t k, const Mapping& mapping,
                             int first_lap) {
  const recording::Recording recording =
      recording::make_recording(*log.table, log.signals->name, mapping);
  const std::vector<double>& time = *recording.table.find("time_s");
  const Signals& signals = *log.signals;
  std::array<Stop, 2> axles;
  for (std::size_t axle = 0; axle < 2; ++axle) {
    const auto *left = recording.table.find(axle == 0 ? "brake_disc_fl_k" : "brake_disc_rl_k"),
               *right = recording.table.find(axle == 0 ? "brake_disc_fr_k" : "brake_disc_rr_k");
    Stop& s = axles[axle];
    s.axle = axle;
    s.log = k;
    std::size_t row = 0;
    for (std::size_t i = 0; i < signals.n; ++i) {
      const double t = time.front() + kStep_s * static_cast<double>(i);
      while (row + 1 < time.size() && time[row + 1] <= t + 1e-9) ++row;
      if (left != nullptr && right != nullptr)
        s.disc_k.push_back(std::abs(time[row] - t) < 1.0 ? 0.5 * ((*left)[row] + (*right)[row])
                                                         : kNaN);
      s.speed_mps.push_back(signals.x[kVx][i]);
      s.pressure_pa.push_back(signals.x[axle == 0 ? kBrakeFront : kBrakeRear].empty()
                                  ? kNaN
                                  : signals.x[axle == 0 ? kBrakeFront : kBrakeRear][i]);
      s.lap.push_back(first_lap + signals.lap[i]);
    }
  }
  return axles;
}

/// The stops of all logs. A sentence when they do not say enough.
std::string all_stops(const std::vector<RecordedLog>& logs, const Mapping& mapping,
                      const vehicle::Vehicle& car, std::vector<Stop>& stops) {
  int first_lap = 0;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const Signals& signals = *logs[k].signals;
    std::array<Stop, 2> axles = stops_of(logs[k], k, mapping, first_lap);
    const std::vector<double> pad_heat_j = disc_pad_heat(axles, car);
    for (Stop& s : axles) {
      if (s.disc_k.empty()) continue;
      s.pad_heat_j = pad_heat_j;
      stops.push_back(std::move(s));
    }
    first_lap += signals.lap.empty() ? 1 : signals.lap.back() + 1;
    if (!signals.present[kBrakeFront]) return "no brake pressure in the log";
  }
  if (stops.empty()) return "no disc temperatures in the log";
  double seconds = 0;
  for (const Stop& s : stops) seconds += static_cast<double>(s.disc_k.size()) * kStep_s;
  if (seconds < 60) return "less than 60 s of disc temperatures";
  if (car.terms[vehicle::Term::brake_heating] == 0.0 ||
      car.terms[vehicle::Term::brake_conduction] == 0.0)
    return "the stated car's discs take up no heat";
  return "";
}

/// The refit without the alternatives, and with each: slope, emissivity, slope of the capacity.
struct Fits {
  Fit before;
  std::array<Fit, 3> rival;
  std::size_t best = 0;
  double gain(std::size_t k) const { return before.loss - rival[k].loss; }
};

Fits fits_of(const Problem& problem, const VectorXd& ones) {
  Fits fits;
  auto& [before, rival, best] = fits;
  before = fit(problem, kAmounts, 5.0, ones);
  before =
      fit(problem, kAmounts,
          std::max(0.5, std::sqrt(before.e.squaredNorm() / static_cast<double>(before.e.size()))),
          ones);
  for (std::size_t k = 0; k < 3; ++k) {
    rival[k] = fit(problem, kRise + k, before.sigma, ones);
    if (rival[k].loss < rival[best].loss) best = k;
  }
  return fits;
}

using LapsAndBlocks = std::vector<std::pair<int, int>>;

/// How many of 1000 turnings of blocks reach the score of the column: what the refit leaves is not
/// white.
int turns_above(const Fit& before, const VectorXd& beyond, const LapsAndBlocks& places) {
  std::vector<std::pair<int, double>> parts;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double add = beyond[static_cast<Index>(i)] * before.e[static_cast<Index>(i)];
    if (parts.empty() || parts.back().first != places[i].second)
      parts.emplace_back(places[i].second, 0.0);
    parts.back().second += add;
  }
  double here = 0;
  for (const auto& part : parts) here += part.second;
  base::Random dice(909);
  int above = 0;
  for (int draw = 0; draw < 1000; ++draw) {
    double sum = 0;
    for (const auto& part : parts) sum += dice.uniform() < 0.5 ? part.second : -part.second;
    above += std::abs(sum) >= std::abs(here) ? 1 : 0;
  }
  return above;
}

/// What laps that are left out in turn say.
struct LapsOut {
  double before2 = 0, after2 = 0, n = 0;
  std::vector<double> drops;
  int better = 0, judged = 0;
};

LapsOut leave_laps_out(const Problem& problem, const LapsAndBlocks& places, double sigma,
                       const VectorXd& ones) {
  LapsOut out;
  int last_lap = 0;
  for (const auto& [lap, block] : places) last_lap = std::max(last_lap, lap);
  for (int lap = 0; lap <= last_lap; ++lap) {
    VectorXd weight = ones;
    Index count = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      if (places[i].first == lap) weight[static_cast<Index>(i)] = 0, ++count;
    if (count < 20 || count + 20 > weight.size()) continue;
    const VectorXd left = ones - weight;
    const double b2 = fit(problem, kAmounts, sigma, weight).e.cwiseProduct(left).squaredNorm(),
                 a2 = fit(problem, kRise, sigma, weight).e.cwiseProduct(left).squaredNorm();
    out.before2 += b2, out.after2 += a2, out.n += static_cast<double>(count);
    out.drops.push_back(1 - std::sqrt(a2 / std::max(1e-12, b2)));
    ++out.judged;
    out.better += a2 < b2 ? 1 : 0;
  }
  std::sort(out.drops.begin(), out.drops.end());
  return out;
}

/// The deviation that blocks of 20 s show: samples of 0.5 s are not independent.
double spread_of(const Fit& f, const VectorXd& beyond, const LapsAndBlocks& places) {
  double pulled = 0, energy = beyond.squaredNorm();
  for (std::size_t i = 0; i < places.size();) {
    double sum = 0;
    const int block = places[i].second;
    for (; i < places.size() && places[i].second == block; ++i)
      sum += beyond[static_cast<Index>(i)] * f.e[static_cast<Index>(i)] / f.sigma;
    pulled += sum * sum;
  }
  return energy > 0 ? std::sqrt(pulled) / energy : 0.0;
}

/// Squared deviation of the temperatures from their mean.
double trivial_squares(const std::vector<Stop>& stops) {
  double trivial2 = 0;
  for (const Stop& s : stops) {
    double mean = 0, c = 0;
    for (const double t : s.disc_k)
      if (std::isfinite(t)) mean += t, c += 1;
    for (const double t : s.disc_k)
      if (std::isfinite(t)) trivial2 += (t - mean / c) * (t - mean / c) * kStep_s / kSample_s;
  }
  return trivial2;
}

void put_parameters(const vehicle::Vehicle& car, const Fit& f, double spread, Finding& found) {
  const double amount = f.a[0][kRise];
  const double whole = amount + vehicle::laws::kConductanceReference_k *
                                    car.parameters[P::brake_conductance_slope_1pk];
  found.parameters.push_back({"slope of the conductance k", "1", whole,
                              whole - base::kNormal90 * spread, whole + base::kNormal90 * spread});
  for (std::size_t axle = 0; axle < 2; ++axle) {
    const double g = car.parameters.axle(axle, P::front_disc_conductance_wpk) *
                     std::exp(f.a[axle][kConductance]);
    found.parameters.push_back(
        {axle == 0 ? "front.disc_conductance_wpk" : "rear.disc_conductance_wpk", "W/K", g, g, g});
  }
}

}  // namespace

void add_discs(Findings& findings, const std::vector<RecordedLog>& logs, const Mapping& mapping,
               const vehicle::Vehicle& car) {
  forget_untestable(findings, kBrakeDiscConductance);
  const auto cannot = [&](const std::string& reason) {
    findings.untestable.push_back({kBrakeDiscConductance, reason});
  };
  std::vector<Stop> stops;
  if (const std::string reason = all_stops(logs, mapping, car, stops); !reason.empty())
    return cannot(reason);

  const Problem problem{&stops, &car};
  const auto places = problem.lap_and_block();
  const VectorXd ones = VectorXd::Ones(static_cast<Index>(places.size()));
  const Fits fits = fits_of(problem, ones);
  static constexpr const char* kName[]{kBrakeDiscConductance, "emissivity of the discs",
                                       "slope of their heat capacity"};
  const Fit &before = fits.before, &f = fits.rival[0];
  const VectorXd column = f.x.col(12),
                 beyond = column - before.x * before.normal.solve(before.x.transpose() * column);
  const int above = turns_above(before, beyond, places);
  const LapsOut laps = leave_laps_out(problem, places, before.sigma, ones);
  const double amount = f.a[0][kRise], spread = spread_of(f, beyond, places);
  findings.evidence.push_back(
      {kBrakeDiscConductance, "", "slope of the conductance over temperature", amount,
       std::sqrt(std::max(0.0, fits.gain(0))), laps.before2 - laps.after2, "1"});
  if (laps.judged < 2 || above > selection::kMostTurns ||
      laps.better < selection::kBetterLaps * laps.judged ||
      std::abs(amount) < selection::kLeastSlope ||
      fits.gain(fits.best) - fits.gain(0) >
          std::max(selection::kLead, selection::kInexact * fits.gain(fits.best)))
    return;
  Finding found = finding_of(*find_mechanism(kBrakeDiscConductance));
  put_parameters(car, f, spread, found);
  for (std::size_t k = 1; k < 3; ++k)
    found.rivals.push_back(
        {kName[k], "",
         "let the hot car stand: without speed the discs cool by radiation and conduction alone",
         fits.gain(k),
         fits.gain(0) - fits.gain(k) >
             std::max(selection::kLead, selection::kInexact * fits.gain(0))});
  found.statistic = std::copysign(std::sqrt(std::max(0.0, fits.gain(0))), amount);
  found.cv_gain = (laps.before2 - laps.after2) / (before.sigma * before.sigma);
  found.stability = static_cast<double>(laps.better) / laps.judged;
  HeldOut h{"brake_disc_k",
            "K",
            0.0,
            std::sqrt(laps.before2 / laps.n),
            std::sqrt(laps.after2 / laps.n),
            laps.drops.front(),
            laps.drops.back(),
            std::sqrt(trivial_squares(stops) / laps.n)};
  found.held_out.push_back(h);
  findings.findings.push_back(found);
}

}  // namespace explain
