#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/ending.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/write_file.h"
#include "command/exit_code.h"
#include "commands.h"
#include "recording/log.h"
#include "recording/look.h"
#include "recording/mcap.h"
#include "report/plot_page.h"

namespace kerbstone {
namespace {

using recording::ChannelLook, recording::Log;

constexpr std::size_t kMostPlots = 16;  // of live channels, where none are named

/// Ten samples and a second are missing.
bool has_gap(const ChannelLook& look) {
  return look.rate_hz > 0.0 && look.longest_gap_s > std::max(1.0, 10.0 / look.rate_hz);
}

std::string state_of(const ChannelLook& look) {
  if (look.samples == 0) return look.words > 0 ? "words" : "empty";
  if (look.dead) return "dead: one value";
  std::string out;
  const auto say = [&](const std::string& text) { out += (out.empty() ? "" : ", ") + text; };
  if (look.held > 0.3) say(fmt::format("{:.0f} % repeat", 100.0 * look.held));
  if (look.words > 0) say(fmt::format("{} words", look.words));
  if (has_gap(look)) say(fmt::format("gap of {:.3g} s", look.longest_gap_s));
  return out;
}

/// What the file's reader said, and how often its clock goes back.
std::vector<std::string> notes_of(const Log& log) {
  std::vector<std::string> out = log.notes;
  if (!log.in_rows || log.channels.empty()) return out;
  const std::vector<double> moments = recording::moments_of(log, log.channels.front());
  std::size_t back = 0;
  for (std::size_t k = 1; k < moments.size(); ++k) back += moments[k] < moments[k - 1] ? 1 : 0;
  if (back > 0) out.push_back(fmt::format("rows that are earlier than the row before: {}", back));
  return out;
}

std::string text_of(const Log& log, const std::vector<ChannelLook>& looks) {
  std::string out = fmt::format("{}, {} channels\n{:<32} {:<10} {:>9} {:>9} {:>12} {:>12}  {}\n",
                                log.format, looks.size(), "channel", "unit", "rate, Hz", "samples",
                                "least", "greatest", "remark");
  for (const ChannelLook& look : looks)
    out += fmt::format("{:<32} {:<10} {:>9} {:>9} {:>12.6g} {:>12.6g}  {}\n",
                       command::one_line(look.name), command::one_line(look.unit),
                       look.rate_hz > 0 ? fmt::format("{:.4g}", look.rate_hz) : "?", look.samples,
                       look.least, look.greatest, state_of(look));
  for (const std::string& note : notes_of(log)) out += "  " + command::one_line(note) + "\n";
  return out;
}

nlohmann::ordered_json json_of(const Log& log, const std::vector<ChannelLook>& looks) {
  nlohmann::ordered_json channels = nlohmann::ordered_json::array();
  for (const ChannelLook& look : looks)
    channels.push_back({{"name", look.name},
                        {"unit", look.unit},
                        {"rate_hz", look.rate_hz},
                        {"samples", look.samples},
                        {"words", look.words},
                        {"least", look.least},
                        {"greatest", look.greatest},
                        {"held", look.held},
                        {"dead", look.dead},
                        {"longest_gap_s", look.longest_gap_s}});
  return {{"format", log.format}, {"channels", std::move(channels)}, {"notes", notes_of(log)}};
}

std::string with_unit(const recording::Channel& channel) {
  return channel.unit.empty() ? channel.name : fmt::format("{} [{}]", channel.name, channel.unit);
}

/// The channels of a log in rows that are named, else the first live ones.
std::vector<const recording::Channel*> chosen(const Log& rows,
                                              const std::vector<std::string>& names,
                                              const std::string& path) {
  std::vector<const recording::Channel*> out;
  for (const std::string& name : names) {
    const auto found = std::find_if(rows.channels.begin(), rows.channels.end(),
                                    [&](const auto& channel) { return channel.name == name; });
    if (found == rows.channels.end())
      throw base::Error(
          fmt::format("{}: no channel '{}'; without --channel all are listed", path, name));
    out.push_back(&*found);
  }
  if (!names.empty()) return out;
  for (const recording::Channel& channel : rows.channels) {
    if (out.size() == kMostPlots) break;
    const auto& values = channel.values;
    const auto known = [](double value) { return std::isfinite(value); };
    const auto first = std::find_if(values.begin(), values.end(), known);
    if (std::any_of(first, values.end(), [&](double v) { return known(v) && v != *first; }))
      out.push_back(&channel);
  }
  return out;
}

std::string page_of(const Log& rows, const std::vector<ChannelLook>& looks, const std::string& path,
                    const std::vector<std::string>& names) {
  std::vector<double> time_s = recording::clock_of_rows(rows);
  const bool timed = !time_s.empty();
  if (!timed)
    for (std::size_t i = 0; i < rows.channels.at(0).values.size(); ++i)
      time_s.push_back(static_cast<double>(i));
  report::PlotPage page;
  page.title = path;
  page.sentences = rows.notes;
  page.facts.push_back({"format", rows.format});
  page.facts.push_back({"rows", fmt::format("{}", time_s.size())});
  page.facts.push_back({"channels", fmt::format("{}", looks.size())});
  std::string still;
  for (const ChannelLook& look : looks)
    if (look.samples == 0 || look.dead) still += (still.empty() ? "" : ", ") + look.name;
  if (!still.empty()) page.facts.push_back({"dead or empty", still});
  for (const recording::Channel* channel : chosen(rows, names, path)) {
    if (names.empty() && channel->values == time_s) continue;  // the clock
    report::PlotLine line{.name = channel->name, .x = {}, .y = {}};
    for (std::size_t i = 0; i < time_s.size(); ++i)
      if (std::isfinite(channel->values[i])) {  // slower channels have no value in most rows
        line.x.push_back(time_s[i]);
        line.y.push_back(channel->values[i]);
      }
    page.plots.push_back({.title = channel->name,
                          .x_name = timed ? "time, s" : "row",
                          .y_name = channel->unit.empty() ? "unit unknown" : channel->unit,
                          .lines = {std::move(line)}});
  }
  return report::plot_page(page);
}

std::string mcap_of(const Log& rows, const std::string& path) {
  const std::vector<double> time_s = recording::clock_of_rows(rows);
  if (time_s.empty())
    throw base::Error(path + ": no clock among its channels, which MCAP wants; write CSV");
  if (const auto bare =
          std::find_if(time_s.begin(), time_s.end(), [](double t) { return std::isnan(t); });
      bare != time_s.end())
    throw base::Error(fmt::format("{}: row {} has no moment, which MCAP wants; write CSV", path,
                                  bare - time_s.begin() + 1));
  recording::WrittenTopic topic{"/log", {}, {}};
  for (const recording::Channel& channel : rows.channels) {
    if (std::all_of(channel.values.begin(), channel.values.end(),
                    [](double value) { return std::isnan(value); }))
      continue;
    topic.fields.push_back(with_unit(channel));
    topic.columns.push_back(channel.values.data());
  }
  return recording::format_mcap(time_s, {topic}, topic.fields, path);
}

std::string csv_of(const Log& rows) {
  std::string out;
  for (const recording::Channel& channel : rows.channels) {
    std::string name = with_unit(channel);
    std::replace(name.begin(), name.end(), '"', '\'');  // quotes in quotes are not read back
    out += fmt::format("{}{}", out.empty() ? "" : ",",
                       name.find_first_of(",;\t#") == std::string::npos ? name : '"' + name + '"');
  }
  const std::size_t count = rows.channels.empty() ? 0 : rows.channels.front().values.size();
  for (std::size_t i = 0; i < count; ++i) {
    char before = '\n';
    for (const recording::Channel& channel : rows.channels) {
      out += before;
      if (!std::isnan(channel.values[i]))
        fmt::format_to(std::back_inserter(out), "{}", channel.values[i]);
      before = ',';
    }
  }
  return out + "\n";
}

}  // namespace

int open(const OpenCommand& command, command::Terminal& terminal) {
  std::error_code none;
  if (std::filesystem::equivalent(command.log, command.out, none))
    throw base::Error(command.out + ": is the log, and -o would overwrite it; choose another name");
  const Log log = recording::read_log(command.log);
  const std::vector<ChannelLook> looks = recording::look_at_channels(log);
  if (!command.out.empty()) {
    const std::string ending = command.out == "-" ? ".csv" : base::ending_of(command.out);
    if (ending != ".html" && ending != ".mcap" && ending != ".csv")
      throw base::Error(
          fmt::format("{}: a name that ends in .html, .mcap or .csv is wanted", command.out));
    const Log spread = log.in_rows ? Log{} : recording::in_rows(log, command.log);
    const Log& rows = log.in_rows ? log : spread;
    base::write_file(command.out, ending == ".html"
                                      ? page_of(rows, looks, command.log, command.channels)
                                  : ending == ".mcap" ? mcap_of(rows, command.log)
                                                      : csv_of(rows));
  }
  terminal.print(terminal.json ? base::json_text(json_of(log, looks)) : text_of(log, looks));
  if (!command.out.empty() && !terminal.json) terminal.print(fmt::format("{}\n", command.out));
  return command::kOk;
}

}  // namespace kerbstone
