#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/write_file.h"
#include "campaign/results.h"
#include "command/exit_code.h"
#include "commands.h"

namespace kerbstone {
namespace {

using campaign::State;

constexpr std::size_t kMostNamed = 20;  // on the terminal; the page names all

std::string text_of(const campaign::Campaign& results, const std::string& page) {
  std::string text;
  std::size_t troubles = 0;
  for (const campaign::Job& job : results.jobs)
    if (job.state != State::done && ++troubles <= kMostNamed)
      text += fmt::format("  {}: {}{}{}\n", job.id, campaign::word_of(job.state),
                          job.message.empty() ? "" : ": ", job.message);
  if (troubles > kMostNamed) text += fmt::format("  and {} more\n", troubles - kMostNamed);
  return fmt::format("{}: {} of {} jobs done; {}\n", results.name, results.jobs.size() - troubles,
                     results.jobs.size(), page) +
         text;
}

std::string json_of(const campaign::Campaign& results, const std::string& page) {
  nlohmann::ordered_json jobs = nlohmann::ordered_json::array();
  for (const campaign::Job& job : results.jobs)
    jobs.push_back(
        {{"job", job.id}, {"state", campaign::word_of(job.state)}, {"message", job.message}});
  return base::json_text(
      nlohmann::ordered_json{{"name", results.name}, {"page", page}, {"jobs", std::move(jobs)}});
}

}  // namespace

int collect(const CollectCommand& command, command::Terminal& terminal) {
  terminal.start("collecting");
  const campaign::Campaign results = campaign::read_campaign(command.folder);
  const std::string page = command.folder + "/index.html";
  const std::string table = campaign::table_of(results), database = campaign::database_of(results),
                    html = campaign::page_of(results);
  base::write_file(command.folder + "/campaign.csv", table);
  base::write_file(command.folder + "/campaign.sqlite", database);
  base::write_file(page, html);
  terminal.print(terminal.json ? json_of(results, page) : text_of(results, page));
  for (const campaign::Job& job : results.jobs)
    if (job.state != State::done) return command::kNotValid;
  return 0;
}

}  // namespace kerbstone
