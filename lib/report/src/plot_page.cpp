#include "report/plot_page.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace report {
namespace {

constexpr double kWidth = 960, kHeight = 260, kLeft = 64, kRight = 12, kTop = 10, kBottom = 40;
constexpr std::size_t kPageColours = 4;  ///< of the report page: --s1 to --s4

std::string number_text(double value, int digits = 6) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits)
                       .ptr;
  return {text.data(), end};
}

/// What a tick says: as many decimals as multiples of `step` need to differ, and no more.
std::string tick_text(double value, double step) {
  const double size = std::max(std::abs(value), step);
  const double digits =
      std::floor(std::log10(size) + 1e-9) - std::floor(std::log10(step) + 1e-9) + 1.0;
  // Exponents only where zeros would be all that one sees.
  if (size >= 1e9 || step < 1e-6)
    return number_text(value, static_cast<int>(std::clamp(digits, 1.0, 15.0)));
  std::array<char, 40> text{};
  const int decimals = static_cast<int>(std::max(0.0, -std::floor(std::log10(step) + 1e-9)));
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals)
                       .ptr;
  std::string trimmed(text.data(), end);
  if (decimals > 0) {
    trimmed.erase(trimmed.find_last_not_of('0') + 1);
    if (trimmed.back() == '.') trimmed.pop_back();
  }
  return trimmed;
}

/// A place in the drawing, to a tenth of a pixel.
std::string pixel(double value) { return number_text(std::round(value * 10.0) / 10.0, 7); }

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// Never empty; a constant gets some room.
  void finish() {
    if (!(low <= high)) low = 0.0, high = 1.0;
    const double room = std::max(1e-9, 1e-6 * std::max(std::abs(low), std::abs(high)));
    if (high - low < room) low -= room, high += room;
  }
};

/// A round step that cuts the range into about `parts`.
double round_step(double range, double parts) {
  const double rough = range / parts;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (rough <= factor * power) return factor * power;
  return 10.0 * power;
}

struct Axes {
  Range x, y;
  double px(double v) const {
    return kLeft + (v - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight);
  }
  double py(double v) const {
    return kHeight - kBottom - (v - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  }
};

void draw_axes(std::string& out, const Plot& plot, const Axes& axes) {
  const auto ticks = [](const Range& range, double parts, auto&& draw) {
    const double step = round_step(range.high - range.low, parts);
    const double first = std::ceil(range.low / step - 1e-9);
    for (double k = first; k * step <= range.high + 1e-9 * step && k < first + 50; ++k)
      draw(k == 0 ? 0.0 : k * step, step);
  };
  ticks(axes.x, 10, [&](double v, double step) {
    const std::string x = pixel(axes.px(v));
    out += "<path class=grid d='M" + x + " " + pixel(kTop) + "V" + pixel(kHeight - kBottom) +
           "'/><text x=" + x + " y=" + pixel(kHeight - kBottom + 15) + " text-anchor=middle>" +
           tick_text(v, step) + "</text>";
  });
  ticks(axes.y, 5, [&](double v, double step) {
    const std::string y = pixel(axes.py(v));
    out += "<path class=grid d='M" + pixel(kLeft) + " " + y + "H" + pixel(kWidth - kRight) +
           "'/><text x=" + pixel(kLeft - 6) + " y=" + pixel(axes.py(v) + 4) + " text-anchor=end>" +
           tick_text(v, step) + "</text>";
  });
  out += "<text x=" + pixel(kWidth - kRight) + " y=" + pixel(kHeight - 8) + " text-anchor=end>" +
         html_text(plot.x_name) + "</text>";
}

/// The line as a path; of the points in one column of pixels only first, lowest, highest and last.
std::string path_of(const PlotLine& line, const Axes& axes) {
  std::string out;
  bool pen = false;
  const std::size_t n = std::min(line.x.size(), line.y.size());
  const auto put = [&](std::size_t i) {
    out += (pen ? "L" : "M") + pixel(axes.px(line.x[i])) + " " + pixel(axes.py(line.y[i]));
    pen = true;
  };
  for (std::size_t i = 0; i < n;) {
    if (!std::isfinite(line.x[i]) || !std::isfinite(line.y[i])) {
      pen = false;
      ++i;
      continue;
    }
    const double column = std::floor(axes.px(line.x[i]));
    std::size_t low = i, high = i, end = i + 1;
    while (end < n && std::isfinite(line.x[end]) && std::isfinite(line.y[end]) &&
           std::floor(axes.px(line.x[end])) == column) {
      if (line.y[end] < line.y[low]) low = end;
      if (line.y[end] > line.y[high]) high = end;
      ++end;
    }
    std::array<std::size_t, 4> kept{i, std::min(low, high), std::max(low, high), end - 1};
    const auto last = std::unique(kept.begin(), kept.end());
    for (auto k = kept.begin(); k != last; ++k) put(*k);
    i = end;
  }
  return out;
}

std::string dots_of(const PlotLine& line, const Axes& axes) {
  std::string out;
  for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i)
    if (std::isfinite(line.x[i]) && std::isfinite(line.y[i]))
      out += "M" + pixel(axes.px(line.x[i])) + " " + pixel(axes.py(line.y[i])) + "h0";
  return out;
}

