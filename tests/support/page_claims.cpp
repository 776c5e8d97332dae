#include "support/page_claims.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <vector>

namespace support {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Text without markup.
std::string plain(const std::string& html) {
  std::string out = std::regex_replace(html, std::regex("<[^>]*>"), "");
  const std::vector<std::pair<std::string, std::string>> signs = {
      {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&amp;", "&"}};
  for (const auto& [sign, character] : signs)
    for (std::size_t at = 0; (at = out.find(sign, at)) != std::string::npos; ++at)
      out.replace(at, sign.size(), character);
  return out;
}

/// The section whose heading reads so, as it stands in the page; empty: there is none.
std::string section_of(const std::string& page, const std::string& heading) {
  for (std::size_t at = page.find("<section"); at != std::string::npos;) {
    const std::size_t end = page.find("</section>", at);
    std::string section = page.substr(at, end - at);
    const std::size_t title = section.find("<h2>");
    if (title != std::string::npos &&
        plain(section.substr(title, section.find("</h2>") - title)) == heading)
      return section;
    at = page.find("<section", end);
  }
  return "";
}

/// Cells of the rows below a heading; empty: there is no such table.
std::vector<std::vector<std::string>> table(const std::string& page, const std::string& heading) {
  const std::string section = section_of(page, heading);
  const std::size_t begin = section.find("<tbody>");
  if (begin == std::string::npos) return {};
  const std::size_t end = section.find("</tbody>", begin);
  std::vector<std::vector<std::string>> out;
  const std::string rows = section.substr(begin, end - begin);
  for (std::size_t row = rows.find("<tr>"); row != std::string::npos;) {
    const std::size_t next = rows.find("<tr>", row + 4);
    const std::string cells = rows.substr(row, next == std::string::npos ? next : next - row);
    out.emplace_back();
    for (std::size_t at = cells.find("<td"); at != std::string::npos;) {
      const std::size_t after = cells.find("<td", at + 3);
      out.back().push_back(
          plain(cells.substr(at, after == std::string::npos ? after : after - at)));
      at = after;
    }
    row = next;
  }
  return out;
}

/// The numbers in a text, in order; "–" is none (NaN).
std::vector<double> numbers(const std::string& text) {
  std::vector<double> out;
  const std::regex number("–|-?[0-9]+(?:\\.[0-9]+)?(?:e[-+][0-9]+)?");
  for (std::sregex_iterator i(text.begin(), text.end(), number), end; i != end; ++i)
    out.push_back(i->str() == "–" ? NAN : std::stod(i->str()));
  return out;
}

double value_of(const json& value) { return value.is_null() ? NAN : value.get<double>(); }

/// As printed with so many digits (relative), or so many behind the point (absolute).
void expect_numbers(const std::string& text, const std::vector<json>& wanted, double relative,
                    double absolute) {
  SCOPED_TRACE(text);
  const std::vector<double> seen = numbers(text);
  ASSERT_EQ(seen.size(), wanted.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double value = value_of(wanted[i]);
    if (std::isnan(value)) {
      EXPECT_TRUE(std::isnan(seen[i]));
    } else {
      EXPECT_NEAR(seen[i], value, relative * std::abs(value) + absolute);
    }
  }
}

/// Four digits.
void expect_figures(const std::string& text, const std::vector<json>& wanted) {
  expect_numbers(text, wanted, 5.1e-4, 1e-300);
}

std::string text_of(const json& value) { return value.is_null() ? "" : value.get<std::string>(); }

std::string unit_of(const json& item) {
  const std::string unit = item.at("unit");
  return unit == "1" ? "" : unit;
}

std::string named(const json& item) {
  const std::string channel = text_of(item.at("channel"));
  return item.at("mechanism").get<std::string>() + (channel.empty() ? "" : " in " + channel);
}

/// Begin and end of the first eight places, rounded to metres, and how many more.
void expect_places(const std::string& text, const json& where) {
  std::vector<json> wanted;
  const std::size_t count = where.is_null() ? 0 : where.size();
  for (std::size_t i = 0; i < std::min<std::size_t>(8, count); ++i)
    for (const char* key : {"u_begin_m", "u_end_m"}) wanted.push_back(where[i].at(key));
  if (count > 8) wanted.emplace_back(count - 8);
  expect_numbers(text, wanted, 0, 0.51);
}

void expect_verdict(const json& all, const std::string& box) {
  const std::string verdict = all.at("verdict");
  EXPECT_TRUE(box.starts_with(verdict)) << box;
  const std::map<std::string, const char*> meanings = {
      {"none", "Nothing is missing that"},
      {"explained", "What was found explains everything significant."},
      {"tie", "these recordings cannot tell two explanations apart"},
      {"unknown", "Something is missing that no mechanism tried here explains."}};
  EXPECT_THAT(box, HasSubstr(meanings.at(verdict)));
  if (verdict == "none") {
    const bool all_quiet = all.at("seen").empty();
    EXPECT_EQ(box.find("that these recordings can show") != std::string::npos, all_quiet);
    EXPECT_EQ(box.find("stands below") != std::string::npos, !all_quiet);
  }
  std::smatch said;
  ASSERT_TRUE(std::regex_search(
      box, said,
      std::regex("([0-9]+) laps\\. False alarms by noise: of ([0-9]+) null replicates of these "
                 "recordings the limits would have let ([0-9.]+) % pass\\. By errors of the model: "
                 "([0-9]+) of ([0-9]+) recordings of another simulator's cars")))
      << box;
  EXPECT_EQ(std::stoul(said[1]), all.at("laps"));
  EXPECT_EQ(std::stoul(said[2]), all.at("null_calibration").at("replicates"));
  EXPECT_NEAR(std::stod(said[3]), 100 * value_of(all.at("null_calibration").at("false_alarm_rate")),
              0.051);
  EXPECT_EQ(std::stoi(said[4]), all.at("other_cars").at("alarms"));
  EXPECT_EQ(std::stoi(said[5]), all.at("other_cars").at("recordings"));
  const json& lap_s = all.at("lap_s");
  const bool whole =
      std::regex_search(box, said, std::regex("Whole laps as recorded: ([0-9.]+) to ([0-9.]+) s"));
  EXPECT_EQ(whole, !lap_s.at("recorded").empty());
  if (whole) {
    const auto laps = lap_s.at("recorded").get<std::vector<double>>();
    EXPECT_NEAR(std::stod(said[1]), *std::min_element(laps.begin(), laps.end()), 0.0051);
    EXPECT_NEAR(std::stod(said[2]), *std::max_element(laps.begin(), laps.end()), 0.0051);
  }
  const bool driven = std::regex_search(
      box, said, std::regex("driver's lap: ([0-9.]+) s before, ([0-9.]+) s after"));
  EXPECT_EQ(driven,
            !lap_s.at("simulated_before").is_null() && !lap_s.at("simulated_after").is_null());
  if (driven) {
    EXPECT_NEAR(std::stod(said[1]), value_of(lap_s.at("simulated_before")), 0.0051);
    EXPECT_NEAR(std::stod(said[2]), value_of(lap_s.at("simulated_after")), 0.0051);
  }
}

/// How sure: whatever it is measured by, each figure is one of the finding's.
void expect_sureness(const json& f, const std::string& text) {
  std::smatch said;
  const auto figure = [&](const char* pattern) {
    return std::regex_search(text, said, std::regex(pattern)) ? std::stod(said[1]) : NAN;
  };
  const double statistic = value_of(f.at("statistic")), threshold = value_of(f.at("threshold")),
               stability = value_of(f.at("stability")), gain = value_of(f.at("cv_gain"));
  const auto agrees = [](double said_value, double value, double relative, double absolute) {
    if (!std::isnan(said_value)) {
      EXPECT_NEAR(said_value, value, relative * std::abs(value) + absolute);
    }
  };
  agrees(figure("score (-?[0-9.]+)"), statistic, 0, 0.051);
  agrees(figure("where ([0-9.]+) is needed"), threshold, 0, 0.051);
  agrees(figure("gain of ([-+0-9.e]+) on"), gain, 5.1e-3, 1e-300);
  agrees(figure("sign in ([0-9]+) %"), 100 * stability, 0, 0.51);
  agrees(figure("better in ([0-9]+) %"), 100 * stability, 0, 0.51);
  agrees(figure("([0-9.]+) standard deviations"), std::abs(statistic), 0, 0.051);
  EXPECT_GE(numbers(text).size(), 1u) << text;
}

void expect_finding(const json& f, const std::string& page) {
  const std::string section = section_of(page, named(f) + " " + f.at("kind").get<std::string>());
  ASSERT_NE(section, "") << named(f);
  const std::string text = plain(section);
  EXPECT_THAT(text, HasSubstr(f.at("physics").get<std::string>()));
  EXPECT_THAT(text, HasSubstr(f.at("equation").get<std::string>()));
  std::size_t row = 0;
  for (const json& p : f.at("parameters")) {
    row = section.find("<tr>", row) + 4;
    const std::size_t end = std::min(section.find("<tr>", row), section.find("</table>", row));
    const std::string cells = section.substr(row, end - row);
    const std::size_t value = cells.find("<b>"), interval = cells.find("90 %: ");
    EXPECT_EQ(plain(cells.substr(0, cells.find("<td><b>"))), p.at("name"));
    const std::string amount = plain(cells.substr(value, cells.find("</b>") - value));
    expect_figures(amount.substr(0, amount.find(' ')), {p.at("value")});
    const json low = p.at("ci90")[0], high = p.at("ci90")[1];
    if (cells.find("held, not fitted") != std::string::npos)
      EXPECT_EQ(low, high);
    else
      expect_figures(cells.substr(interval + 6), {low, high});
  }
  const std::size_t where = section.find("<p>Where: ");
  EXPECT_EQ(where != std::string::npos, !f.at("where").is_null() && !f.at("where").empty());
  if (where != std::string::npos)
    expect_places(section.substr(where, section.find("</p>", where) - where), f.at("where"));
  EXPECT_EQ(text.find("Seen, not used") != std::string::npos, !f.at("not_used").is_null());
  EXPECT_THAT(text, HasSubstr(text_of(f.at("not_used"))));
  const std::size_t sure = section.find("How sure: ");
  expect_sureness(f, section.substr(sure, section.find("</p>", sure) - sure));
  for (const json& rival : f.at("rivals"))
    EXPECT_EQ(text.find("Cannot be told from " + named(rival) + ".") != std::string::npos,
              !rival.at("separable").get<bool>())
        << named(rival);
}

using Row = std::vector<std::string>;

/// One row of the page for each item, as `each` compares them.
template <class Each>
void expect_rows(const std::string& page, const char* heading, const json& list, const Each& each) {
  SCOPED_TRACE(heading);
  const std::vector<Row> rows = table(page, heading);
  ASSERT_EQ(rows.size(), list.size());
  for (std::size_t i = 0; i < rows.size(); ++i) each(rows[i], list[i]);
}

void expect_tables(const json& all, const std::string& page) {
  expect_rows(page, "Where simulation and recording differ", all.at("mismatches"),
              [](const Row& row, const json& m) {
                EXPECT_EQ(row.at(0), m.at("channel"));
                expect_places(row.at(1), m.at("where"));
                EXPECT_EQ(row.at(2), text_of(m.at("regime")));
                EXPECT_TRUE(row.at(3).ends_with(unit_of(m)));
                EXPECT_NEAR(std::stod(row.at(3)), value_of(m.at("size")),
                            5.1e-4 * std::abs(value_of(m.at("size"))));
                EXPECT_NEAR(std::stod(row.at(4)), value_of(m.at("p_adjusted")),
                            0.051 * value_of(m.at("p_adjusted")));
                EXPECT_NEAR(std::stod(row.at(5)), 100 * value_of(m.at("share_of_residual")), 0.51);
              });
  json relations = json::array();  // one row each, with the patterns that it shows over more
  for (const json& u : all.at("unexplained")) {
    const auto same = [&](const json& r) { return r.at("channel") == u.at("channel"); };
    const auto row = std::find_if(relations.begin(), relations.end(), same);
    if (row == relations.end()) {
      relations.push_back(u);
      relations.back()["more"] = std::string();
    } else {
      const auto more = row->at("more").get<std::string>();
      (*row)["more"] =
          more + (more.empty() ? "; and over " : ", ") + u.at("locked_to").get<std::string>();
    }
  }
  expect_rows(page, "What stays unexplained", relations, [](const Row& row, const json& u) {
    EXPECT_EQ(row.at(0), u.at("channel"));
    EXPECT_EQ(row.at(1), u.at("locked_to").get<std::string>() + u.at("more").get<std::string>());
    expect_places(row.at(2), u.at("where"));
    EXPECT_NEAR(std::stod(row.at(3)), value_of(u.at("size")),
                5.1e-4 * std::abs(value_of(u.at("size"))));
    EXPECT_NEAR(std::stod(row.at(4)), 100 * value_of(u.at("share")), 0.51);
  });
  expect_rows(page, "Parameters, refitted", all.at("parameters"),
              [](const Row& row, const json& p) {
                EXPECT_EQ(row.at(0), p.at("name"));
                expect_figures(row.at(1), {p.at("stated")});
                expect_figures(row.at(2), {p.at("value")});
                expect_figures(row.at(3), {p.at("ci90")[0], p.at("ci90")[1]});
                EXPECT_EQ(row.at(4), unit_of(p));
                EXPECT_EQ(row.at(5), p.at("at_limit")       ? "at its limit: not determined"
                                     : p.at("beyond_prior") ? "beyond its prior width"
                                     : p.at("unsure") ? "outside its prior width, not for sure"
                                                      : "");
              });
  expect_rows(page, "Everything that was tried", all.at("tested"),
              [](const Row& row, const json& e) {
                EXPECT_EQ(row.at(0), e.at("mechanism"));
                EXPECT_EQ(row.at(1), text_of(e.at("channel")));
                expect_numbers(row.at(2), {e.at("amount")}, 5.1e-3, 1e-300);
                EXPECT_EQ(row.at(4), e.at("detail"));
                expect_numbers(row.at(5), {e.at("statistic")}, 0, 0.051);
                expect_numbers(row.at(6), {e.at("cv_gain")}, 0, 0.051);
              });
  expect_rows(page, "Seen, and not named", all.at("seen"), [](const Row& row, const json& s) {
    EXPECT_EQ(row.at(0), named(s));
    EXPECT_EQ(row.at(1), s.at("detail"));
    EXPECT_NEAR(std::stod(row.at(2)), value_of(s.at("amount")),
                5.1e-4 * std::abs(value_of(s.at("amount"))));
    expect_figures(row.at(3), {s.at("ci90")[0], s.at("ci90")[1]});
    EXPECT_NEAR(std::stod(row.at(4)), std::abs(value_of(s.at("statistic"))), 0.051);
    EXPECT_EQ(row.at(5), s.at("why"));
  });
  expect_rows(page, "Not testable with these recordings", all.at("untestable"),
              [](const Row& row, const json& u) {
                EXPECT_EQ(row.at(0), u.at("mechanism"));
                EXPECT_EQ(row.at(1), u.at("reason"));
              });
}

}  // namespace

void expect_page_says(const json& all, const std::string& page) {
  const std::size_t box = page.find("<section class='verdict");
  ASSERT_NE(box, std::string::npos);
  expect_verdict(all, plain(page.substr(box, page.find("</section>", box) - box)));
  for (const json& f : all.at("findings")) expect_finding(f, page);
  expect_tables(all, page);
  // What was left out of the fit is told of the first finding; without one findings.json has none.
  if (all.at("findings").empty()) return;
  expect_rows(page, "Laps that were not used", all.at("findings")[0].at("held_out"),
              [](const Row& row, const json& h) {
                EXPECT_EQ(row.at(0),
                          h.at("by") == "whole car" ? "whole simulated car" : "one relation");
                EXPECT_EQ(row.at(1), h.at("channel"));
                if (h.at("horizon_s") == 0.0) {
                  EXPECT_EQ(row.at(3), "at once");
                } else {
                  expect_figures(row.at(3), {h.at("horizon_s")});
                }
                expect_figures(row.at(4), {h.at("rmse_before")});
                expect_figures(row.at(5), {h.at("rmse_after")});
                expect_figures(row.at(6), {h.at("trivial_rmse")});
                expect_figures(row.at(7), {h.at("trend_rmse")});
                const std::vector<double> drop = numbers(row.at(8));
                ASSERT_EQ(drop.size(), 2u) << row.at(8);
                for (std::size_t i = 0; i < 2; ++i)
                  EXPECT_NEAR(drop[i], 100 * value_of(h.at("drop_ci90")[i]), 0.051);
              });
}

}  // namespace support
