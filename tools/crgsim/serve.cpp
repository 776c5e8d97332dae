#include <optional>
#include <string_view>

#include "base/json_text.h"
#include "commands.h"
#include "served_run.h"
#include "sim/serve_unit.h"

namespace crgsim {

int serve(const ServeCommand& command, Terminal& terminal) {
  want_one_connection(command);
  if (!command.dds && (command.commands.empty() || command.measurements.empty()))
    throw command::UsageError("--command NAME and --measure NAME are wanted, but with --dds");
  sim::ServeOptions options = options_of(command);
  std::optional<base::GrowingFile> table, remarks, sights;
  const auto file = [&](std::optional<base::GrowingFile>& it,
                        const std::string& path) -> base::GrowingFile& {
    say_killed(it.emplace(path), terminal);
    return *it;
  };
  options.keep_row = [](const auto&, const auto&) {};
  if (!command.out_path.empty()) options.keep_row = rows_into(file(table, command.out_path));
  if (table && !table->is_written_through())
    options.keep_remark = lines_into(file(remarks, remarks_path(command.out_path)));
  if (!command.sights_path.empty()) {
    options.keep_sight = lines_into(file(sights, command.sights_path));
    sights->append("");
  }
  terminal.start("waiting for commands");
  const sim::ServeRun run = sim::serve_unit(command.unit_path, options, terminal.progress());
  terminal.progress_done();
  for (const std::string& remark : remarks_of(run)) terminal.remark(remark);
  for (auto* const one : {&table, &remarks, &sights})
    if (*one) (*one)->finish();
  terminal.print(terminal.json ? base::json_text(json_of(run)) : summary_of(run, command.step_s));
  return is_sound(run) ? kOk : command::kNotValid;
}

}  // namespace crgsim
