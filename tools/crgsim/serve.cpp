#include <optional>
#include <string_view>

#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "served_run.h"
#include "sim/serve_unit.h"

namespace crgsim {

int serve(const ServeCommand& command, Terminal& terminal) {
  want_one_connection(command);
  if (!command.dds && (command.commands.empty() || command.measurements.empty()))
    throw command::UsageError("--command NAME and --measure NAME are wanted, but with --dds");
  sim::ServeOptions options = options_of(command);
  std::optional<base::FileWriter> sights;
  if (!command.sights_path.empty()) {
    sights.emplace(command.sights_path);
    options.keep_sight = [&sights](std::string_view line) {
      sights->append(line);
      sights->append("\n");
    };
  }
  terminal.start("waiting for commands");
  const sim::ServeRun run = sim::serve_unit(command.unit_path, options, terminal.progress());
  terminal.progress_done();
  for (const std::string& remark : remarks_of(run)) terminal.remark(remark);
  if (sights) sights->commit();
  if (!command.out_path.empty())
    base::write_file(command.out_path, csv_of(run.columns, run.values));
  terminal.print(terminal.json ? base::json_text(json_of(run)) : summary_of(run, command.step_s));
  return run.counts.silent ? command::kNotValid : kOk;
}

}  // namespace crgsim
