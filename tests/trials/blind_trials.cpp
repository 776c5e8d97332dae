// Blind trials of crgexplain: recordings from another car with sealed truths (docs/crgexplain.md).
#include <functional>

#include "command/program.h"
#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Blind trials of crgexplain: recordings from another car with sealed truths",
               "blind_trials"};
  command::Terminal terminal("blind_trials");
  app.require_subcommand(1);
  std::function<int()> chosen;
  const auto add_folder = [](CLI::App& sub, std::string& folder) {
    sub.add_option("folder", folder, "Folder of the trials")
        ->type_name(command::kFolder)
        ->required();
  };

  trials::MakeCommand make;
  CLI::App* const make_app =
      app.add_subcommand("make", "Draws recordings and seals the truths (SHA256SUMS)");
  command::add_input(*make_app, "--generator", make.generator, "The program make_trials")
      ->required();
  CLI::Option* const waves = make_app->add_flag(
      "--waves", make.waves,
      "Logs with suspension and disc channels, about short waves, contact and discs");
  make_app
      ->add_option("--third-share", make.third_share,
                   "Share of the trials that the third car drives; the others are the second car's")
      ->check(CLI::Range(0.0, 1.0))
      ->excludes(waves);
  make_app->add_option("--count", make.count, "How many")->check(CLI::Range(1, 9999));
  make_app->add_option("--seed", make.seed, "Another seed, other trials");
  add_folder(*make_app, make.folder);
  make_app->callback([&] { chosen = [&] { return trials::make(make, terminal); }; });

  trials::RunCommand run;
  CLI::App* const run_app = app.add_subcommand("run", "Explains every recording; sees no truth");
  run_app->add_option("--threads", run.threads, "0: all")->check(CLI::Range(0, 256));
  add_folder(*run_app, run.folder);
  run_app->callback([&] { chosen = [&] { return trials::run(run, terminal); }; });

  trials::ScoreCommand score;
  CLI::App* const score_app =
      app.add_subcommand("score", "Opens the seals and prints how often it was right");
  add_folder(*score_app, score.folder);
  score_app->callback([&] { chosen = [&] { return trials::score(score, terminal); }; });

  return command::run(app, terminal, argc, argv, [&] { return chosen(); });
}
