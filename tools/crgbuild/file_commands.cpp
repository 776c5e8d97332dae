// Commands on .crg files: check them, edit them. Each is: load, one call of lib/crg, save.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/check.h"
#include "crg/edit.h"
#include "make/summary.h"
#include "settings.h"

namespace crgbuild {
namespace {

crg::Format format_of(const std::string& name, crg::Format otherwise) {
  if (name == "krbi") return crg::Format::KRBI;
  if (name == "kdbi") return crg::Format::KDBI;
  if (name == "lrfi") return crg::Format::LRFI;
  if (name == "ldfi") return crg::Format::LDFI;
  return otherwise;
}

int save(const crg::Crg& crg, const std::string& path, const std::string& format,
         Terminal& terminal) {
  base::write_file(path, crg::to_bytes(crg, format_of(format, crg.format)));
  const crg::Grid& grid = crg.grid;
  const bool closed = crg::find_value(crg.options, "REFLINE_CONTINUATION").value_or(0.0) == 1.0;
  if (terminal.json) {
    nlohmann::ordered_json out;
    out["file"] = path;
    out["rows"] = grid.rows();
    out["columns"] = grid.columns();
    out["u_begin_m"] = grid.u_begin_m;
    out["u_end_m"] = grid.u_of(grid.rows() - 1);
    out["closed"] = closed;
    terminal.print(base::json_text(out));
  } else {
    terminal.print(fmt::format("{} x {} nodes, u {:.3f} to {:.3f} m{}\nroad     {}\n", grid.rows(),
                               grid.columns(), grid.u_begin_m, grid.u_of(grid.rows() - 1),
                               closed ? ", closed" : "", path));
  }
  return kOk;
}

}  // namespace

crg::Crg with_settings(crg::Crg crg, crg::ModifierUse use,
                       const std::vector<std::string>& settings) {
  if (use == crg::ModifierUse::None) crg.modifiers.clear();
  if (use == crg::ModifierUse::ReferenceDefaults && !crg.has_modifier_section)
    crg.modifiers = crg::reference_default_modifiers(crg);
  crg.has_modifier_section = true;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    std::string key = setting.substr(0, equals);
    std::transform(key.begin(), key.end(), key.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    double value = std::nan("");
    if (equals != std::string::npos) {
      const char* end = setting.data() + setting.size();
      const auto result = std::from_chars(setting.data() + equals + 1, end, value);
      if (result.ec != std::errc() || result.ptr != end) value = std::nan("");
    }
    const bool option = crg::is_option_key(key);
    if (!std::isfinite(value) || (!option && !crg::is_modifier_key(key))) {
      throw UsageError(fmt::format(
          "--set {}: want KEY=VALUE with an option or modifier of the standard and a number",
          one_line(setting)));
    }
    crg::set_value(option ? crg.options : crg.modifiers, key, value);
  }
  return crg;
}

int run_check(const CheckCommand& command, Terminal& terminal) {
  crg::CheckReport report = crg::check(crg::read(command.crg));
  for (const std::string& failure : road::built_beside(command.crg).failures)
    report.findings.push_back(
        {crg::Severity::Error, "build", "the road must not be used: " + failure, {}, 1});
  const std::size_t errors = report.count(crg::Severity::Error);
  if (terminal.json) {
    nlohmann::ordered_json out;
    out["file"] = command.crg;
    out["passed"] = report.passed();
    out["findings"] = nlohmann::ordered_json::array();
    for (const crg::Finding& finding : report.findings) {
      out["findings"].push_back(
          {{"severity", crg::name_of(finding.severity)},
           {"rule", finding.rule},
           {"message", finding.message},
           {"row", finding.row ? nlohmann::ordered_json(*finding.row) : nullptr},
           {"count", finding.count}});
    }
    terminal.print(base::json_text(out));
  } else {
    std::string text = command.crg + "\n";
    for (const crg::Finding& finding : report.findings) {
      text += fmt::format("{:<8} {}: {}", crg::name_of(finding.severity), finding.rule,
                          one_line(finding.message));
      if (finding.row) text += fmt::format(", row {}", *finding.row);
      if (finding.count > 1) text += fmt::format(" ({} times)", finding.count);
      text += '\n';
    }
    text += fmt::format(
        "{} errors, {} warnings, {} notes\nwhether it can be driven: crgbuild report {} -o "
        "report\n",
        errors, report.count(crg::Severity::Warning), report.count(crg::Severity::Note),
        shell_word(command.crg));
    terminal.print(text);
  }
  return report.passed() ? kOk : kNotValid;
}

int run_convert(const ConvertCommand& command, Terminal& terminal) {
  return save(crg::read(command.crg), command.output, command.format, terminal);
}

int run_crop(const CropCommand& command, Terminal& terminal) {
  const crg::CropOptions options{command.u_begin_m, command.u_end_m, command.v_right_m,
                                 command.v_left_m};
  return save(crg::crop(crg::read(command.crg), options), command.output, command.format, terminal);
}

int run_resample(const ResampleCommand& command, Terminal& terminal) {
  if (!command.u_step_m && !command.v_step_m)
    throw UsageError("neither --u-step-m nor --v-step-m is given");
  return save(crg::resample(crg::read(command.crg), {command.u_step_m, command.v_step_m}),
              command.output, command.format, terminal);
}

int run_reverse(const ReverseCommand& command, Terminal& terminal) {
  return save(crg::reverse(crg::read(command.crg)), command.output, command.format, terminal);
}

int run_append(const AppendCommand& command, Terminal& terminal) {
  return save(crg::append(crg::read(command.first), crg::read(command.second), {command.move}),
              command.output, command.format, terminal);
}

int run_transform(const TransformCommand& command, Terminal& terminal) {
  crg::Crg crg = with_settings(crg::read(command.crg), crg::ModifierUse::AsInFile, {});
  const std::vector<crg::HeaderEntry> options = crg.options;
  crg = with_settings(std::move(crg), crg::ModifierUse::AsInFile, command.settings);
  if (crg.options.size() != options.size())
    throw UsageError("transform takes modifiers only; options stay in the file as they are");
  return save(crg::apply_modifiers(std::move(crg)), command.output, command.format, terminal);
}

}  // namespace crgbuild
