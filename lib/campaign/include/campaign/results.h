// What the jobs of a campaign gave: read from its folder, written as a page, a table and a
// database.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace campaign {

/// How a job ended. A job is one command of a tool; its exit code tells (docs/command_line.md).
enum class State {
  done,         ///< exit code 0
  not_usable,   ///< exit code 3: done, but the result must not be used
  failed,       ///< the command said why it could not be done
  blocked,      ///< not begun: a job that it needs gave nothing that can be used
  not_run,      ///< nothing is known of it: not begun yet, or killed
  output_gone,  ///< ended well, but a file that it wrote is missing or has another size now
};

/// The word for it on the page, in tables and messages: "done", "not usable" ...
const char* word_of(State state);

/// One number or word of a job's result. Numbers are in SI units.
struct Fact {
  std::string name, unit;  ///< unit is empty for counts, ratios and words
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN where `text` stands for it
  std::string text;
};

struct Output {
  std::string path;  ///< relative to the campaign's folder
  std::uint64_t bytes = 0;
  std::string sha256;
};

struct Job {
  std::string id, kind, subject;  ///< id is KIND/SUBJECT
  State state = State::not_run;
  int exit_code = -1;   ///< -1: it has none
  std::string message;  ///< why it is not done; one line
  std::string page;     ///< a page to open, relative to the folder; empty where it has none
  std::vector<Fact> facts;
  std::vector<Output> outputs;
};

struct Campaign {
  std::string name;
  std::vector<Job> jobs;  ///< in the order of the plan
};

/// Reads plan.json and state/*.json of a campaign's folder (docs/campaigns.md). Outputs are looked
/// for by their size, not hashed. A job whose state cannot be read has the state `failed` and says
/// so. Throws base::Error: plan.json is missing, is no plan, or names a path outside the folder.
Campaign read_campaign(const std::string& folder);

/// One file without references to anything outside the folder; text is escaped, links are relative.
std::string page_of(const Campaign& campaign);

/// One row per fact, and one for a job without any: job,kind,subject,state,fact,value,unit,text.
std::string table_of(const Campaign& campaign);

/// Tables job, fact and output as the bytes of an SQLite 3 file, the same for the same campaign.
/// Throws base::Error when SQLite cannot.
std::string database_of(const Campaign& campaign);

}  // namespace campaign
