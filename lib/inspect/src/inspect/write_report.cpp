#include "inspect/write_report.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/write_file.h"
#include "mesh/error.h"
#include "report/track_report.h"

namespace road {
namespace {

Verdict verdict_named(const std::string& name) {
  for (const Verdict verdict : {Verdict::usable, Verdict::usable_with_remarks, Verdict::not_usable})
    if (name == to_string(verdict)) return verdict;
  throw Error(
      fmt::format("verdict '{}' seen, usable, usable_with_remarks or not_usable wanted", name));
}

void count(const std::string& severity, const std::string& text, ReportFiles& files) {
  if (severity == to_string(Severity::error))
    files.errors.push_back(text);
  else
    ++files.remarks;
}

}  // namespace

ReportFiles write_report(const ReportRequest& request, const std::string& output_dir) {
  const report::TrackReport made = make_report(request);
  std::error_code problem;
  std::filesystem::create_directories(output_dir, problem);
  if (problem || !std::filesystem::is_directory(output_dir)) {
    throw Error(
        fmt::format("{}: cannot make this folder: {}; give a folder that can be written with -o",
                    output_dir, problem ? problem.message() : "a file of that name is in the way"));
  }
  ReportFiles files;
  files.verdict = verdict_named(made.verdict);
  for (const auto& f : made.findings) count(f.severity, f.text, files);
  const std::filesystem::path dir(output_dir);
  files.json_path = (dir / "report.json").string();
  base::write_file(files.json_path, report::report_json(made));
  if (report::page_available()) {
    files.page_path = (dir / "report.html").string();
    base::write_file(files.page_path, report::report_page(made));
  }
  return files;
}

ReportFiles read_report(const std::string& output_dir) {
  ReportFiles files;
  files.json_path = (std::filesystem::path(output_dir) / "report.json").string();
  std::ifstream file(files.json_path, std::ios::binary);
  try {
    const auto json = nlohmann::json::parse(file);
    files.verdict = verdict_named(json.at("verdict").get<std::string>());
    for (const auto& finding : json.at("findings"))
      count(finding.at("severity").get<std::string>(), finding.at("text").get<std::string>(),
            files);
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: no report with a verdict; make it with 'crgbuild report'",
                            files.json_path));
  }
  const std::string page = (std::filesystem::path(output_dir) / "report.html").string();
  if (std::filesystem::exists(page)) files.page_path = page;
  return files;
}

}  // namespace road
