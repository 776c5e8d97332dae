// What is about all other tools; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{
      "The page of Kerbstone (docs/view.md), and what the jobs of a campaign gave "
      "(docs/campaigns.md)",
      "kerbstone"};
  app.require_subcommand(1);
  command::Terminal terminal("kerbstone");
  app.option_defaults()->always_capture_default();  // so that --help shows them
  std::function<int()> run;

  kerbstone::CollectCommand collect;
  CLI::App* const collect_app = app.add_subcommand(
      "collect", "Writes index.html, campaign.csv and campaign.sqlite into a campaign's folder");
  command::add_input(*collect_app, "campaign", collect.folder,
                     "Where the campaign's jobs wrote: the folder with plan.json", command::kFolder)
      ->required();
  collect_app->footer("Example:\n  kerbstone collect out/season");
  collect_app->callback([&] { run = [&] { return kerbstone::collect(collect, terminal); }; });

  kerbstone::ViewCommand view;
  CLI::App* const view_app = app.add_subcommand(
      "view", "A page on this machine: look at meshes, roads and laps, change recipes, build");
  command::add_input(*view_app, "paths", view.paths,
                     "Folders to show, or one file to begin with, whose folder is shown [.]",
                     command::kFileOrFolder);
  view_app->add_flag("--no-open", view.no_open, "Prints the address and starts no browser");
  view_app->add_option("--port", view.port, "0: any that is free")->check(CLI::Range(0, 65535));
  view_app->add_option("--seconds", view.seconds, "Ends by itself after so long; 0: only by Ctrl-C")
      ->check(CLI::Range(0.0, 1e7));
  CLI::Option* const token = view_app->add_option(
      "--token", view.token,
      "Part of the address, at least 16 letters and digits; else made at random");
  view_app
      ->add_option("--listen", view.host,
                   "Address of this machine that others reach too, with --token; else 127.0.0.1")
      ->needs(token);
  view_app->footer(
      "Whoever has the address may read what lies in the folders, write recipes and tables there\n"
      "and run the tools. Ctrl-C ends it, and the commands that it runs.\n\n"
      "Examples:\n  kerbstone view\n  kerbstone view tracks/kerbstone-ring/track.yaml --no-open");
  view_app->callback([&] { run = [&] { return kerbstone::view(view, terminal); }; });

  return command::run(app, terminal, argc, argv, [&] { return run(); });
}
