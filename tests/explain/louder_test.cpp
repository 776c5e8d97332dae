// What noise alone makes of a filter that is undone does not rule it out.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/json_text.h"
#include "base/random.h"
#include "explain/signals.h"
#include "proof.h"
#include "signal_samples.h"

namespace explain_test {
namespace louder_test {

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

// At 20 ms and 50 Hz it is named as a delay, and not told from a filter.
TEST(SlowLouder, AFilterOfTheAccelerometerIsAmongWhatItCannotBeToldFrom) {
  Proof proof("filtered", unless_heavy(3));
  const json found = proof.explain();
  ASSERT_EQ(found.at("findings").size(), 1u) << base::dump_json(found.at("findings"), 1);
  const json& first = found.at("findings").at(0);
  EXPECT_NEAR(value(first), 0.02, 0.002);
  EXPECT_EQ(first.at("channel"), "ax_mps2");
  const auto is_filter = [](const json& x) { return x.at("mechanism") == "sensor.low_pass"; };
  EXPECT_TRUE(is_filter(first) || std::any_of(first.at("rivals").begin(), first.at("rivals").end(),
                                              [&](const json& r) {
                                                return is_filter(r) && r.at("separable") == false;
                                              }))
      << base::dump_json(first.at("rivals"), 1);
}

}  // namespace louder_test
}  // namespace explain_test
