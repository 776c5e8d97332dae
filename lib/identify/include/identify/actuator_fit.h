// What an actuator is, found from its recorded command and movement.
#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

namespace identify {

/// Movement = gain * play of G(s) e^(-dead time s) command + offset, with
///   0 poles: G = 1;  1: 1 / (1 + lag s);  2: 1 / (1 + 2 damping lag s + lag^2 s^2);
///   3: the product of both,
/// times (1 + lead s) with a zero. Sampled it is an ARX(na, nb, nk) model with na = poles.
struct ActuatorOrder {
  int poles = 2;      ///< 0 to 3
  bool zero = false;  ///< not with 0 poles
  bool play = false;  ///< friction or backlash, which a command and a movement cannot tell apart

  bool operator==(const ActuatorOrder&) const = default;
};

/// How the command runs between two samples.
enum class Hold {
  kLine,  ///< straight: samples of something that moves smoothly
  kStep   ///< as at the earlier sample: sent at the log's own rate
};

struct ActuatorFitOptions {
  std::optional<ActuatorOrder> order;  ///< none: chosen
  std::optional<Hold> hold;            ///< none: chosen
  unsigned threads = 0;                ///< 0: all cores; any number gives the same result
};

/// A number with its standard deviation; 0 where the order has none.
struct Uncertain {
  double value = 0.0, sd = 0.0;
};

/// One order that was tried.
struct TriedOrder {
  ActuatorOrder order;
  double rms = 0.0;      ///< of movement less model on blocks left out of the fit
  double clearly = 0.0;  ///< how many standard errors better than the order chosen before it
  bool taken =
      false;  ///< better by more than three and by one per cent, and so chosen until a later one is
};

struct ActuatorFit {
  ActuatorOrder order;
  Hold hold = Hold::kLine;
  /// lag2_s is the lag of 1 pole and the extra one of 3; lag_s and damping are those of 2 and 3.
  Uncertain gain, offset, dead_time_s, lag_s, damping, lag2_s, lead_s;
  Uncertain play;  ///< from end to end, unit of the movement
  std::vector<std::complex<double>> poles_radps;
  double rms = 0.0;        ///< of movement less model, unit of the movement
  double rms_plain = 0.0;  ///< with gain and offset alone: what the model has to beat
  double repeats = 1.0;    ///< rows that count as one in the standard deviations
  double step_s = 0.0;     ///< between rows
  std::size_t rows = 0;
  std::vector<TriedOrder> tried;  ///< empty where the order was given
};

/// Least squares of the simulated movement (output error: noise of the movement does not bias it),
/// exact for the stated run of the command between samples, from a grid of beginnings. The order
/// is chosen by cross-validation: the record is cut into up to 60 blocks of equal movement of the
/// command, of which every fourth is left out in turn; a larger order is taken when it predicts the
/// blocks left out better by more than three standard errors and by one per cent, smaller ones
/// first. Standard deviations are those of least squares, with fewer rows where errors follow each
/// other, and a twentieth of a step for dead time and lags, because nobody knows how the command
/// ran between the rows. A command in steps is taken as held, others as straight, unless the
/// movement clearly says the other: where it is smooth at the log's rate, the two differ by half a
/// step of dead time and by nothing else. The first second (a tenth of a short record) is simulated
/// and not judged. Time ascends, s; rows that are not evenly spaced are brought to an even grid of
/// their mean distance by straight lines. At most 200,000 rows are taken, the first. Throws
/// base::Error with fewer than 50 rows, a command or a movement that hardly moves, or values that
/// are not finite.
ActuatorFit fit_actuator(const std::vector<double>& time_s, const std::vector<double>& command,
                         const std::vector<double>& movement,
                         const ActuatorFitOptions& options = {});

/// The model's movement to a command every `fit.step_s`, at rest before the first.
std::vector<double> simulate_actuator(const ActuatorFit& fit, const std::vector<double>& command);

/// The coefficients of the ARX model at `fit.step_s`: y[k] + a1 y[k-1] + ... = b0 u[k-nk] + ...;
/// play and offset are not in it.
struct Arx {
  std::vector<double> a, b;
  int dead_steps = 0;  ///< nk
};
Arx arx_of(const ActuatorFit& fit);

}  // namespace identify
