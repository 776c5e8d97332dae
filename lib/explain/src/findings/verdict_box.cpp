#include "verdict_box.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "report/plot_page.h"
#include "selection.h"

namespace explain {
namespace {

using report::html_text;

/// Colour of the box and what the word means.
std::pair<const char*, const char*> meaning_of(const Findings& f) {
  switch (f.verdict) {
    case Verdict::kNone:
      if (!seen_and_not_named(f).empty())
        return {"good",
                "Nothing is missing that counts. What was seen, and is too small or too unsure to "
                "be named, stands below."};
      return {"good", "Nothing is missing that these recordings can show."};
    case Verdict::kExplained:
      return {"good", "What was found explains everything significant."};
    case Verdict::kTie:
      return {"warn",
              "Something is missing, but these recordings cannot tell two explanations apart."};
    case Verdict::kNotJudged:
      return {"warn",
              "Columns are broken and were left out, so that what hangs on them was not looked at. "
              "Mend them as said below, and run this again."};
    case Verdict::kUnknown:
      break;
  }
  return {"bad", "Something is missing that no mechanism tried here explains."};
}

}  // namespace

std::string verdict_box(const Findings& f) {
  const auto [colour, meaning] = meaning_of(f);
  std::string out = fmt::format("<section class='verdict {}'><strong>{}</strong>{}", colour,
                                name_of(f.verdict), meaning);
  out += fmt::format(
      "<p>{}{} laps. False alarms by noise: of {} null replicates of these recordings the limits "
      "would have let {:.1f} % pass. By errors of the model: {} of {} recordings of another "
      "simulator's cars in which nothing is missing raised an alarm; of real cars that is not "
      "known.</p>",
      f.rounds > 0 ? fmt::format("Driven {:.2f} times round, in ", f.rounds) : "", f.laps,
      f.null_replicates, 100 * f.null_false_alarm, selection::kOtherCarsAlarmed,
      selection::kOtherCars);
  if (!f.recorded_lap_s.empty())
    out += fmt::format("<p>Whole laps as recorded: {:.2f} to {:.2f} s.",
                       *std::min_element(f.recorded_lap_s.begin(), f.recorded_lap_s.end()),
                       *std::max_element(f.recorded_lap_s.begin(), f.recorded_lap_s.end()));
  if (f.simulated_lap_before_s > 0 && f.simulated_lap_after_s > 0)
    out += fmt::format(" The built-in driver's lap: {:.2f} s before, {:.2f} s after.",
                       f.simulated_lap_before_s, f.simulated_lap_after_s);
  for (const Remark& remark : f.remarks)
    if (remark.about == Remark::About::kAnalysis)
      out += "<p><small>" + html_text(remark.text) + "</small></p>";
  return out + "</section>\n";
}

}  // namespace explain
