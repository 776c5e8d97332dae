#include "rows.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>

#include "base/parallel.h"
#include "led_car.h"

namespace explain {

Rows make_rows(const std::vector<Signals>& logs, const std::vector<Residuals>& at_stated) {
  Rows out;
  int lap0 = 0;
  std::vector<int> half_of;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const Signals& s = logs[k];
    const Regimes g = regimes(s);
    const int block0 = out.blocks;
    for (std::size_t first = 0; first + Rows::kSteps <= s.n; first += Rows::kSteps) {
      for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
        const auto& r = at_stated[k].r[relation];
        std::size_t good = 0;
        for (std::size_t i = first; i < first + Rows::kSteps; ++i)
          good += std::isfinite(r[i]) ? 1 : 0;
        if (good < 4) continue;
        const std::size_t middle = first + Rows::kSteps / 2;
        if (!std::isfinite(s.u_m[middle])) continue;
        Row row;
        row.log = k;
        row.relation = relation;
        row.lap = lap0 + s.lap[middle];
        row.t_s = static_cast<double>(middle) * Signals::kStep_s;
        row.u_m = s.u_m[middle];
        row.block = block0 + static_cast<int>(row.t_s / 3.0);
        row.speed = g.speed[middle];
        row.ax = g.ax[middle];
        row.ay = g.ay[middle];
        if (!s.pressed_swing.empty()) row.pressed_swing = s.pressed_swing[middle];
        row.throttle = g.throttle[middle];
        row.brake = g.brake[middle];
        row.fold = 2 * row.lap + (row.u_m > 0.5 * s.length_m ? 1 : 0);
        out.row.push_back(row);
        out.first_step.push_back(first);
      }
    }
    out.blocks = block0 + static_cast<int>(static_cast<double>(s.n) * Signals::kStep_s / 3.0) + 1;
    lap0 += s.lap.empty() ? 1 : s.lap.back() + 1;
  }
  out.laps = lap0;
  // Folds that hold next to nothing join the one before.
  std::map<int, std::size_t> size;
  for (const Row& row : out.row) ++size[row.fold];
  std::map<int, int> number;
  int next = -1;
  for (const auto& [fold, count] : size) {
    if (next < 0 || count * 20 > out.row.size() / std::max<std::size_t>(1, size.size()) * 4) ++next;
    number[fold] = next;
  }
  for (Row& row : out.row) row.fold = number[row.fold];
  out.folds = next + 1;
  return out;
}

Eigen::VectorXd gather(const Rows& rows, const std::vector<Residuals>& r) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(rows.row.size()));
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    const auto& x = r[rows.row[k].log].r[rows.row[k].relation];
    double sum = 0.0, count = 0.0;
    for (std::size_t i = rows.first_step[k]; i < rows.first_step[k] + Rows::kSteps; ++i)
      if (std::isfinite(x[i])) sum += x[i], count += 1;
    out[static_cast<Eigen::Index>(k)] =
        count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

Noise noise_of(const Rows& rows, const Eigen::VectorXd& e, const std::vector<bool>& counts) {
  using Eigen::Index;
  Noise out;
  // Spread by the median, correlation in time up to 3 s: the weight is that of independent means.
  out.weight = Eigen::VectorXd::Zero(e.size());
  for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
    std::vector<double> values;
    std::vector<Index> at;
    for (Index i = 0; i < e.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (rows.row[k].relation != relation || !counts[k] || !std::isfinite(e[i])) continue;
      values.push_back(e[i]);
      at.push_back(i);
    }
    if (values.size() < 30) continue;
    std::vector<double> sorted = values;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double median = *middle;
    for (double& x : sorted) x = std::abs(x - median);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double sigma = std::max(1e-6, 1.4826 * *middle);
    // Outliers count as 4 sigma. A constant error is no noise: it is what is to be found.
    for (double& x : values) x = std::clamp(x - median, -4 * sigma, 4 * sigma);
    double variance = 0;
    for (const double x : values) variance += x * x / static_cast<double>(values.size());
    double factor = 1.0;
    for (std::size_t lag = 1; lag <= 10; ++lag) {
      double product = 0;
      for (std::size_t k = lag; k < values.size(); ++k) product += values[k] * values[k - lag];
      factor += 2 * (1 - static_cast<double>(lag) / 11.0) * product /
                (variance * static_cast<double>(values.size()));
    }
    out.sigma[relation] = std::sqrt(variance);
    out.spread[relation] = std::clamp(factor, 0.5, 10.0);
    const double w = 1.0 / std::sqrt(variance * out.spread[relation]);
    for (const Index i : at)
      out.weight[i] = w * std::min(1.0, 4 * sigma / (std::abs(e[i] - median) + 1e-300));
  }
  return out;
}

