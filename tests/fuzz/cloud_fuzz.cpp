// A point cloud; `ending` is that of its name. Of every 16th, ground is told too.
#include <cmath>
#include <string>

#include "base/error.h"
#include "cloud/ground.h"
#include "cloud/read_cloud.h"
#include "fuzz/target.h"

namespace fuzz {
extern const char* const ending;  // of each target its own: CMakeLists.txt
}

void fuzz::run(std::string_view bytes) {
  const std::string name = std::string("input") + ending;
  cloud::CloudReadOptions options;
  options.chunk_points = 64;
  std::size_t points = 0;
  cloud::Cloud first;
  try {
    const cloud::CloudReadReport report =
        cloud::read_chunks_from(bytes, name, options, [&](cloud::Cloud&& chunk) {
          const std::size_t n = chunk.size();
          points += n;
          const auto fits = [&](std::size_t size) { return size == 0 || size == n; };
          require(n > 0 && n <= 64 && chunk.y_m.size() == n && chunk.z_m.size() == n &&
                      fits(chunk.time_s.size()) && fits(chunk.intensity.size()) &&
                      fits(chunk.classification.size()),
                  "arrays that fit each other");
          for (std::size_t i = 0; i < n; ++i)
            require(std::isfinite(chunk.x_m[i]) && std::isfinite(chunk.y_m[i]) &&
                        std::isfinite(chunk.z_m[i]),
                    "finite coordinates");
          if (first.size() == 0) first = std::move(chunk);
        });
    require(report.points == points && points > 0, "points, and their number");
  } catch (const base::Error& error) {
    require_refusal(error, name);
    return;
  }
  if (bytes.size() % 16 != 0) return;  // much slower than reading
  try {
    cloud::GroundOptions small;
    small.max_window_m = 3.0;
    require(cloud::classify_ground(first, small).size() == first.size(), "a class per point");
  } catch (const base::Error& error) {
    require_refusal(error, "points");
  }
}
