#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/json_text.h"
#include "base/one_line.h"
#include "base/read_file.h"
#include "campaign/results.h"
#include "facts.h"

namespace campaign {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kLargestBytes = 256u << 20;  // ten thousand jobs are 10 MB

json parsed(const std::string& path) {
  json read = base::parse_json<json>(base::read_file(path, kLargestBytes), false);
  if (read.is_discarded() || !read.is_object())
    throw base::Error(fmt::format("{}: no JSON object; run the campaign again", path));
  return read;
}

/// A string of an object; empty where it is missing. Throws where it is something else.
std::string word(const json& object, const char* key, const std::string& path) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return "";
  if (!found->is_string()) throw base::Error(fmt::format("{}: '{}' is not a text", path, key));
  return found->get<std::string>();
}

/// Neither absolute nor leading out of the folder.
bool stays_inside(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  return !path.empty() && path.find('\0') == std::string::npos && normal.is_relative() &&
         *normal.begin() != "..";
}

std::string inside(const std::string& place, const std::string& path) {
  if (!stays_inside(place))
    throw base::Error(
        fmt::format("{}: path '{}' seen, one inside the campaign's folder wanted", path, place));
  return place;
}

Output output_of(const json& from, const std::string& path) {
  if (!from.is_object()) throw base::Error(fmt::format("{}: an output is not an object", path));
  const auto bytes = from.find("bytes");
  if (bytes == from.end() || !bytes->is_number_unsigned())
    throw base::Error(fmt::format("{}: an output without 'bytes'", path));
  return {inside(word(from, "path", path), path), bytes->get<std::uint64_t>(),
          word(from, "sha256", path)};
}

bool is_there(const fs::path& folder, const Output& output) {
  std::error_code missing;
  const auto bytes = fs::file_size(folder / output.path, missing);
  return !missing && bytes == output.bytes;
}

/// What state/KIND/SUBJECT.json says.
void read_state(const fs::path& folder, const std::string& path, Job& job) {
  const json state = parsed(path);
  const auto code = state.find("exit_code");
  job.message = base::one_line(word(state, "message", path));
  if (code != state.end() && code->is_number_integer()) job.exit_code = code->get<int>();
  const auto outputs = state.find("outputs");
  if (outputs != state.end() && outputs->is_array())
    for (const json& output : *outputs) job.outputs.push_back(output_of(output, path));
  job.state = job.exit_code == 0   ? State::done
              : job.exit_code == 3 ? State::not_usable
              : job.exit_code < 0  ? State::blocked
                                   : State::failed;
  if (const auto said = state.find("said"); said != state.end())
    job.facts = facts_of(job.kind, *said);
  if (job.state != State::done && job.state != State::not_usable) return;
  const auto gone = std::find_if(job.outputs.begin(), job.outputs.end(),
                                 [&](const Output& output) { return !is_there(folder, output); });
  if (gone == job.outputs.end()) return;
  job.state = State::output_gone;
  job.message = base::one_line(
      fmt::format("{} is missing or has another size; run the campaign again", gone->path));
}

Job job_of(const json& from, const std::string& path) {
  if (!from.is_object()) throw base::Error(fmt::format("{}: a job is not an object", path));
  Job job;
  job.kind = base::one_line(word(from, "kind", path));
  job.subject = base::one_line(word(from, "subject", path));
  job.id = inside(job.kind + "/" + job.subject, path);
  if (const std::string page = word(from, "page", path); !page.empty()) {
    job.page = inside(page, path);
  }
  return job;
}

}  // namespace

const char* word_of(State state) {
  switch (state) {
    case State::done:
      return "done";
    case State::not_usable:
      return "not usable";
    case State::failed:
      return "failed";
    case State::blocked:
      return "blocked";
    case State::output_gone:
      return "output gone";
    case State::not_run:
      break;
  }
  return "not run";
}

Campaign read_campaign(const std::string& folder) {
  const std::string path = (fs::path(folder) / "plan.json").string();
  const json plan = parsed(path);
  const auto jobs = plan.find("jobs");
  if (jobs == plan.end() || !jobs->is_array())
    throw base::Error(fmt::format("{}: no list 'jobs'; is this the folder of a campaign?", path));
  Campaign campaign{base::one_line(word(plan, "name", path)), {}};
  std::set<std::string> seen;
  for (const json& from : *jobs) {
    Job job = job_of(from, path);
    if (!seen.insert(job.id).second)
      throw base::Error(fmt::format("{}: job '{}' stands there twice", path, job.id));
    const fs::path state = fs::path(folder) / "state" / (job.id + ".json");
    std::error_code ignored;
    if (fs::exists(state, ignored)) {
      try {
        read_state(folder, state.string(), job);
      } catch (const base::Error& error) {
        job = job_of(from, path);
        job.state = State::failed;
        job.message = error.what();
      }
    }
    if (!job.page.empty() && !fs::is_regular_file(fs::path(folder) / job.page, ignored))
      job.page.clear();
    campaign.jobs.push_back(std::move(job));
  }
  return campaign;
}

}  // namespace campaign
