// Curves on one page that opens anywhere: HTML with drawings inside, no scripts, nothing from
// outside.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "report/track_report.h"

namespace report {

/// One curve. NaN in x or y breaks the line.
struct PlotLine {
  std::string name;
  std::vector<double> x, y;
  std::vector<double> low{}, high{};  ///< a band about it, as finite as x; empty: none
  bool dots = false;                  ///< every point by itself, unjoined
};

struct Plot {
  std::string title, x_name, y_name;           ///< names with units
  std::vector<PlotLine> lines;                 ///< at most four are told apart by colour
  std::vector<std::array<double, 2>> bands{};  ///< stretches of x to mark behind the lines
};

struct PlotPage {
  std::string title;
  std::vector<std::string> sentences;
  std::vector<Fact> facts;
  std::vector<Plot> plots;
};

/// The page. Text is escaped. Lines
/// with more points than the drawing has columns keep the lowest and highest of each column. The
/// same input gives the same bytes.
std::string plot_page(const PlotPage& page);

/// For pages with more than that: everything before the first paragraph, with the style sheet; a
/// plot as one section; text that no browser takes for markup. "</html>" ends the page.
std::string page_head(const std::string& title);
std::string plot_section(const Plot& plot);
std::string html_text(const std::string& text);

}  // namespace report
