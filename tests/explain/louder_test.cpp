// A filter is not taken for a delay because undoing it makes noise louder.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "../../lib/explain/src/signal_samples.h"
#include "base/random.h"
#include "explain/signals.h"
#include "proof.h"

namespace explain_test {
namespace {

double rms(const std::vector<double>& x) {
  double sum = 0, count = 0;
  for (const double value : x)
    if (std::isfinite(value)) sum += value * value, count += 1;
  return std::sqrt(sum / count);
}

TEST(Louder, ADrawOfNoiseIsAsLargeAsThatOfTheSamples) {
  base::Random dice(3);
  constexpr double kHalf_s = 0.15;
  explain::Samples swing, noisy, noise;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.02 * i, n = 0.15 * dice.normal();
    for (explain::Samples* s : {&swing, &noisy, &noise}) s->t.push_back(t);
    swing.x.push_back(4 * std::sin(2.0 * t));
    noisy.x.push_back(swing.x.back() + n);
    noise.x.push_back(n);
  }
  const std::size_t steps = 2390;
  std::vector<double> x, dx, smooth_noise;
  explain::smooth(noisy, 0.0, steps, kHalf_s, x, dx);
  explain::smooth(noise, 0.0, steps, kHalf_s, smooth_noise, dx);
  const double drawn = rms(explain::noise_like(noisy, kHalf_s, x)), wanted = rms(smooth_noise);
  fmt::print("drawn {:.5f}, in the samples {:.5f}\n", drawn, wanted);
  EXPECT_NEAR(drawn, wanted, 0.06 * wanted);
  // Samples without noise have none.
  explain::smooth(swing, 0.0, steps, kHalf_s, x, dx);
  EXPECT_LT(rms(explain::noise_like(swing, kHalf_s, x)), 0.05 * wanted);
}

TEST(Louder, AFilterOfTheAccelerometerIsNamedAsOne) {
  Proof proof("filtered");
  const json found = proof.explain();
  ASSERT_FALSE(found.at("findings").empty());
  const json& first = found.at("findings").at(0);
  EXPECT_EQ(first.at("mechanism"), "sensor.low_pass") << first.dump(1);
  EXPECT_NEAR(value(first), 0.02, 0.002);
}

}  // namespace
}  // namespace explain_test
