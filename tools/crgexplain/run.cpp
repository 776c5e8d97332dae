#include "commands.h"

namespace crgexplain {

int run(const RunCommand& command, Terminal& terminal) {
  const explain::ExplainedFiles result = explain::explain_files(
      command, terminal.progress(), [&](const std::string& remark) { terminal.remark(remark); });
  if (terminal.json)
    terminal.print(result.findings_json);
  else
    print_result(command, result, terminal);
  return result.findings.verdict == explain::Verdict::kNotJudged ? command::kNotValid : kOk;
}

}  // namespace crgexplain
