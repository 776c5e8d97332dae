// What a blind trial is about: effects drawn, then sized against the noise of the channels.
#pragma once

#include <string>
#include <vector>

#include "drive.h"

namespace trials {

/// An effect before it is sized.
struct Choice {
  const char* mechanism;
  const char* channel;
  double unit, most;  ///< first guess and largest amount
};

/// Two effects that the data cannot tell apart when they are small enough. What a sensor should
/// have said is known from other channels only, whose noise grows with frequency: `reference_s` is
/// the reciprocal of the frequency (rad/s) from which on it is larger than the sensor's own,
/// `noise` what else they add, as a factor.
struct Pair {
  const char *one, *other, *channel;
  double reference_s, noise;
};

struct Question {
  std::string kind;  ///< none, single, two, outside, alike
  std::vector<Choice> chosen;
  std::vector<double> wanted_sd;        ///< sizes of the chosen
  std::vector<std::size_t> parameters;  ///< of kParameters, off by more than a few per cent
  Pair pair{};                          ///< of kind alike,
  bool second = false;                  ///< whose other member is the truth
};
Question choose(const std::string& kind, Random& dice);

/// The chosen effects with their amounts and sizes: RMS differences, see Drive.
struct Sized {
  std::vector<Effect> effects;
  std::vector<double> sizes_sd;
  double apart_sd = 0;  ///< of a pair: how far an observer of all samples has its members apart
  double shift_m = 0;   ///< of the road's heights
};
/// Drives a lap per guess. What a trial about a term is measured against is the car without it;
/// some effects need something that `nominal` does not have yet.
Sized size_effects(const Question& question, const Track& track, const Style& style, double hz,
                   Variant& nominal, Random& dice);

/// The car with these effects; what acts between driver and car becomes part of the variant.
/// `moved` is the track of an effect that misplaces it.
Variant with(Variant v, const std::vector<Effect>& effects, const Track& moved);
/// The car on its track without them, lacking the terms that they are about.
Variant without(const Variant& v, std::vector<Effect> effects, const Track& track);

bool is_about(const std::vector<Effect>& effects, const std::string& mechanism);

}  // namespace trials