/// Along the upper side and back along the lower one.
std::string band_of(const PlotLine& line, const Axes& axes) {
  std::string out;
  const std::size_t n = std::min({line.x.size(), line.low.size(), line.high.size()});
  const auto put = [&](std::size_t i, double y) {
    out += (out.empty() ? "M" : "L") + pixel(axes.px(line.x[i])) + " " + pixel(axes.py(y));
  };
  for (std::size_t i = 0; i < n; ++i) put(i, line.high[i]);
  for (std::size_t i = n; i-- > 0;) put(i, line.low[i]);
  return out + "Z";
}

// The look of the validation report (web/src/style.css), as far as a page without scripts needs it.
constexpr const char* kStyle =
    ":root{color-scheme:light "
    "dark;--bg:#f6f7f8;--panel:#fff;--fg:#1b2026;--muted:#5c6670;--line:#d9dee3;--grid:#e8ebee;--"
    "none:#c9ced4;"
    "--good:#1a7f4b;--warn:#9a5b00;--bad:#b3261e;--good-bg:#e4f5ec;--warn-bg:#fdf1dc;--bad-bg:#"
    "fbe6e4;--mark:rgba(29,95,196,.12);"
    "--s1:#1d5fc4;--s2:#c2571a;--s3:#14804a;--s4:#8a3ea8}"
    "@media screen and "
    "(prefers-color-scheme:dark){:root{--bg:#14181c;--panel:#1c2227;--fg:#e7ebef;--muted:#9aa6b1;--"
    "line:#323b43;--grid:#2a3238;--none:#4a545d;"
    "--good:#63d29a;--warn:#f2b65a;--bad:#ff8a80;--good-bg:#15342a;--warn-bg:#3a2c12;--bad-bg:#"
    "43211f;--mark:rgba(125,176,255,.18);"
    "--s1:#7db0ff;--s2:#ffa266;--s3:#63d29a;--s4:#d79bf0}}"
    "*{box-sizing:border-box}body{margin:0 auto;max-width:1240px;padding:0 16px "
    "48px;background:var(--bg);color:var(--fg);"
    "font:15px/1.45 system-ui,'Segoe UI',Roboto,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif}"
    "h1{font-size:1.5rem;margin:18px 0 8px;overflow-wrap:anywhere}h2{font-size:1.15rem;margin:0 0 "
    "4px}h3{font-size:.98rem;margin:14px 0 4px}small{color:var(--muted);font-weight:400}"
    "table{border-collapse:collapse}td{border-bottom:1px solid var(--line);padding:3px 18px 3px "
    "0;overflow-wrap:anywhere;vertical-align:top}"
    "th{text-align:left;color:var(--muted);font-weight:500;font-size:.82rem;padding:3px 18px 3px "
    "0;border-bottom:1px solid var(--line);vertical-align:bottom}"
    ".n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}"
    "section{break-inside:avoid;overflow-x:auto;background:var(--panel);border:1px solid "
    "var(--line);border-radius:8px;padding:12px;margin:14px 0}"
    "section.long{break-inside:auto}section "
    "td{overflow-wrap:break-word}tr{break-inside:avoid}.verdict{border-left:6px solid "
    "var(--muted)}.verdict strong{font-size:1.3rem;margin-right:12px}"
    ".good{border-left-color:var(--good);background:var(--good-bg)}.good "
    "strong{color:var(--good)}.warn{border-left-color:var(--warn);background:var(--warn-bg)}"
    ".warn "
    "strong{color:var(--warn)}.bad{border-left-color:var(--bad);background:var(--bad-bg)}.bad "
    "strong{color:var(--bad)}"
    "svg{width:100%;height:auto;display:block}svg "
    "text{font-size:11px;fill:var(--muted)}.grid{stroke:var(--grid);fill:none}.band{fill:var(--"
    "mark)}"
    ".s1{--c:var(--s1)}.s2{--c:var(--s2)}.s3{--c:var(--s3)}.s4{--c:var(--s4)}.s0{--c:var(--none)}."
    "sb{--c:var(--bad)}"
    ".dots{fill:none;stroke:var(--c);stroke-width:3;stroke-linecap:round;stroke-opacity:.45}"
    ".around{fill:var(--c);fill-opacity:.18}"
    ".line{fill:none;stroke:var(--c);stroke-width:1.4;stroke-linejoin:round}.map{max-height:70vh}."
    "map .line{stroke-width:5;stroke-linecap:round}"
    ".map text{paint-order:stroke;stroke:var(--panel);stroke-width:4px}section p{margin:5px "
    "0}.legend{margin:0}.legend span{margin-right:18px}"
    ".legend "
    "span::before{content:'';display:inline-block;width:18px;height:3px;margin-right:6px;vertical-"
    "align:middle;background:var(--c)}"
    // On a phone a drawing keeps its text readable and is moved sideways.
    "@media screen and (max-width:760px){body{padding:0 10px "
    "40px}section{padding:10px}svg{min-width:640px}svg.map{min-width:0}.map text{font-size:24px}}"
    "@media "
    "print{@page{size:A4;margin:14mm}body{max-width:none;padding:0;background:#fff;font-size:11px}"
    "section{border-color:#ccc;padding:8px;overflow:visible}td,th{padding-right:8px}section "
    "td{overflow-wrap:anywhere}th{white-space:normal}h2,h3{break-after:avoid}}";

}  // namespace

