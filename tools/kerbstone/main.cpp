// What many runs of the other tools gave; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"What the jobs of a campaign gave (docs/campaigns.md)", "kerbstone"};
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

  return command::run(app, terminal, argc, argv, [&] { return run(); });
}
