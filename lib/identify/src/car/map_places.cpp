#include "map_places.h"

#include <algorithm>
#include <numeric>

namespace identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Found map_factor(std::string name, const VectorXd& weights, const MapSolved& solved) {
  Found f = found_of(std::move(name), "1", 1.0);
  set_found(f, 1.0 + weights.dot(solved.fit.value), static_cast<double>(solved.fit.blocks) - 2.0,
            std::sqrt(weights.dot(solved.fit.noise * weights)),
            std::sqrt(weights.dot((solved.fit.prior_left + solved.granted) * weights)));
  return f;
}

PlaceFinder::PlaceFinder(const vehicle::Map2& stated, const MapSolved& solved, std::size_t counts,
                         FoundMap& out)
    : out_(out), from_(stated.z.size()) {
  out.x = stated.x;
  out.y = stated.y;
  for (std::size_t k = 0; k < stated.z.size(); ++k) {
    const Found f =
        map_factor({}, VectorXd::Unit(solved.fit.value.size(), static_cast<Index>(k)), solved);
    out.places.push_back({stated.x[k / stated.y.size()],
                          stated.y[k % stated.y.size()],
                          stated.z[k] + solved.fit.value(static_cast<Index>(k)),
                          f.sd,
                          f.within,
                          stated.z[k],
                          std::vector<double>(counts),
                          {}});
  }
}

void PlaceFinder::near(double x, double y, std::size_t count, double seconds, std::size_t block) {
  for (const auto& [place, weight] : map_weights(out_.x, out_.y, x, y)) {
    out_.places[place].seconds[count] += weight * seconds;
    if (weight > 0.2) from_[place].insert(block);
  }
}

void PlaceFinder::hide(double least, const char* of, const char* unit) {
  for (std::size_t k = 0; k < out_.places.size(); ++k) {
    MapPlace& place = out_.places[k];
    const double all = std::accumulate(place.seconds.begin(), place.seconds.end(), 0.0);
    if (all < 1.0 || from_[k].size() < 2)
      place.unseen =
          fmt::format("{:.1f} s {}near it, at {} places of the road", all, of, from_[k].size());
    else if (place.within > 0.1 * std::max(std::abs(place.value), least))
      place.unseen =
          fmt::format("its 90 % interval would be {:.2g}{} either way", place.within, unit);
  }
}

}  // namespace identify
