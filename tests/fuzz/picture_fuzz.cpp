// Pictures of meshes: bytes from anywhere, of which only a mean colour is wanted.
#include <stdexcept>
#include <string>

#include "fuzz/target.h"
#include "report/mean_colour.h"

void fuzz::run(std::string_view bytes) {
  std::size_t left = 4'000'000;
  try {
    for (const double channel : report::mean_colour(bytes, left))
      require(channel >= 0.0 && channel <= 1.0, "light between none and all");
    require(left < 4'000'000, "its pixels counted");
  } catch (const std::invalid_argument& error) {
    const std::string why = error.what();
    require(!why.empty() && why.find('\n') == std::string::npos, "one line that says why");
  }
}
