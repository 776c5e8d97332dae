// Options in, one command, exit code.
#include <algorithm>
#include <array>
#include <initializer_list>
#include <set>

#include "command/program.h"
#include "commands.h"
#include "mesh/error.h"

namespace crgbuild {
namespace {

using command::add_choice, command::add_input, command::add_output_file, command::add_output_folder;

enum class Keys { of_these, of_all_but_these };

/// Keys that are often given on the command line; docs/formats.md has the others, which are flags
/// too.
bool is_often_given(const std::string& key) {
  static const std::set<std::string> kOften = {"up",
                                               "mirror",
                                               "unit",
                                               "scale",
                                               "allow_outside",
                                               "use_names",
                                               "bridge_gap_m",
                                               "near_m",
                                               "guide",
                                               "route",
                                               "guide_width_m",
                                               "reverse",
                                               "u_step_m",
                                               "v_step_m",
                                               "v_max_m",
                                               "smooth_window_m",
                                               "roughness_class",
                                               "friction",
                                               "control_points",
                                               "trajectory",
                                               "utm_zone",
                                               "yaw_deg",
                                               "translation_m",
                                               "format",
                                               "threads",
                                               "line_is_right"};
  return kOften.contains(key);
}

/// Keys whose flag is not called like them, and what that flag takes.
struct OtherFlag {
  const char *key, *flag, *takes, *text;
};
constexpr std::array kOtherFlags = {
    OtherFlag{"start_near_m", "--start-at", "X,Y or an object's name",
              "u = 0 where the line passes nearest to this point, or at the middle of this object"},
    OtherFlag{"start_object", "--start-at", nullptr, nullptr},
    OtherFlag{"guide_mapping", "--mapping", "a path",
              "mapping.yaml that says which columns of a log as guide are the place"}};

/// "12.5,-3" or "[12.5, -3]", which is no object's name.
bool is_point(const std::string& text) {
  return text.find_first_not_of("0123456789+-.eE, []") == std::string::npos &&
         text.find(",") != std::string::npos;
}

CLI::Option* add_recipe_flag(CLI::App& command, const road::RecipeKey& key, const std::string& flag,
                             RecipeFlags& flags) {
  const std::string shown = key.show(road::Recipe{});
  std::string text = key.meaning;
  const bool alone = road::is_switch(key);
  if (!shown.empty() && !alone) text += " [" + shown + "]";
  if (alone)
    return command.add_flag_callback(
        flag, [&flags, name = key.name] { flags.emplace_back(name, "true"); }, text);
  if (key.wanted.ends_with(" ..."))  // words that may stand one by one
    return command
        .add_option_function<std::vector<std::string>>(
            flag,
            [&flags, name = key.name](const std::vector<std::string>& words) {
              std::string value;
              for (const std::string& word : words) value += (value.empty() ? "" : " ") + word;
              flags.emplace_back(name, value);
            },
            text)
        ->type_name(key.wanted);
  return command
      .add_option_function<std::string>(
          flag,
          [&flags, name = key.name](const std::string& value) {
            const bool object = name == "start_near_m" && !is_point(value);
            flags.emplace_back(object ? "start_object" : name, value);
          },
          text)
      ->type_name(key.wanted);
}

/// One flag per recipe key of these stages, or of these names: u_step_m becomes --u-step-m.
void add_recipe_flags(CLI::App& command, RecipeFlags& flags,
                      std::initializer_list<const char*> stages, Keys keys = Keys::of_these) {
  const auto listed = [&](const std::string& word) {
    return std::find(stages.begin(), stages.end(), word) != stages.end();
  };
  for (const road::RecipeKey& key : road::recipe_keys()) {
    if ((listed(key.stage) || listed(key.name)) != (keys == Keys::of_these)) continue;
    const std::string group = key.stage == "output" ? "Output" : "Stage: " + key.stage;
    const auto* const other = std::find_if(kOtherFlags.begin(), kOtherFlags.end(),
                                           [&](const OtherFlag& o) { return o.key == key.name; });
    std::string as_key = "--" + key.name;
    std::replace(as_key.begin(), as_key.end(), '_', '-');
    CLI::Option* const option = add_recipe_flag(command, key, as_key, flags);
    option->group(group);
    if (other == kOtherFlags.end()) {
      if (!is_often_given(key.name)) command::hide(option);
      continue;
    }
    if (other->takes != nullptr)
      add_recipe_flag(command, key, other->flag, flags)
          ->type_name(other->takes)
          ->description(other->text)
          ->group(group);
    command::hide_old(option, other->flag);
  }
}

struct Commands {
  BuildCommand build;
  StretchCommand stretch;
  FromEdgesCommand from_edges;
  CleanCommand clean;
  PreviewCommand preview;
  ObjectsCommand objects;
  CentrelineCommand centreline;
  SampleCommand sample;
  KerbCommand kerb;
  SmoothCommand smooth;
  AlignCommand align;
  ValidateCommand validate;
  ReportCommand report;
  InfoCommand info;
  QueryCommand query;
  CheckCommand check;
  ConvertCommand convert;
  CropCommand crop;
  ResampleCommand resample;
  ReverseCommand reverse;
  AppendCommand append;
  TransformCommand transform;
  SynthCommand synth;
  ExportCommand export_road;
};

constexpr const char* kMeshHelp =
    "the track: a mesh (.obj .fbx .glb .dae .ply .stl .3ds .ac ...) or a track.yaml";

void define_main_way(CLI::App& app, Commands& c) {
  CLI::App* build =
      app.add_subcommand("build", "a mesh becomes a checked OpenCRG road: all stages");
  add_input(*build, "input", c.build.input, kMeshHelp)->required();
  add_output_folder(*build, c.build.output_dir, "folder for the results, made if missing")
      ->required();
  add_recipe_flags(*build, c.build.values, {"input"}, Keys::of_all_but_these);
  CLI::App* name = build;
  name->add_option_function<std::string>(
          "--name", [&c](const std::string& v) { c.build.values.emplace_back("name", v); },
          "files are called <name>.crg, <name>.png, ... [the mesh's name]")
      ->type_name("NAME");
  build->add_flag("!--no-report", c.build.report,
                  "leave out report.html and report.json, and the time they take");
  build->add_flag("--force", c.build.force,
                  "build even when nothing has changed since the files in the folder were built");
  build->footer(
      "Writes <name>.crg (the road), <name>.png (look at it first), report.html (what is wrong "
      "with\n"
      "the road, and where), report.json and summary.json (every number), <name>.stl (the surface "
      "that\n"
      "was kept) and centreline.csv into the folder. Every key of a track.yaml is a flag, also "
      "those "
      "that\n"
      "are not listed here (docs/formats.md): kerb_min_height_m is --kerb-min-height-m.\n\n"
      "Examples:\n"
      "  crgbuild build track.obj -o out\n"
      "  crgbuild build track.fbx -o out --up y --unit cm --v-max-m 12\n"
      "  crgbuild build tracks/g-track-1/track.yaml -o out --smooth-window-m 1\n\n"
      "Exit code 3 when the road must not be used: validation or the report found an error.");

  CLI::App* validate =
      app.add_subcommand("validate", "compares a .crg with the mesh it was made from");
  add_input(*validate, "crg", c.validate.crg, "the road")->required();
  add_input(*validate, "mesh", c.validate.mesh,
            "the mesh as the simulator exported it, or the track.yaml")
      ->required();
  add_recipe_flags(*validate, c.validate.flags, {"read", "align", "validate"});
  validate->footer(
      "Heights at random points between the nodes of the grid against vertical rays on the "
      "mesh.\n\n"
      "Example:\n  crgbuild validate out/track.crg track.obj\n\n"
      "Exit code 3 when the road must not be used.");
}

void define_from_edges(CLI::App& app, Commands& c) {
  CLI::App* edges =
      app.add_subcommand("from-edges", "a road between two surveyed edges, without a mesh");
  add_input(*edges, "left", c.from_edges.left,
            "points along the left edge: CSV with the columns x_m,y_m and, if wanted, z_m, or "
            "lat_deg,lon_deg[,h_m]; KML, GPX, GeoJSON; or, alone, a CSV of a line with widths: "
            "x_m,y_m,w_tr_right_m,w_tr_left_m")
      ->required();
  add_input(*edges, "right", c.from_edges.right,
            "points along the right edge; they need not correspond");
  add_output_folder(*edges, c.from_edges.output_dir, "folder for the results, made if missing")
      ->required();
  add_recipe_flags(*edges, c.from_edges.flags, {"output", "u_step_m", "v_step_m"});
  edges
      ->add_option(
          "--name", c.from_edges.name,
          "files are called <name>.crg, <name>.png, ... [what the names of both files share]")
      ->type_name("NAME");
  edges->add_flag("--open", c.from_edges.open,
                  "an open road, although both edges come round to their start");
  edges->footer(
      "u = 0 beside the first row of LEFT, u in the direction of its rows. Closed when both edges\n"
      "come round to their start. Writes <name>.crg, <name>.png, centreline.csv and "
      "summary.json.\n\n"
      "Examples:\n  crgbuild from-edges track_left.csv track_right.csv -o out\n"
      "  crgbuild from-edges left.kml right.kml -o out\n"
      "  crgbuild from-edges track.csv -o out");
}

void define_report(CLI::App& app, Commands& c) {
  CLI::App* report = app.add_subcommand(
      "report", "what is wrong with a road file, and where: one page to look at");
  add_input(*report, "crg", c.report.crg, "the road")->required();
  add_output_folder(*report, c.report.output_dir,
                    "folder for report.html and report.json, made if missing")
      ->required();
  add_input(*report, "--mesh", c.report.mesh,
            "the mesh that the road should follow, or the track.yaml");
  add_input(*report, "--against", c.report.against, "another road file: what differs");
  add_input(*report, "--cloud", c.report.cloud,
            "measured points in the frame of the road, or a folder of them",
            command::kFileOrFolder);
  add_input(*report, "--before", c.report.before,
            "the same road before smoothing and kerb refinement");
  add_input(*report, "--grip", c.report.grip,
            "a road file with friction in place of heights, a colour");
  add_recipe_flags(*report, c.report.flags, {"read", "align"});
  report->footer(
      "Examples:\n"
      "  crgbuild report track.crg -o out\n"
      "  crgbuild report out/track.crg --mesh track.obj -o out\n"
      "  crgbuild report new.crg --against old.crg -o out\n\n"
      "Exit code 3 when the road is not usable; the report is written all the same.");
}

void define_stretch(CLI::App& app, Commands& c) {
  CLI::App* stretch = app.add_subcommand(
      "stretch", "some rows of the road that build would make, in a fraction of the time");
  add_input(*stretch, "input", c.stretch.input, kMeshHelp)->required();
  stretch->add_option("--u-begin-m", c.stretch.u_begin_m, "where it begins, of the whole road")
      ->required();
  stretch
      ->add_option("--u-end-m", c.stretch.u_end_m,
                   "where it ends; smaller than the begin: over the start")
      ->required();
  stretch->add_option("--build", c.stretch.build,
                      "folder of a build of the same mesh: its cleaned mesh is taken where nothing "
                      "that it depends on has changed");
  add_output_file(*stretch, c.stretch.output, "the road, .crg")->required();
  add_recipe_flags(*stretch, c.stretch.flags, {"input", "patch", "friction", "validate"},
                   Keys::of_all_but_these);
  stretch->footer(
      "To look at what a change of a recipe does. The heights are those of the whole road; within "
      "half a\n"
      "window of the ends smoothing knows less, and columns at kerbs are those of its own kerbs.\n"
      "No report, no checks, no friction, no patches.\n\n"
      "Example:\n"
      "  crgbuild stretch track.yaml --u-begin-m 400 --u-end-m 600 --build out -o stretch.crg");
}

/// Stages 1 and 2: from the mesh to the line.
void define_line_stages(CLI::App& app, Commands& c) {
  CLI::App* clean = app.add_subcommand("clean", "stage 1: keeps the drivable surface of a mesh");
  add_input(*clean, "input", c.clean.input, kMeshHelp)->required();
  add_output_file(*clean, c.clean.output,
                  "surface: .obj or .stl (both keep road, kerb and run-off apart), or .ply")
      ->required();
  add_recipe_flags(*clean, c.clean.flags, {"read", "clean"});
  clean->footer("Example:\n  crgbuild clean track.fbx -o surface.obj");

  CLI::App* preview =
      app.add_subcommand("preview", "a mesh to look at: each object in the colour of its class");
  add_input(*preview, "input", c.preview.input, kMeshHelp)->required();
  add_output_file(*preview, c.preview.output, "picture in three dimensions (.glb)")->required();
  command::hide(preview->add_option("--most-triangles", c.preview.most_triangles)
                    ->check(CLI::Range(std::size_t{100}, std::size_t{50'000'000})));
  preview->add_flag("--raw", c.preview.raw,
                    "without what cleaning would say of it: all in grey, in a tenth of the time");
  add_recipe_flags(*preview, c.preview.flags, {"read", "clean"});
  preview->footer(
      "Opens in Blender, in any viewer of glTF and in 'kerbstone view'. A mesh of which no road "
      "can be\n"
      "made is shown too, with the reason.\n\n"
      "Example:\n  crgbuild preview track.fbx -o track.glb");

  CLI::App* objects =
      app.add_subcommand("objects", "lists the objects of a mesh: what each is taken for, and why");
  add_input(*objects, "input", c.objects.input, kMeshHelp)->required();
  add_recipe_flags(*objects, c.objects.flags, {"read", "clean"});
  objects->footer(
      "Columns: class, area, median height above the road that lies over or under it, triangles,\n"
      "object, material, and what tells: a name rule, shape, colour or the guide. Where the class "
      "is\n"
      "wrong, a rule in track.yaml says what is right:\n"
      "  name_rules:\n"
      "    - {object: '^Plate$', class: scenery}\n\n"
      "Example:\n  crgbuild objects track.fbx");

  CLI::App* centreline = app.add_subcommand("centreline", "stage 2: traces the middle of the road");
  add_input(*centreline, "input", c.centreline.input,
            "surface from 'clean' (or a mesh or track.yaml, cleaned first)")
      ->required();
  add_output_file(*centreline, c.centreline.output, "CSV: x_m,y_m,z_m,half_width_m")->required();
  add_recipe_flags(*centreline, c.centreline.flags, {"read", "clean", "centreline"});
  centreline->footer(
      "Example:\n  crgbuild centreline surface.obj -o centreline.csv --start-at 120,-35.5");
}

/// Stages 3 to 6: what becomes of the heights.
void define_grid_stages(CLI::App& app, Commands& c) {
  CLI::App* sample = app.add_subcommand("sample", "stage 3: heights along and across the road");
  add_input(*sample, "input", c.sample.input,
            "surface from 'clean' (or a mesh or track.yaml, cleaned first)")
      ->required();
  add_input(*sample, "--centreline", c.sample.centreline,
            "CSV from 'centreline', or your own with x_m,y_m,z_m,half_width_m")
      ->required();
  add_output_file(*sample, c.sample.output, "the road, .crg")->required();
  add_recipe_flags(*sample, c.sample.flags,
                   {"read", "clean", "reference_line", "sample", "output"});
  sample->footer(
      "Example:\n  crgbuild sample surface.obj --centreline centreline.csv -o sampled.crg "
      "--u-step-m 0.05");

  CLI::App* kerb = app.add_subcommand("kerb", "stage 4: finer columns where kerbs are");
  add_input(*kerb, "crg", c.kerb.crg, "road from 'sample', in the frame of the mesh")->required();
  add_input(*kerb, "--mesh", c.kerb.mesh,
            "surface from 'clean' (or a mesh or track.yaml, cleaned first)")
      ->required();
  add_output_file(*kerb, c.kerb.output, "the road, .crg")->required();
  add_recipe_flags(*kerb, c.kerb.flags, {"read", "clean", "kerb", "output"});
  kerb->footer("Example:\n  crgbuild kerb sampled.crg --mesh surface.obj -o kerbs.crg");

  CLI::App* smooth =
      app.add_subcommand("smooth", "stage 5: moving average of the heights along the road");
  add_input(*smooth, "crg", c.smooth.crg, "road from 'kerb' or 'sample', in the frame of the mesh")
      ->required();
  add_input(*smooth, "--mesh", c.smooth.mesh,
            "surface from 'clean': tells where the kerbs are, which stay as they are");
  smooth->add_flag("--ignore-kerbs", c.smooth.ignore_kerbs,
                   "without --mesh: treat everything as road");
  add_output_file(*smooth, c.smooth.output, "the road, .crg")->required();
  add_recipe_flags(*smooth, c.smooth.flags, {"read", "clean", "kerb_zones", "smooth", "output"});
  smooth->footer(
      "Example:\n  crgbuild smooth kerbs.crg --mesh surface.obj --smooth-window-m 1 -o smooth.crg");

  CLI::App* align =
      app.add_subcommand("align", "stage 6: from the mesh's frame to global coordinates");
  add_input(*align, "crg", c.align.crg, "the road")->required();
  add_output_file(*align, c.align.output, "the road, .crg")->required();
  add_recipe_flags(*align, c.align.flags, {"align", "output"});
  align->footer(
      "Control points: a CSV with the columns name,mesh_x_m,mesh_y_m,mesh_z_m and x_m,y_m,z_m or\n"
      "lat_deg,lon_deg,h_m. A trajectory: a CSV with the columns of either kind, driven on the "
      "road.\n\n"
      "Examples:\n"
      "  crgbuild align smooth.crg --control-points points.csv -o global.crg\n"
      "  crgbuild align smooth.crg --yaw-deg 12.5 --translation-m 500000,5400000,310 -o "
      "global.crg");
}

constexpr const char* kSetHelp =
    "an option or modifier of the standard, e.g. SCALE_Z_GRID=2 (repeatable)";

/// Input, output and format of the commands that edit a road.
template <class Command>
CLI::App* add_edit(CLI::App& app, const std::string& name, const std::string& text,
                   Command& command, const std::string& example) {
  CLI::App* edit = app.add_subcommand(name, text);
  if constexpr (requires { command.crg; }) {
    add_input(*edit, "crg", command.crg, "the road")->required();
  } else {
    add_input(*edit, "first", command.first, "the road to drive first")->required();
    add_input(*edit, "second", command.second, "the road that follows")->required();
  }
  add_output_file(*edit, command.output, "the edited road, .crg")->required();
  add_choice(*edit, "--format", command.format, "of the payload [as the input]",
             {"krbi", "kdbi", "lrfi", "ldfi"});
  edit->footer("Example:\n  crgbuild " + name + " " + example);
  return edit;
}

CLI::Option* add_metres(CLI::App& command, const std::string& flag, std::optional<double>& value,
                        const std::string& text) {
  return command.add_option(flag, value, text)->type_name("m");
}

void define_edits(CLI::App& app, Commands& c) {
  CLI::App* check =
      app.add_subcommand("check", "does a .crg file keep the rules and agree with itself?");
  add_input(*check, "crg", c.check.crg, "the road")->required();
  check->footer(
      "Example:\n  crgbuild check out/track.crg\n\nExit code 3 when there are errors: of the file,"
      " or of the build beside it.\nThe road itself is looked at by report.");

  add_edit(app, "convert", "writes a .crg in another payload format", c.convert,
           "road.crg -o text.crg --format lrfi");
  CLI::App* crop = add_edit(app, "crop", "keeps a part of a road", c.crop,
                            "road.crg -o part.crg --u-begin-m 100 --u-end-m 400");
  add_metres(*crop, "--u-begin-m", c.crop.u_begin_m, "first u to keep, the row next to it [all]");
  add_metres(*crop, "--u-end-m", c.crop.u_end_m, "last u to keep, the row next to it [all]");
  add_metres(*crop, "--v-right-m", c.crop.v_right_m, "rightmost v to keep [all]");
  add_metres(*crop, "--v-left-m", c.crop.v_left_m, "leftmost v to keep [all]");
  CLI::App* resample = add_edit(app, "resample", "puts a road on another grid", c.resample,
                                "road.crg -o fine.crg --u-step-m 0.05 --v-step-m 0.05");
  add_metres(*resample, "--u-step-m", c.resample.u_step_m, "wanted row spacing [as it is]");
  add_metres(*resample, "--v-step-m", c.resample.v_step_m, "wanted column spacing [as it is]");
  add_edit(app, "reverse", "turns a road round: last row first, left and right exchanged",
           c.reverse, "road.crg -o back.crg");
  CLI::App* append = add_edit(app, "append", "joins two roads end to start", c.append,
                              "first.crg second.crg -o both.crg");
  append->add_flag("--move", c.append.move,
                   "bring the second road to the end of the first, turned and raised to fit");
  CLI::App* transform = add_edit(
      app, "transform", "works modifiers into the data: scales, fills NaN, moves", c.transform,
      "road.crg -o moved.crg --set REFLINE_OFFSET_X=100 --set SCALE_Z_GRID=2");
  transform
      ->add_option("--set", c.transform.settings,
                   "a modifier of the standard on top of those in the file (repeatable)")
      ->type_name("KEY=VALUE");
}

/// Formats, and the flags that they had before: --xodr is -o NAME.xodr now.
void add_old_formats(CLI::App& exported, std::string& format) {
  for (const auto& [word, now] : {std::pair{"xodr", "-o NAME.xodr"},
                                  {"rdf", "-o NAME.rdf"},
                                  {"mesh", "-o NAME.glb"},
                                  {"geojson", "-o NAME.geojson"},
                                  {"kml", "-o NAME.kml"},
                                  {"svg", "-o NAME.svg"},
                                  {"tum", "-o NAME.csv"},
                                  {"heightmap", "-o NAME.png"},
                                  {"mat", "-o NAME.mat"}})
    command::hide_old(exported.add_flag_callback(std::string("--") + word,
                                                 [&format, word = std::string(word)] {
                                                   if (!format.empty() && format != word)
                                                     throw CLI::ValidationError(
                                                         "export", "one format is wanted: --" +
                                                                       format + " or --" + word);
                                                   format = word;
                                                 }),
                      now);
}

void define_export(CLI::App& app, Commands& c) {
  CLI::App* exported = app.add_subcommand("export", "a road in a format of other programs");
  add_input(*exported, "crg", c.export_road.crg, "the road")->required();
  add_output_file(*exported, c.export_road.output,
                  "the exported file; its ending says the format, see below")
      ->required();
  add_choice(*exported, "--format", c.export_road.format,
             "where the ending of the output does not say it",
             {"xodr", "rdf", "mesh", "geojson", "kml", "svg", "tum", "heightmap", "mat"});
  add_old_formats(*exported, c.export_road.format);
  add_input(*exported, "--grip", c.export_road.friction_crg,
            "for .xodr and .rdf: a CRG whose heights are friction coefficients");
  exported
      ->add_option(
          "--step-m", c.export_road.step_m,
          "of triangles: distance of the rows along the road; of height maps: of the samples")
      ->check(CLI::Range(0.001, 100.0))
      ->capture_default_str();
  exported->footer(
      "  .xodr                ASAM OpenDRIVE 1.8: line, lanes, elevation, superelevation, the CRG "
      "attached\n"
      "  .rdf                 road data file of tyre models that names the CRG\n"
      "  .glb .obj .ply .stl  triangles of road and kerb\n"
      "  .png .raw            height map, 16 bits a sample; beside it a .json says where\n"
      "  .mat                 MATLAB level 5: line and heights as variables, 8 bytes a number\n"
      "  .geojson .kml        reference line, borders, start and kerbs in latitude and longitude\n"
      "  .svg                 the same as a drawing, 1 unit a metre\n"
      "  .csv                 racing line: x_m,y_m,w_tr_right_m,w_tr_left_m, no heights\n\n"
      "What a format cannot hold is listed. Modifiers of the file are worked in. A width ends at "
      "the edge in summary.json beside the road, else at the last column before the first NaN.\n\n"
      "Examples:\n  crgbuild export out/track.crg -o out/track.xodr\n"
      "  crgbuild export out/track.crg -o track.glb\n"
      "  crgbuild export out/track.crg --step-m 0.25 -o track.png\n"
      "  crgbuild export out/track.crg -o track.csv");
}

void define_file_tools(CLI::App& app, Commands& c) {
  CLI::App* info = app.add_subcommand("info", "what a .crg file holds");
  add_input(*info, "crg", c.info.crg, "the road")->required();
  info->footer("Example:\n  crgbuild info out/track.crg --json");

  CLI::App* query =
      app.add_subcommand("query", "height, heading, curvature and gradient at points");
  add_input(*query, "crg", c.query.crg, "the road")->required();
  add_input(*query, "--points", c.query.points,
            "CSV with the columns x_m and y_m, or u_m and v_m; -: standard input",
            command::kFileOrDash)
      ->required();
  add_output_file(
      *query, c.query.output,
      "CSV: x_m,y_m,u_m,v_m,z_m,heading_rad,curvature_1pm,dzdx,dzdy; cells are empty where "
      "there is no road")
      ->required();
  query->add_option("--threads", c.query.threads, "0: all cores")->check(CLI::Range(0, 1024));
  add_choice(
      *query, "--modifiers", c.query.modifiers,
      "file: those of the file; none; reference: as file, but where the file has no such "
      "section, what the reference C API does: fill NaN and move the right edge at the start "
      "to the origin [file]",
      {"file", "none", "reference"});
  std::string& modifiers = c.query.modifiers;
  CLI::Option* none =
      query->add_flag_callback("--no-modifiers", [&modifiers] { modifiers = "none"; });
  command::hide_old(none, "--modifiers none");
  command::hide_old(
      query->add_flag_callback("--reference-defaults", [&modifiers] { modifiers = "reference"; }),
      "--modifiers reference")
      ->excludes(none);
  query->add_option("--set", c.query.settings, kSetHelp)->type_name("KEY=VALUE");
  query->footer(
      "Modifiers in the file are applied; where it has no such section, none are. --set comes on\n"
      "top of either; REFPOINT_* wins over REFLINE_*.\n\n"
      "Examples:\n"
      "  crgbuild query out/track.crg --points points.csv -o heights.csv\n"
      "  crgbuild query road.crg --points p.csv -o z.csv --modifiers none --set BORDER_MODE_V=0");

  CLI::App* synth =
      app.add_subcommand("synth", "makes a mesh and its exact road from a drawn circuit");
  add_input(*synth, "circuit", c.synth.circuit, "circuit.yaml")->required();
  add_output_folder(*synth, c.synth.output_dir, "folder for mesh and truth, made if missing")
      ->required();
  add_choice(*synth, "--format", c.synth.format, "of the mesh [obj]", {"obj", "glb", "ply", "stl"});
  add_choice(*synth, "--up", c.synth.up, "axis of the mesh that points up [y]", {"y", "z"});
  add_choice(*synth, "--unit", c.synth.unit, "of the mesh's coordinates [m]",
             {"m", "cm", "mm", "ft", "inch", "yard"});
  synth
      ->add_option("--step-m", c.synth.facet_m, "length of facets on straights; 10 is coarse [0.5]")
      ->check(CLI::Range(0.05, 50.0));
  add_choice(*synth, "--names", c.synth.names, "how objects are called [plain]",
             {"plain", "torcs", "ac", "none"});
  synth->footer("Example:\n  crgbuild synth tracks/kerbstone-ring/circuit.yaml -o out/demo");
}

/// Stages know no files: their errors get the name of the input in front.
template <class Run>
int naming(const std::string& input, const Run& run) {
  try {
    return run();
  } catch (const road::Error& error) {
    const std::string text = road::with_input_named(input, error.what());
    if (dynamic_cast<const road::NotUsable*>(&error) != nullptr) throw NotValid(text);
    throw road::Error(text);
  }
}

int run(const CLI::App& app, const Commands& c, Terminal& terminal) {
  const std::string name = app.get_subcommands().front()->get_name();
  if (name == "build") return naming(c.build.input, [&] { return run_build(c.build, terminal); });
  if (name == "stretch")
    return naming(c.stretch.input, [&] { return run_stretch(c.stretch, terminal); });
  if (name == "from-edges")
    return naming(c.from_edges.left, [&] { return run_from_edges(c.from_edges, terminal); });
  if (name == "preview")
    return naming(c.preview.input, [&] { return run_preview(c.preview, terminal); });
  if (name == "objects")
    return naming(c.objects.input, [&] { return run_objects(c.objects, terminal); });
  if (name == "clean") return naming(c.clean.input, [&] { return run_clean(c.clean, terminal); });
  if (name == "centreline")
    return naming(c.centreline.input, [&] { return run_centreline(c.centreline, terminal); });
  if (name == "sample")
    return naming(c.sample.input, [&] { return run_sample(c.sample, terminal); });
  if (name == "kerb") return naming(c.kerb.mesh, [&] { return run_kerb(c.kerb, terminal); });
  if (name == "smooth") return naming(c.smooth.crg, [&] { return run_smooth(c.smooth, terminal); });
  if (name == "align") return naming(c.align.crg, [&] { return run_align(c.align, terminal); });
  if (name == "validate")
    return naming(c.validate.mesh, [&] { return run_validate(c.validate, terminal); });
  if (name == "report") return naming(c.report.crg, [&] { return run_report(c.report, terminal); });
  if (name == "info") return run_info(c.info, terminal);
  if (name == "query") return run_query(c.query, terminal);
  if (name == "check") return run_check(c.check, terminal);
  if (name == "convert") return run_convert(c.convert, terminal);
  if (name == "crop") return run_crop(c.crop, terminal);
  if (name == "resample") return run_resample(c.resample, terminal);
  if (name == "reverse") return run_reverse(c.reverse, terminal);
  if (name == "append") return run_append(c.append, terminal);
  if (name == "transform") return run_transform(c.transform, terminal);
  if (name == "export")
    return naming(c.export_road.crg, [&] { return run_export(c.export_road, terminal); });
  return run_synth(c.synth, terminal);
}

int main_with(int argc, char** argv) {
  CLI::App app("crgbuild: from a simulator's track mesh to a checked OpenCRG road.", "crgbuild");
  Terminal terminal("crgbuild");
  Commands commands;
  app.require_subcommand(1);
  app.get_formatter()->column_width(44);
  app.footer(
      "First steps:\n"
      "  crgbuild build track.obj -o out     everything; then look at out/track.png\n"
      "  crgbuild info out/track.crg         what the file holds\n"
      "  crgbuild build --help               all options and more examples");
  define_main_way(app, commands);
  define_from_edges(app, commands);
  define_report(app, commands);
  define_file_tools(app, commands);
  define_edits(app, commands);
  define_export(app, commands);
  define_stretch(app, commands);
  define_line_stages(app, commands);
  define_grid_stages(app, commands);
  return command::run(app, terminal, argc, argv, [&] { return run(app, commands, terminal); },
                      {"take larger steps (--u-step-m, --v-step-m) or a smaller --v-max-m",
                       "to make a road of it: crgbuild build -o out "});
}

}  // namespace
}  // namespace crgbuild

int main(int argc, char** argv) { return crgbuild::main_with(argc, argv); }
