// track.yaml: everything that turns one mesh into one track. yaml-cpp stays private to the source
// file.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "crg/file.h"
#include "inspect/validate.h"
#include "inspect/write_report.h"
#include "make/by_type.h"
#include "mesh/read_mesh.h"
#include "road/align.h"
#include "road/centreline.h"
#include "road/clean.h"
#include "road/friction.h"
#include "road/kerb.h"
#include "road/patch.h"
#include "road/reference_line.h"
#include "road/sample.h"
#include "road/smooth.h"

namespace road {

/// A recipe read from track.yaml, or the defaults for a bare mesh. One options struct per stage.
struct Recipe {
  std::string recipe_path;  ///< the track.yaml it was read from; empty for a bare mesh
  std::string name;         ///< DIR/<name>.crg
  std::string mesh_path;    ///< as it can be opened (a recipe's relative path is resolved)
  MeshReadOptions read;
  CleanOptions clean;
  CentrelineOptions centreline;
  std::optional<std::string> start_object;  ///< in place of centreline.start_near_m: its middle
  ReferenceLineOptions reference_line;
  SampleOptions sample;
  KerbOptions kerb;
  PatchOptions patch;
  SmoothOptions smooth;
  FrictionOptions friction;
  ByType more;                            ///< options that a stage has for itself, see src/stages
  std::optional<std::string> guide_path;  ///< read by place_guide()
  std::optional<std::string> guide_mapping_path;  ///< where the guide is a log
  std::optional<std::string> control_points_path;
  std::optional<std::string> trajectory_path;
  std::optional<RotoTranslation> T_global_mesh;
  AlignOptions align;  ///< how control points are fitted
  Projection::Kind projection =
      Projection::Kind::utm;        ///< of geographic control points and trajectories
  std::optional<UtmZone> utm_zone;  ///< of projected ones
  crg::Format format = crg::Format::KRBI;
  ValidateOptions validate;
  ValidateLimits limits;
  Published published;
  bool line_is_right = false;  ///< somebody has looked: doubts about the line do not count
};

/// One key of track.yaml that holds a number, a word or a short list. The same list feeds the
/// reader, the flags of crgbuild (u_step_m becomes --u-step-m), summary.json and the test of
/// docs/formats.md.
struct RecipeKey {
  std::string stage;  ///< the stage that it belongs to: "read", "clean", "centreline", ...
  std::string name;
  std::string wanted;   ///< what a value looks like: "0.01 to 10", "y, z or automatic"
  std::string meaning;  ///< one line
  bool is_text;         ///< a name or a path: never to be taken for a number
  /// Throws Error with the value seen and the value wanted.
  std::function<void(Recipe&, const std::string& text)> set;
  std::function<std::string(const Recipe&)> show;  ///< as it would be written; empty: not set
};

/// All of them, in the order of docs/formats.md; the table name_rules is read besides.
const std::vector<RecipeKey>& recipe_keys();

/// Reads track.yaml (docs/formats.md). Throws Error with file:line on an unknown key, a wrong type
/// or a value out of range, naming the nearest known key or the allowed range.
Recipe read_recipe(const std::string& path);

/// Recipe for a bare mesh: its stem as the name, defaults everywhere.
Recipe recipe_for_mesh(const std::string& mesh_path);

}  // namespace road
