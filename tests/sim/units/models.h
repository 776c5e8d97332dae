// Small models that other tools' units are tried with: what they do is that of the units of the
// same names by which importers are compared (a decay, a ball, values passed through), and
// misbehaviour.
#pragma once

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace units {

/// References: 0 the time; decay: 1 x, 2 der(x), 3 k; ball: 1 height, 2 speed, 3 gravity, 4 what is
/// left of the speed after a bounce; passed through: 10 + k in, 20 + k out. All: 30 the tolerance,
/// 31 what is infinite at 0.5 s.
struct Model {
  std::string kind, text_in, text_out;
  double time_s = 0.0, x = 1.0, k = 1.0, height_m = 1.0, speed_mps = 0.0, gravity_mps2 = -9.81,
         left = 0.7, tolerance = -1.0;
  std::array<double, 10> in{};
  bool resting = false;

  bool is_known() const {
    return kind == "decay" || kind == "ball" || kind == "through" || kind == "crashes" ||
           kind == "prints" || kind == "leaves" || kind == "ends" || kind == "errs";
  }

  double* value(unsigned reference) {
    if (kind == "decay" && reference == 1) return &x;
    if (kind == "decay" && reference == 3) return &k;
    if (kind == "ball" && reference == 1) return &height_m;
    if (kind == "ball" && reference == 2) return &speed_mps;
    if (kind == "ball" && reference == 3) return &gravity_mps2;
    if (kind == "ball" && reference == 4) return &left;
    if (reference >= 10 && reference < 20) return &in[reference - 10];
    return nullptr;
  }

  bool get(unsigned reference, double& out) {
    if (reference == 0) return out = time_s, true;
    if (reference == 30) return out = tolerance, true;
    if (reference == 31) return out = 1.0 / (0.25 - time_s * time_s), true;
    if (kind == "decay" && reference == 2) return out = -k * x, true;
    if (reference >= 20 && reference < 30) reference -= 10;
    const double* const found = value(reference);
    if (found != nullptr) out = *found;
    return found != nullptr;
  }

  bool set(unsigned reference, double to) {
    double* const found = value(reference);
    if (found != nullptr) *found = to;
    return found != nullptr;
  }

  /// Explicit Euler, a hundred steps each.
  void small_step(double h_s) {
    x -= h_s * k * x;
    if (resting) return;
    height_m += h_s * speed_mps;
    speed_mps += h_s * gravity_mps2;
    if (height_m > 0.0 || speed_mps >= 0.0) return;
    height_m = 0.0;
    speed_mps = -left * speed_mps;
    if (speed_mps < 0.1) resting = true, speed_mps = 0.0;
  }

  /// 0, or what the standard calls an error (3).
  int step(double at_s, double step_s, bool& ends) {
    for (int i = 0; i < 100; ++i) small_step(step_s / 100.0);
    time_s = at_s + step_s;
    text_out = text_in;
    if (kind == "prints") std::puts("said on standard output");
    if (kind == "crashes" && time_s > 0.45) std::raise(SIGSEGV);
    if (kind == "leaves" && time_s > 0.45) std::_Exit(3);
    if (kind == "ends" && time_s > 0.45) ends = true;
    return kind == "errs" && time_s > 0.45 ? 3 : 0;
  }
};

}  // namespace units
