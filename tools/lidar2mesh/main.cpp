// Options in, one command, exit code: 0 done, 1 failed, 2 wrong usage. The only file that knows CLI11.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <new>

#include "commands.h"

namespace lidar2mesh {
namespace {

using Run = std::function<int()>;

CLI::Option* add_unit(CLI::App& app, std::string& unit) {
  return app.add_option("--unit", unit, "of the cloud: m, ft, us-ft, cm, mm [as the file says, else m]")
      ->check(CLI::IsMember({"m", "ft", "us-ft", "cm", "mm"}));
}

void define_info(CLI::App& app, InfoCommand& c, Run& run) {
  CLI::App* const info = app.add_subcommand("info", "points, bounds, unit, classes and resolution of a cloud");
  info->add_option("cloud", c.cloud, "a .las, .ply, .pcd, .bin, .xyz or .csv, or a folder of them")->required();
  add_unit(*info, c.unit);
  info->add_flag("--json", c.json, "as JSON");
  info->footer("Example:\n  lidar2mesh info survey.las");
  info->callback([&] { run = [&] { return run_info(c); }; });
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return text;
}

int main_with(int argc, char** argv) {
  CLI::App app("lidar2mesh: refines the map of a road from LiDAR.", "lidar2mesh");
  app.set_version_flag("--version", "lidar2mesh " KERBSTONE_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(40);
  Run run;
  InfoCommand info;
  define_info(app, info, run);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return run();
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "lidar2mesh: not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "lidar2mesh: {}\n", one_line(error.what()));
  }
  return 1;
}

}  // namespace
}  // namespace lidar2mesh

int main(int argc, char** argv) { return lidar2mesh::main_with(argc, argv); }
