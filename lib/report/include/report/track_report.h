// A validation report as plain numbers and sentences, and its two forms: report.json and one HTML
// page.
//
// Nothing here is computed: whoever fills TrackReport (road::write_report, or a tool with sections
// of its own) did that. Lengths are in metres, u and v as in OpenCRG; NaN: no value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace report {

struct ReportFinding {
  std::string kind;
  std::string severity;  ///< "remark" or "error"
  double u_begin_m = 0.0, u_end_m = 0.0, v_begin_m = 0.0, v_end_m = 0.0;
  double value = 0.0;
  std::string unit;
  std::string text;
};

/// A line of a two-column table.
struct Fact {
  std::string name, value;
};

/// Values at u_begin + k * u_step of the report.
struct Curve {
  std::string key;   ///< of report.json, with its unit: "banking", "elevation_m"
  std::string name;  ///< as a person reads it
  std::string unit;  ///< "m", "%", "1/m"
  std::vector<float> values;
  double show_factor =
      1.0;  ///< the page shows value * show_factor in `unit`; report.json has the value
};

/// One more thing by which the sheet can be coloured.
struct SheetField {
  std::string key, name, unit;
  std::vector<float> values;  ///< rows * columns of its sheet
  double show_factor = 1.0;
  bool signed_scale = false;            ///< colours around zero
  std::vector<std::string> categories;  ///< not empty: values are indices into it
};

/// A piece of road as a grid in space. Node (i, j) lies at
/// (x[i] + v[j] * normal_x[i], y[i] + v[j] * normal_y[i], z_base + z[i * columns + j]).
struct Sheet {
  double u_begin_m = 0.0, u_step_m = 1.0;
  std::vector<double> x_m, y_m, normal_x,
      normal_y;             ///< per row; normals: map metres per metre of v
  std::vector<double> v_m;  ///< ascending
  double z_base_m = 0.0;
  std::vector<float> z_m;
  std::vector<SheetField> fields;
  std::string title;
};

/// Lines over the same v.
struct CrossPlot {
  std::string title;
  double u_m = 0.0, v_m = 0.0;
  double value_m = 0.0;  ///< what it shows: an error, a height
  std::vector<double> at_v_m;
  std::vector<std::pair<std::string, std::vector<double>>> lines;  ///< name, heights
};

/// Differences of the road from something else.
struct ComparisonView {
  std::string key;        ///< "mesh", "against", "before"
  std::string reference;  ///< as a person reads it, e.g. the file's name
  double u_begin_m = 0.0, u_cell_m = 1.0;
  std::vector<double> v_m;
  std::size_t rows = 0;
  std::vector<float> error_m;
  std::vector<std::uint8_t> without_reference;
  std::size_t points = 0;
  double share_without_reference = 0.0, mean_m = 0.0, p50_m = 0.0, p95_m = 0.0, p99_m = 0.0,
         max_m = 0.0;
  double histogram_begin_m = 0.0, histogram_step_m = 1.0;
  std::vector<std::size_t> histogram;
  std::vector<CrossPlot> worst;
};

/// A stretch where the road leaves its mesh, and why.
struct RoughPlaceView {
  double u_begin_m = 0.0, u_end_m = 0.0, v_min_m = 0.0, v_max_m = 0.0, largest_error_m = 0.0;
  std::string reason;
};

struct KerbView {
  double u_begin_m = 0.0, u_end_m = 0.0, v_begin_m = 0.0, v_end_m = 0.0, height_m = 0.0,
         width_m = 0.0;
  std::string side;
  CrossPlot profile;
};

struct IriValue {
  double u_begin_m = 0.0, u_end_m = 0.0, iri_m_per_km = 0.0;
};

struct RoughnessTrack {
  std::string name;  ///< "left wheel", "right wheel", "left wheel before"
  double v_m = 0.0;
  bool before = false;
  std::vector<double> n_cpm, psd_m3;
  std::string iso_class;  ///< empty: none could be fitted, or facets would be taken for roughness
  double psd_at_n0_m3 = 0.0, exponent = 0.0, fit_n_min_cpm = 0.0, fit_n_max_cpm = 0.0;
  bool band_cut = false;
  double facet_median_m = 0.0, facet_p10_m = 0.0, facet_p90_m = 0.0;  ///< 0: no facets seen
  std::vector<IriValue> iri;
};

struct ReportInputFile {
  std::string role, path, sha256;
};

struct ControlPointView {
  std::string name;
  double x_m = 0.0, y_m = 0.0, residual_m = 0.0;
  bool left_out = false;  ///< an outlier: the alignment did not use it
};

/// One rule of the verdict, met or not.
struct RuleView {
  std::string what, unit;
  double limit = 0.0;  ///< beyond: not usable
  double value = 0.0;  ///< the largest seen; where none is known, what would have been seen
  bool is_seen = false;
  std::optional<double> u_m;  ///< where, if at one place
};

/// A section that another tool adds.
struct ExtraSection {
  std::string title;
  std::vector<std::string> sentences;
  std::vector<Fact> facts;
  std::vector<CrossPlot> plots;
};

struct TrackReport {
  std::string title;
  std::string verdict;  ///< "usable", "usable_with_remarks", "not_usable"
  std::vector<ReportFinding> findings;
  std::vector<RuleView> rules;  ///< of the verdict, those that are kept among them
  std::vector<std::string>
      looked_for;           ///< sentences with the limits beyond which something is a finding
  std::vector<Fact> lead;   ///< what the page begins with, below the verdict; mostly empty
  std::vector<Fact> facts;  ///< the few numbers beside the verdict
  double u_begin_m = 0.0, u_step_m = 1.0, u_end_m = 0.0;  ///< of the curves
  bool closed = false;
  std::vector<Curve> curves;
  Sheet sheet;                 ///< the whole road, decimated
  std::vector<Sheet> windows;  ///< full detail where it matters
  Sheet detail;  ///< heights at every v in some rows, for cuts anywhere; without x, y and fields.
                 ///< May be empty
  std::vector<ComparisonView> comparisons;
  std::vector<RoughPlaceView> rough_places;  ///< beyond rough_limit_m from the mesh
  double rough_limit_m = 0.0;                ///< 0: not looked for
  std::vector<KerbView> kerbs;
  std::vector<RoughnessTrack> roughness;
  std::vector<Fact> file;                   ///< what the file is: format, rows, bytes, ...
  std::vector<Fact> header;                 ///< header entries as stored
  std::vector<std::string> comment, notes;  ///< of the file; what its build and its reading say
  std::vector<ReportInputFile> inputs;
  std::vector<ControlPointView> control_points;
  std::vector<Fact> versions;
  std::string command_line;
  std::vector<ExtraSection> extra;
};

/// report.json: every number except those of the sheets and error maps, keys and units in
/// docs/report.md. NaN becomes null, bytes that are no UTF-8 become U+FFFD.
std::string report_json(const TrackReport& report);

/// Whether this build has the page (it is made from npm packages, see scripts/setup).
bool page_available();

/// report.html: one file without references to anything outside it. All text of the report is data
/// for the page's script, which never takes it for markup. Throws std::logic_error without a page.
std::string report_page(const TrackReport& report);

}  // namespace report
