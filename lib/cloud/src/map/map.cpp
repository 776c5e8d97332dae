#include "cloud/map.h"

#include <chrono>
#include <optional>
#include <utility>

#include "map_steps.h"
#include "read_ahead.h"

namespace cloud {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The source, with its own time kept apart from that of its reader.
CloudSource timed(const CloudSource& source, double& seconds) {
  return [&source, &seconds](const ChunkSink& sink) {
    double inside = 0.0;
    const Clock::time_point start = Clock::now();
    source([&](Cloud&& chunk) {
      const Clock::time_point here = Clock::now();
      sink(std::move(chunk));
      inside += seconds_since(here);
    });
    seconds += seconds_since(start) - inside;
  };
}

}  // namespace

MapResult map_clouds(const CloudSource& scans, const crg::Crg& base, const Trajectory* trajectory,
                     const MapOptions& options) {
  const RoadFrame frame(base);
  return with_causes(scans, frame, trajectory, options, [&] {
    std::optional<RoadTrajectory> placed;
    if (trajectory != nullptr) placed = place_on_road(*trajectory, frame);
    const MapInputs inputs{frame, base.grid, placed ? &*placed : nullptr, options};
    MapResult result;
    MapState state = first_state(inputs);
    const CloudSource ahead = read_ahead(timed(scans, state.report.seconds_read), options.threads);
    const CloudSource source = [&](const ChunkSink& sink) {
      ahead([&](Cloud&& chunk) {
        if (options.on_chunk) options.on_chunk();
        sink(std::move(chunk));
      });
    };
    while (state.step != MapStep::done)
      advance(state, read_for(state, source, inputs, state.report), inputs, result);
    return result;
  });
}

}  // namespace cloud
