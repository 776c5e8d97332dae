#pragma once

#include <string>
#include <vector>

#include "explain/findings.h"

namespace explain {

/// What to do with the result, and how: a command, or a sentence.
struct NextStep {
  std::string what, how;
};

/// report.html: one file that opens offline, without script. All text is escaped.
std::string findings_page(const Findings& findings, const std::vector<Signals>& logs,
                          const std::string& title, const std::vector<NextStep>& next = {});

}  // namespace explain
