// Curves on one page that opens anywhere: HTML with drawings inside, no scripts, nothing from outside.
#pragma once

#include <string>
#include <vector>

#include "report/track_report.h"

namespace report {

/// One curve. NaN in x or y breaks the line.
struct PlotLine {
  std::string name;
  std::vector<double> x, y;
};

struct Plot {
  std::string title, x_name, y_name;  ///< names with units
  std::vector<PlotLine> lines;        ///< at most four are told apart by colour
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

}  // namespace report
