// What each subcommand does, free of option parsing: main.cpp fills these structs, and each run_*
// is: load, one library call, save. They return the exit code.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "road/recipe.h"
#include "terminal.h"

namespace crgbuild {

constexpr int kOk = 0, kFailed = 1, kUsage = 2, kNotValid = 3, kInterrupted = 130;

/// A command line that cannot be meant; what() is shown with a hint at --help.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The file was written, but must not be used: exit code 3.
class NotValid : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
[[noreturn]] void throw_validation_failed(const std::string& path,
                                          const std::vector<std::string>& failures);

/// Keys of a recipe given as flags, in the order of the command line: {"u_step_m", "0.05"}.
using RecipeFlags = std::vector<std::pair<std::string, std::string>>;

/// A recipe (.yaml, .yml) or a bare mesh, with flags on top. Throws UsageError for a bad flag.
road::Recipe make_recipe(const std::string& input, const RecipeFlags& flags);

/// The same without a mesh to read: only the flags count.
road::Recipe make_recipe(const RecipeFlags& flags);

struct BuildCommand {
  std::string input, output_dir;
  RecipeFlags flags;
};
int run_build(const BuildCommand& command, Terminal& terminal);

struct CleanCommand {
  std::string input, output;
  RecipeFlags flags;
};
int run_clean(const CleanCommand& command, Terminal& terminal);

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

struct InfoCommand {
  std::string crg;
};
int run_info(const InfoCommand& command, Terminal& terminal);

struct QueryCommand {
  std::string crg, points, output;
  unsigned threads = 0;
};
int run_query(const QueryCommand& command, Terminal& terminal);

struct SynthCommand {
  std::string circuit, output_dir, format = "obj", up = "y", unit = "m", names = "plain";
  double facet_m = 0.5;
};
int run_synth(const SynthCommand& command, Terminal& terminal);

}  // namespace crgbuild
