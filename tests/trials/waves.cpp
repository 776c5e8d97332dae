#include "waves.h"

#include <algorithm>
#include <cstdio>

#include "write_trial.h"

namespace trials {
namespace {

/// Largest RMS difference that an effect makes in a channel, in standard deviations of its noise:
/// over the rows between two places, or over all.
double size_sd(const Drive& with, const Drive& without, int first, int last, double begin_m,
               double end_m) {
  double largest = 0;
  for (int channel = first; channel < last; ++channel) {
    const auto c = static_cast<std::size_t>(channel);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < std::min(with.row.size(), without.row.size()); ++i) {
      if (end_m > begin_m && !(with.row[i][kS] > begin_m && with.row[i][kS] < end_m)) continue;
      const double d = with.row[i][c] - without.row[i][c];
      sum += d * d;
      count += 1;
    }
    if (count > 0 && kNoise[c] > 0) largest = std::max(largest, std::sqrt(sum / count) / kNoise[c]);
  }
  return largest;
}

}  // namespace

void draw_waves(int id, unsigned long long seed, const std::filesystem::path& folder) {
  Random dice{seed * 1000003ULL + 7919ULL * static_cast<unsigned long long>(id)};
  for (int i = 0; i < 5; ++i) dice.uniform();
  Trial t;
  char name[16];
  std::snprintf(name, sizeof name, "%04d", id);
  t.name = name;
  t.id = id;
  const double phase = dice.in(0, 6), a5 = dice.in(0.0, 0.035), a3 = dice.in(0.04, 0.13),
               a2 = dice.in(0.1, 0.24), radius_m = dice.in(170, 260);
  t.track = make_track(radius_m, a2, a3, a5, phase);
  t.track.hill = {dice.in(0, 3), dice.in(0, 1), dice.in(0, 0.4)};
  t.track.hill_phase = {dice.in(0, 6), dice.in(0, 6), dice.in(0, 6)};
  t.track.bank_base = dice.in(0, 0.02);
  t.style.laps = 3 + static_cast<int>(dice.below(3));
  t.style.seed = seed * 31 + static_cast<unsigned long long>(id);
  t.style.sway_m = dice.in(0.3, 1.2);
  t.style.pace_low = dice.in(0.62, 0.72);
  t.style.pace_high = dice.in(0.76, 0.86);
  t.hz = dice.uniform() < 0.5 ? 100 : 200;
  t.off = 0.03;
  t.ride.emplace();
  t.discs.emplace();
  t.discs->begin_k = dice.in(290, 450);
  t.stated_track = t.track;

  const double length = t.track.length_m, begin = dice.in(0.1, 0.8) * length;
  const int kind = id % 8;
  t.kind = kind < 4 ? "none" : "single";
  const auto lay = [&](double end, double right, double left, double height, double stated,
                       double wave, bool teeth) {
    t.track.feature = {{begin, end, right, left, height, wave, teeth}};
    t.stated_track->feature = {{begin, end, right, left, stated, wave, teeth}};
  };
  Effect effect;
  if (kind == 4) {
    effect = {"road.kerb_or_roughness", "", dice.in(0.003, 0.012), begin, begin + dice.in(15, 50)};
    lay(effect.end_m, -10, 10, effect.amount, 0.0, dice.in(1.5, 8), false);
  } else if (kind == 5) {
    effect = {"road.kerb_or_roughness", "", dice.in(0.015, 0.04), begin, begin + dice.in(12, 30)};
    const double wave_m = dice.in(0.8, 2), stated_m = dice.in(0.0, 0.4) * effect.amount;
    lay(effect.end_m, 0.2, 3.0, effect.amount, stated_m, wave_m, true);
  } else if (kind == 6) {
    effect = {"vehicle.multi_point_contact", "", dice.in(0.015, 0.035), begin,
              begin + dice.in(15, 30)};
    lay(effect.end_m, -10, 10, effect.amount, effect.amount, dice.in(0.4, 0.9), true);
  } else if (kind == 7) {
    effect = {"vehicle.brake_disc_conductance", "", dice.in(0.7e-3, 3e-3)};
    t.discs->slope_1pk = effect.amount;
  }
  if (!effect.mechanism.empty()) {
    Drive with = drive(t.truth, t.track, t.style, nullptr), without = with;
    if (kind == 7) {
      heat(with, t.truth.car, *t.discs);
      Discs plain = *t.discs;
      plain.slope_1pk = 0;
      heat(without, t.truth.car, plain);
      t.sizes.push_back(size_sd(with, without, kDisc, kDisc + 4, 0, 0));
    } else {
      shake(with, t.track, t.truth.car, *t.ride);
      Ride other = *t.ride;
      if (kind == 6) other.envelops = false;
      shake(without, kind == 6 ? t.track : *t.stated_track, t.truth.car, other);
      t.sizes.push_back(size_sd(with, without, kRollRate, kLoad + 4, effect.begin_m, effect.end_m));
    }
    t.truth.car.effects.push_back(effect);
  }
  if (!write_trial(t, dice, folder)) std::fprintf(stderr, "trial %s is left out\n", name);
}

}  // namespace trials
