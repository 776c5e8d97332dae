#pragma once

#include <string>
#include <vector>

#include "explain/findings.h"

namespace explain {

/// report.html: one file that opens offline, without script. All text is escaped.
std::string findings_page(const Findings& findings, const std::vector<Signals>& logs,
                          const std::string& title);

}  // namespace explain
