#include "guesses.h"

namespace vehicle {
namespace {

// road, race, formula, kart. RCVD: Milliken, Race Car Vehicle Dynamics. NHTSA: Heydinger and
// others, Measured Vehicle Inertial Parameters, SAE 1999-01-1336.
constexpr std::array<Guessed, static_cast<std::size_t>(Guess::kCount)> kGuesses = {{
    {{0.52, 0.42, 0.30, 0.26}, 0.12, "saloons of NHTSA have 0.50 to 0.57, a low racer 0.28"},
    {{1.05, 1.5, 1.65, 1.5}, 0.15, "good road tyres 0.95 to 1.15, slicks 1.4 to 1.9"},
    {{0.65, 1.0, 1.1, 0.6}, 0.2, "road cars 0.55 to 0.8, wings and open wheels add"},
    {{0.0, 0.6, 1.1, 0.0}, 0.4, "road cars have none, racers as their rules let them"},
    {{0.0, 0.9, 1.6, 0.0}, 0.4, "road cars have none, racers as their rules let them"},
    {{1.4, 2.6, 3.5, 6.0},
     0.3,
     "RCVD 16: road 1 to 2, racers 2 to 3, downforce 3 to 5; a kart's frame"},
    {{1.6, 2.8, 3.7, 6.0}, 0.3, "a little above the front, so that pitching dies away (RCVD 16)"},
    {{6, 6, 6, 1}, 0.1, "usual of its kind"},
    {{0.62, 0.85, 1.0, 0.8},
     0.25,
     "cornering stiffness over load: road 16 to 25 per rad, slicks 30 to 40"},
    {{0.07, 0.026, 0.010, 0.008}, 0.3, "roll per g: road 3 to 5 degrees, racers 0.5 to 1.5"},
    {{0.04, 0.1, 0.12, 0.05}, 0.5, "so that the front gives way first"},
    {{0.95, 0.85, 0.65, 0.75}, 0.15, "NHTSA: 0.9 to 1.05; without overhangs less"},
    {{0.38, 0.33, 0.27, 0.27}, 0.15, "NHTSA: 0.36 to 0.42 of the track; a slim body less"},
    {{0.3, 0.5, 0.6, 0.4}, 0.4, "shares of the critical: road 0.2 to 0.4, racers 0.5 to 0.8"},
    {{0.5, 0.75, 0.8, 0.4}, 0.4, "shares of the critical: road 0.3 to 0.6, racers 0.6 to 1"},
    {{0.7, 0.35, 0.35, 0.7}, 0.4, "dampers that are strong when slow give way over bumps"},
    {{0.07, 0.035, 0.025, 0.02}, 0.3, "travel: road 60 to 90 mm, racers 20 to 40"},
    {{0.08, 0.06, 0.05, 0.0}, 0.5, "low roll centres are usual"},
    {{-0.017, -0.045, -0.045, -0.01}, 0.5, "road 0 to 2 degrees, racers 2 to 4"},
    {{0.90, 0.92, 0.93, 0.94}, 0.04, "losses of gears, joints and bearings, 6 to 12 %"},
    {{0.25, 0.08, 0.05, 0.05}, 0.4, "by hand 0.2 to 0.4 s, by paddles 0.03 to 0.1 s"},
    {{3.5e-4, 2e-4, 1.2e-4, 1e-4}, 0.5, "of crank and flywheel, with the torque"},
    {{0.026, 0.027, 0.027, 0.022}, 0.2, "wheel, tyre, upright and brake: 2 to 3 % of the car"},
}};

}  // namespace

const Guessed& guess(Guess what) { return kGuesses[static_cast<std::size_t>(what)]; }

}  // namespace vehicle