std::vector<Eigen::VectorXd> rows_at(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                                     const std::vector<Setting>& settings,
                                     const std::vector<KnownDrive>& known, const Rows& rows,
                                     unsigned threads,
                                     const std::function<void(double)>& progress) {
  // Where no car must be driven each is alone, so that threads share them.
  std::vector<char> drives(settings.size(), settings.size() == 1 ? 1 : 0);
  base::parallel_for(settings.size(), 1, threads, [&](std::size_t j, std::size_t) {
    for (std::size_t k = 0; k < logs.size() && drives[j] == 0; ++k)
      drives[j] = needs_drive(logs[k], car, settings[j], known[k]) ? 1 : 0;
  });
  std::vector<const Setting*> driven;
  std::vector<std::size_t> place;
  std::vector<std::vector<std::size_t>> parts;
  for (std::size_t j = 0; j < settings.size(); ++j)
    if (drives[j] != 0)
      driven.push_back(&settings[j]), place.push_back(j);
    else
      parts.push_back({j});
  for (std::vector<std::size_t>& convoy : convoys(logs.front(), car, driven)) {
    for (std::size_t& k : convoy) k = place[k];
    parts.push_back(std::move(convoy));
  }
  // The longest first: nobody waits for one that was begun last.
  std::stable_sort(parts.begin(), parts.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<Eigen::VectorXd> out(settings.size());
  std::atomic<std::size_t> done{0};
  const auto tell = [&] {
    if (progress) progress(static_cast<double>(done) / static_cast<double>(settings.size()));
  };
  base::parallel_for(parts.size(), 1, threads, [&](std::size_t n, std::size_t) {
    const std::vector<std::size_t>& part = parts[n];
    std::vector<const Setting*> of;
    of.reserve(part.size());
    for (const std::size_t j : part) of.push_back(&settings[j]);
    std::vector<std::vector<Residuals>> r(part.size());
    for (std::size_t k = 0; k < logs.size(); ++k) {
      std::vector<Residuals> led = residuals(logs[k], car, of, known[k], tell);
      for (std::size_t i = 0; i < part.size(); ++i) r[i].push_back(std::move(led[i]));
    }
    for (std::size_t i = 0; i < part.size(); ++i) out[part[i]] = gather(rows, r[i]);
    done += part.size();
    tell();
  });
  return out;
}

Eigen::MatrixXd derivatives(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                            const Setting& at, const std::vector<const Unknown*>& unknowns,
                            const std::vector<KnownDrive>& known, const Rows& rows,
                            unsigned threads, const std::function<void(double)>& progress) {
  std::vector<Residuals> base;
  std::vector<KnownDrive> drives(logs.size());
  for (std::size_t k = 0; k < logs.size(); ++k)
    base.push_back(
        residuals(logs[k], car, at, {.known = &known[k], .keep = &drives[k], .tick = [&] {
                                       if (progress) progress(0.0);
                                     }}));
  const Eigen::VectorXd r0 = gather(rows, base);
  std::vector<Setting> moved(unknowns.size(), at);
  for (std::size_t j = 0; j < unknowns.size(); ++j) unknowns[j]->set(moved[j], unknowns[j]->step);
  const std::vector<Eigen::VectorXd> there =
      rows_at(logs, car, moved, drives, rows, threads, progress);
  Eigen::MatrixXd out(r0.size(), static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    Eigen::VectorXd column = (r0 - there[j]) / unknowns[j]->step;
    for (Eigen::Index i = 0; i < column.size(); ++i)
      if (!std::isfinite(column[i])) column[i] = 0.0;
    out.col(static_cast<Eigen::Index>(j)) = column;
  }
  return out;
}

}  // namespace explain
