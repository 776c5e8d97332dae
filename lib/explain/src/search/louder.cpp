// A filter that is undone makes the noise of its sensor louder, a delay that is undone does not.
// That is no misfit, and must not decide between the two.
#include <algorithm>

#include "analysis.h"
#include "signal_samples.h"

namespace explain {

using Eigen::VectorXd;

double Analysis::louder(const Unknown& u, double amount, const VectorXd& w) const {
  if (!u.in_time) return 0.0;
  std::vector<Signals> noisy = logs_;
  bool any = false;
  for (Signals& s : noisy)
    for (const Channel c : {kYawRate, kAx, kAy}) {
      if (!s.present[c] || s.column[c] != u.channel || s.noise[c].size() != s.n) continue;
      for (std::size_t i = 0; i < s.n; ++i) s.x[c][i] += s.noise[c][i];
      for (std::size_t i = 0; i < s.n; ++i) s.dx[c][i] = rate_at(s.x[c], i);
      any = true;
    }
  if (!any) return 0.0;
  const auto rows = [&](const std::vector<Signals>& logs, double by) {
    Setting set = setting_with(amounts_);
    u.set(set, by);
    std::vector<Residuals> out;
    for (std::size_t k = 0; k < logs.size(); ++k)
      out.push_back(residuals(logs[k], car_, set, {.known = &drives_[k], .none = true}));
    return gather(rows_, out);
  };
  const auto loss = [&](double by) {
    const VectorXd noise = w.cwiseProduct(rows(noisy, by) - rows(logs_, by));
    return noise.array().isFinite().select(noise, 0.0).squaredNorm();
  };
  // Earlier and later alike: what the draw has in common with its own rate cancels.
  return 0.5 * (loss(amount) + loss(-amount)) - loss(0.0);
}

}  // namespace explain
