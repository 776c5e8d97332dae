#include <cmath>

#include "base/error.h"
#include "fuzz/target.h"
#include "road/guide.h"

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put("guide", bytes);
  try {
    const road::GuideFile file = road::read_guide(path);
    require(file.points.size() >= 3, "three positions");
    const road::Guide guide = road::guide_along(file.points);
    require(guide.points_m.size() >= 3 && guide.points_m.size() <= file.points.size(),
            "a lap of what was read");
    for (const Eigen::Vector3d& p : guide.points_m)
      require(std::isfinite(p.x()) && std::isfinite(p.y()), "places");
  } catch (const base::Error& error) {
    // guide_along() knows no file.
    if (std::string_view(error.what()).find("guide") == std::string_view::npos)
      require_refusal(error, path);
  }
}
