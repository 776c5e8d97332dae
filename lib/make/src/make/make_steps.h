// What builds from a mesh and from edges share. Private.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "crg/reference_line.h"
#include "make/make_track.h"
#include "make/summary.h"
#include "report/class_map.h"
#include "road/sample.h"

namespace road {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Runs one stage, keeps its seconds.
class Stages {
 public:
  Stages(const Progress& progress, std::vector<StageSeconds>& seconds, double stages)
      : progress_(progress), seconds_(seconds), stages_(stages) {}

  template <typename Body>
  auto operator()(const std::string& name, const Body& body) {
    if (progress_) progress_(name, static_cast<double>(seconds_.size()) / stages_);
    const Stopwatch stopwatch{name, seconds_};
    return body();
  }

 private:
  struct Stopwatch {
    const std::string& name;
    std::vector<StageSeconds>& seconds;
    Clock::time_point start = Clock::now();
    ~Stopwatch() { seconds.push_back({name, seconds_since(start)}); }
  };
  const Progress& progress_;
  std::vector<StageSeconds>& seconds_;
  double stages_;
};

constexpr const char *kSummaryName = "summary.json", *kTimingName = "timing.json",
                     *kCentrelineName = "centreline.csv";

constexpr double kBuildStages = 13.0;  ///< of make_road() and write(), friction left out

inline std::string road_name(const Recipe& recipe) { return recipe.name + ".crg"; }
inline std::string surface_name(const Recipe& recipe) { return recipe.name + ".stl"; }
inline std::string picture_name(const Recipe& recipe) { return recipe.name + ".png"; }
inline std::string classes_name(const Recipe& recipe) { return recipe.name + ".classes.png"; }
inline std::string friction_name(const Recipe& recipe) { return recipe.name + ".friction.crg"; }

/// Where the files of a track lie after the commit; the rest of the result is empty.
BuildResult paths_of(const Recipe& recipe, const base::OutputSet& outputs);

/// The plan view of a road as PNG.
std::string plan_picture(const std::string& title, const crg::ReferenceLine& line,
                         const SampledGrid& sampled, unsigned threads);

/// Every triangle of the mesh as it came in, from above, in the colour of its class; in the mesh's
/// frame.
report::ClassMap class_picture(const Mesh& mesh,
                               const std::vector<SurfaceClass>& class_of_triangle);

}  // namespace road
