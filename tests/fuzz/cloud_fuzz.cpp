#include "fuzz/cloud_fuzz.h"

#include <cmath>
#include <cstdlib>
#include <string>

#include "cloud/read_cloud.h"
#include "road/error.h"

namespace cloud::fuzz {

void run(std::string_view kind, std::string_view bytes) {
  const std::string name = "fuzz." + std::string(kind);
  CloudReadOptions options;
  options.chunk_points = 64;
  std::size_t points = 0;
  try {
    const CloudReadReport report = read_chunks_from(bytes, name, options, [&](Cloud&& chunk) {
      const std::size_t n = chunk.size();
      points += n;
      const auto fits = [&](std::size_t size) { return size == 0 || size == n; };
      if (n == 0 || n > 64 || chunk.y_m.size() != n || chunk.z_m.size() != n ||
          !fits(chunk.time_s.size()) || !fits(chunk.intensity.size()) ||
          !fits(chunk.classification.size()))
        std::abort();
      for (std::size_t i = 0; i < n; ++i)
        if (!std::isfinite(chunk.x_m[i]) || !std::isfinite(chunk.y_m[i]) ||
            !std::isfinite(chunk.z_m[i]))
          std::abort();
    });
    if (report.points != points || points == 0) std::abort();
  } catch (const road::Error& error) {
    if (std::string_view(error.what()).find(name) == std::string_view::npos) std::abort();
  }
}

}  // namespace cloud::fuzz
