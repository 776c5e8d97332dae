// What each subcommand does, free of option parsing: main.cpp fills these structs, and each run_*
// is: load, one library call, save. They return the exit code.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"
#include "inspect/write_report.h"
#include "make/make_reported.h"
#include "make/preview.h"
#include "make/recipe.h"

namespace crgbuild {

using command::kFailed, command::kNotValid, command::kOk, command::one_line;
using command::NotValid, command::shell_word, command::Terminal, command::UsageError;

/// Keys of a recipe given as flags, in the order of the command line.
using RecipeFlags = road::RecipeValues;

/// A recipe (.yaml, .yml) or a bare mesh, with flags on top. Throws UsageError for a bad flag.
road::Recipe make_recipe(const std::string& input, const RecipeFlags& flags);

/// The same without a mesh to read: only the flags count.
road::Recipe make_recipe(const RecipeFlags& flags);

using BuildCommand = road::BuildRequest;
int run_build(const BuildCommand& command, Terminal& terminal);

struct StretchCommand {
  std::string input, output, build;
  double u_begin_m = 0.0, u_end_m = 0.0;
  RecipeFlags flags;
};
int run_stretch(const StretchCommand& command, Terminal& terminal);

struct FromEdgesCommand {
  std::string left, right, output_dir, name;
  bool open = false;
  RecipeFlags flags;
};
int run_from_edges(const FromEdgesCommand& command, Terminal& terminal);

struct CleanCommand {
  std::string input, output;
  RecipeFlags flags;
};
int run_clean(const CleanCommand& command, Terminal& terminal);

struct PreviewCommand {
  std::string input, output;
  std::size_t most_triangles = road::kPreviewTriangles;
  bool raw = false;
  RecipeFlags flags;
};
int run_preview(const PreviewCommand& command, Terminal& terminal);

struct ObjectsCommand {
  std::string input;
  RecipeFlags flags;
};
int run_objects(const ObjectsCommand& command, Terminal& terminal);
/// What the largest objects were taken for; nothing where the mesh has but one.
void print_objects_in_short(const std::string& input, const RecipeFlags& flags, Terminal& terminal);

struct CentrelineCommand {
  std::string input, output;
  RecipeFlags flags;
};
int run_centreline(const CentrelineCommand& command, Terminal& terminal);

struct SampleCommand {
  std::string input, centreline, output;
  RecipeFlags flags;
};
int run_sample(const SampleCommand& command, Terminal& terminal);

struct KerbCommand {
  std::string crg, mesh, output;
  RecipeFlags flags;
};
int run_kerb(const KerbCommand& command, Terminal& terminal);

struct SmoothCommand {
  std::string crg, mesh, output;
  bool ignore_kerbs = false;
  RecipeFlags flags;
};
int run_smooth(const SmoothCommand& command, Terminal& terminal);

struct AlignCommand {
  std::string crg, output;
  RecipeFlags flags;
};
int run_align(const AlignCommand& command, Terminal& terminal);

struct ValidateCommand {
  std::string crg, mesh;
  RecipeFlags flags;
};
int run_validate(const ValidateCommand& command, Terminal& terminal);

struct ReportCommand {
  std::string crg, output_dir, mesh, against, cloud, before, grip;
  RecipeFlags flags;
};
/// Exit code 3 when the road is not usable; the report is written all the same.
int run_report(const ReportCommand& command, Terminal& terminal);

void print_report(const road::ReportFiles& files, Terminal& terminal);

struct InfoCommand {
  std::string crg;
};
int run_info(const InfoCommand& command, Terminal& terminal);

struct QueryCommand {
  std::string crg, points, output;
  unsigned threads = 0;
  std::string modifiers = "file";     ///< file, none or reference
  std::vector<std::string> settings;  ///< KEY=VALUE for options and modifiers
};
int run_query(const QueryCommand& command, Terminal& terminal);

struct CheckCommand {
  std::string crg;
};
int run_check(const CheckCommand& command, Terminal& terminal);

/// Commands that write an edited road; format is that of the input unless given.
struct ConvertCommand {
  std::string crg, output, format;
};
int run_convert(const ConvertCommand& command, Terminal& terminal);

struct CropCommand {
  std::string crg, output, format;
  std::optional<double> u_begin_m, u_end_m, v_right_m, v_left_m;
};
int run_crop(const CropCommand& command, Terminal& terminal);

struct ResampleCommand {
  std::string crg, output, format;
  std::optional<double> u_step_m, v_step_m;
};
int run_resample(const ResampleCommand& command, Terminal& terminal);

struct ReverseCommand {
  std::string crg, output, format;
};
int run_reverse(const ReverseCommand& command, Terminal& terminal);

struct AppendCommand {
  std::string first, second, output, format;
  bool move = false;
};
int run_append(const AppendCommand& command, Terminal& terminal);

struct TransformCommand {
  std::string crg, output, format;
  std::vector<std::string> settings;  ///< KEY=VALUE for modifiers
};
int run_transform(const TransformCommand& command, Terminal& terminal);

/// A road in a format of other programs.
struct ExportCommand {
  std::string crg, output, friction_crg;
  std::string format;   ///< empty: as the output ends; xodr, rdf, mesh, geojson, kml, svg, tum,
                        ///< heightmap or mat
  double step_m = 0.5;  ///< of rows, for triangles; of samples, for heightmaps
};
int run_export(const ExportCommand& command, Terminal& terminal);

struct SynthCommand {
  std::string circuit, output_dir, format = "obj", up = "y", unit = "m", names = "plain";
  double facet_m = 0.5;
};
int run_synth(const SynthCommand& command, Terminal& terminal);

}  // namespace crgbuild
