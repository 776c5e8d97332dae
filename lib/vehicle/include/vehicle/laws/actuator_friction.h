// Friction and play in an actuator, between a drive and what it moves.
#pragma once

namespace vehicle::laws {

/// The play operator (M. A. Krasnosel'skii and A. V. Pokrovskii, Systems with Hysteresis, 1989):
/// the output stays until the drive is ahead of it by `half_width`, then follows at that distance.
/// A spring against Coulomb friction, and a backlash of twice the width, do the same.
template <class T>
void play(const T& drive, const T& half_width, T& output) {
  if (drive > output + half_width) output = drive - half_width;
  if (drive < output - half_width) output = drive + half_width;
}

/// What a sticking actuator remembers.
template <class T>
struct Stick {
  T output = T(0), drive = T(0);
  int moving = 0;  ///< +1, -1, or 0: sticks
};

/// Static friction above the sliding one (the two-parameter model of sticking valves, M. A. A. S.
/// Choudhury, N. F. Thornhill and S. L. Shah, Control Engineering Practice 13, 2005, there
/// S = 2 sliding + breakaway, J = breakaway): at rest the output stays until the drive is
/// ahead of it by more than sliding + breakaway, jumps to `sliding` behind it, and follows there
/// until the drive stops or turns.
template <class T>
void stick(const T& drive, const T& sliding, const T& breakaway, Stick<T>& s) {
  if ((s.moving > 0 && !(drive > s.drive)) || (s.moving < 0 && !(drive < s.drive))) s.moving = 0;
  s.drive = drive;
  if (s.moving == 0) {
    if (drive - s.output > sliding + breakaway) s.moving = 1;
    if (s.output - drive > sliding + breakaway) s.moving = -1;
  }
  if (s.moving > 0) s.output = drive - sliding;
  if (s.moving < 0) s.output = drive + sliding;
}

}  // namespace vehicle::laws
