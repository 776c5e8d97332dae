// One name for all tools, and what is about all of them; options in, one call, exit code.
#include <functional>
#include <string>
#include <vector>

#include "command/program.h"
#include "commands.h"
#include "verbs.h"

namespace {

CLI::App* add_open(CLI::App& app, kerbstone::OpenCommand& opened) {
  CLI::App* const open_app = app.add_subcommand(
      "open", "Channels of a log of any maker: unit, rate, range, what is dead; as a page or MCAP");
  command::add_input(*open_app, "log", opened.log, "A log, or a folder that rosbag2 wrote",
                     command::kFileOrFolder)
      ->required();
  command::add_output_file(*open_app, opened.out,
                           "Also writes it: .html draws curves, .mcap is for Foxglove and "
                           "PlotJuggler, .csv (or -) for all others");
  open_app->add_option("--channel", opened.channels,
                       "A channel that the page draws; may be repeated [the first that live]");
  open_app->footer(
      "Nothing is guessed: a unit that the file does not name stays empty. `crgexplain map` "
      "guesses what the channels are.\n\nExamples:\n  kerbstone open run3.vbo\n  kerbstone open "
      "run3.ld -o "
      "run3.html --channel 'Ground Speed'");
  return open_app;
}

}  // namespace

int main(int argc, char** argv) {
  command::Terminal terminal("kerbstone");
  std::vector<std::string> words = {argv + 1, argv + argc};
  if (!words.empty() && words[0] == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  if (const std::vector<std::string> owner = kerbstone::words_of_owner(words); !owner.empty()) {
    kerbstone::make_tools_found(kerbstone::own_folder());
    terminal.error(kerbstone::become(owner));
    return command::kFailed;
  }
  CLI::App app{"Roads from meshes and scans, cars on them, and what recordings say of both",
               "kerbstone"};
  app.require_subcommand(1);
  app.footer(kerbstone::verbs_text() +
             "\nFirst steps:\n  kerbstone try                       every step once, on a circuit "
             "that is made, "
             "in two minutes\n  kerbstone build track.obj -o out    a road; then look at "
             "out/track.png\n  kerbstone build --help              options and examples of a verb\n"
             "  kerbstone view                      the page that shows all of it");
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
  view_app->add_option("--stop-s", view.seconds, "Ends by itself after so long; 0: only by Ctrl-C")
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

  kerbstone::OpenCommand opened;
  CLI::App* const open_app = add_open(app, opened);
  open_app->callback([&] { run = [&] { return kerbstone::open(opened, terminal); }; });

  kerbstone::TryCommand tour;
  CLI::App* const try_app = app.add_subcommand(
      "try", "Two minutes: a mesh, a road, scans, a car, a recording with a hidden fault, found");
  command::add_output_folder(*try_app, tour.output, "Folder for all that it makes");
  try_app->add_flag("--no-open", tour.no_open, "No page is opened at the end");
  try_app->add_option("--seed", tour.seed, "What is hidden; else at random");
  try_app->footer("Example:\n  kerbstone try -o tour");
  try_app->callback([&] { run = [&] { return kerbstone::try_it(tour, terminal); }; });

  command::Advice advice;
  for (const kerbstone::Verb& verb : kerbstone::verbs()) advice.elsewhere.emplace_back(verb.name);
  std::vector<char*> arguments = {argv[0]};
  for (std::string& word : words) arguments.push_back(word.data());
  return command::run(
      app, terminal, static_cast<int>(arguments.size()), arguments.data(), [&] { return run(); },
      advice);
}
