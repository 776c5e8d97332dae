// A small campaign's folder, written by hand.
#pragma once

#include <filesystem>
#include <string>

#include "support/run_crgbuild.h"

namespace campaign_test {

/// Two roads and a lap: the first road done with its output of 3 bytes, the second failed with the
/// message, the lap blocked by it.
inline void write_results(const cli::Folder& folder, const std::string& message) {
  namespace fs = std::filesystem;
  for (const char* below : {"state/road", "state/lap", "road/a"})
    fs::create_directories(folder / below);
  cli::write(folder / "plan.json", R"({"name": "three <jobs>", "jobs": [
    {"kind": "road", "subject": "a", "page": "road/a/report.html"},
    {"kind": "road", "subject": "b", "page": "road/b/report.html"},
    {"kind": "lap", "subject": "b+car"}, {"kind": "lap", "subject": "a+car"}]})");
  cli::write(folder / "road/a/a.crg", "crg");
  cli::write(folder / "road/a/report.html", "<html>");
  cli::write(folder / "state/road/a.json", R"({"exit_code": 0, "message": "",
    "outputs": [{"path": "road/a/a.crg", "bytes": 3, "sha256": "00ff"}],
    "said": {"reference_line": {"length_m": 1234.25}, "kerb": {"kerbs": [{}, {}, {}]},
             "validation": {"z_error_m": {"p99": 0.00125, "max": null}}}})");
  cli::write(folder / "state/road/b.json",
             "{\"exit_code\": 1, \"outputs\": [], \"message\": \"" + message + "\"}");
  cli::write(folder / "state/lap/b+car.json",
             R"({"exit_code": -1, "message": "needs road/b", "outputs": []})");
}

}  // namespace campaign_test
