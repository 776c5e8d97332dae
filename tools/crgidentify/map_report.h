// A map that was found as text, JSON, a file for a car and a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "identify/drive_fits.h"

namespace crgidentify {

/// How one kind of map is told.
struct MapWords {
  const char *x, *y, *value;  ///< keys; of columns, too
  const char* unit;           ///< ending of the keys of numbers beside the value
  const char* seconds;        ///< key
  bool seconds_apart;         ///< a list of them
  const char* table;          ///< first lines of the table, up to its columns
  int width, digits;          ///< of the table's cells
  std::string (*row)(double x), (*column)(double y);
  const char* about;  ///< sentence of the page; empty: none
  bool drawn_over_x;  ///< a plot for each y; else over y, a plot for each x
  std::string (*plot)(double at);
  const char *along, *up;  ///< the plots' axes
};
extern const MapWords kEngineWords, kPadWords;

/// Values and half their 90 % intervals, empty where unseen.
std::string map_table(const MapWords& words, const identify::FoundMap& map);
nlohmann::ordered_json map_json(const MapWords& words, const identify::FoundMap& map);
/// As a vehicle file reads it; every place has a number.
std::string map_csv(const MapWords& words, const identify::FoundMap& map);
/// With the numbers, remarks and doubts of `fit`.
std::string map_page(const MapWords& words, const identify::FoundMap& map,
                     const identify::DriveFit& fit, const std::string& title);

}  // namespace crgidentify