std::string html_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 32 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

std::string plot_section(const Plot& plot) {
  std::string out;
  Axes axes;
  for (const PlotLine& line : plot.lines) {
    for (const double x : line.x) axes.x.take(x);
    for (const auto* values : {&line.y, &line.low, &line.high})
      for (const double y : *values) axes.y.take(y);
  }
  axes.x.finish();
  axes.y.finish();
  const double room = 0.04 * (axes.y.high - axes.y.low);
  axes.y.low -= room;
  axes.y.high += room;
  out += "<section><h2>" + html_text(plot.title) + " <small>" + html_text(plot.y_name) +
         "</small></h2><p class=legend>";
  for (std::size_t i = 0; i < plot.lines.size(); ++i)
    out += "<span class=s" + std::to_string(i % kPageColours + 1) + ">" +
           html_text(plot.lines[i].name) + "</span>";
  out += "</p><svg viewBox='0 0 " + pixel(kWidth) + " " + pixel(kHeight) + "' role=img>";
  for (const auto& [begin, end] : plot.bands) {
    const double left = axes.px(std::max(begin, axes.x.low)),
                 right = axes.px(std::min(end, axes.x.high));
    if (right > left)
      out += "<rect class=band x=" + pixel(left) + " y=" + pixel(kTop) +
             " width=" + pixel(right - left) + " height='" + pixel(kHeight - kTop - kBottom) +
             "'/>";
  }
  draw_axes(out, plot, axes);
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const PlotLine& line = plot.lines[i];
    const auto draw = [&](const char* how, const std::string& path) {
      out += std::string("<path class='") + how + " s" + std::to_string(i % kPageColours + 1) +
             "' d='" + path + "'/>";
    };
    if (!line.low.empty()) draw("around", band_of(line, axes));
    if (line.dots)
      draw("dots", dots_of(line, axes));
    else
      draw("line", path_of(line, axes));
  }
  return out + "</svg></section>\n";
}

std::string page_head(const std::string& title) {
  return "<!doctype html><html lang=en><meta charset=utf-8>"
         "<meta http-equiv=Content-Security-Policy content=\"default-src 'none'; style-src "
         "'unsafe-inline'\">"
         "<meta name=viewport content='width=device-width,initial-scale=1'><title>" +
         html_text(title) + "</title><style>" + kStyle + "</style>\n<h1>" + html_text(title) +
         "</h1>\n";
}

std::string plot_page(const PlotPage& page) {
  std::string out = page_head(page.title);
  for (const std::string& sentence : page.sentences) out += "<p>" + html_text(sentence) + "</p>\n";
  if (!page.facts.empty()) {
    out += "<table>";
    for (const Fact& fact : page.facts)
      out += "<tr><td>" + html_text(fact.name) + "<td>" + html_text(fact.value);
    out += "</table>\n";
  }
  for (const Plot& plot : page.plots) out += plot_section(plot);
  return out + "</html>\n";
}

}  // namespace report
