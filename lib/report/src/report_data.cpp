#include "report_data.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

namespace report {
namespace {

/// Rounded to 7 significant digits, so that a float does not trail the noise of its conversion.
Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, 6.0 - std::floor(std::log10(std::abs(value))));
  const double rounded = std::round(value * scale) / scale;
  return std::isfinite(rounded) ? rounded : value;
}

/// Floats of long curves as text of their own: 6 decimals suffice for metres and slopes, and this
/// is the bulk of the file.
void append_floats(std::string& out, const std::vector<float>& values) {
  std::array<char, 32> buffer{};
  out += '[';
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k > 0) out += ',';
    if (!std::isfinite(values[k])) {
      out += "null";
      continue;
    }
    const double scaled = std::round(static_cast<double>(values[k]) * 1e6);
    if (std::abs(scaled) > 9e15) {
      out += std::to_string(static_cast<double>(values[k]));
      continue;
    }
    auto rest = static_cast<long long>(scaled);
    char* at = buffer.data() + buffer.size();
    const bool negative = rest < 0;
    if (negative) rest = -rest;
    int digits = 0;
    bool significant = false;
    do {
      const auto digit = static_cast<char>('0' + rest % 10);
      rest /= 10;
      if (digits == 6 && significant) *--at = '.';
      significant = significant || digit != '0' || digits >= 6;
      if (significant) *--at = digit;
      ++digits;
    } while (rest > 0 || digits < 7);
    if (negative && !(at[0] == '0' && at + 1 == buffer.data() + buffer.size())) *--at = '-';
    out.append(at, static_cast<std::size_t>(buffer.data() + buffer.size() - at));
  }
  out += ']';
}

Json facts_json(const std::vector<Fact>& facts) {
  Json list = Json::array();
  for (const Fact& fact : facts) list.push_back({{"name", fact.name}, {"value", fact.value}});
  return list;
}

Json findings_json(const TrackReport& report) {
  Json list = Json::array();
  for (const ReportFinding& f : report.findings) {
    list.push_back({{"kind", f.kind},
                    {"severity", f.severity},
                    {"u_begin_m", number(f.u_begin_m)},
                    {"u_end_m", number(f.u_end_m)},
                    {"v_begin_m", number(f.v_begin_m)},
                    {"v_end_m", number(f.v_end_m)},
                    {"value", number(f.value)},
                    {"unit", f.unit},
                    {"text", f.text}});
  }
  return list;
}

Json cross_json(const CrossPlot& plot) {
  Json lines = Json::array();
  for (const auto& [name, z_m] : plot.lines) {
    Json rounded = Json::array();
    for (const double z : z_m)
      rounded.push_back(std::isfinite(z) ? Json(std::round(z * 1e5) / 1e5) : Json(nullptr));
    lines.push_back({{"name", name}, {"z_m", std::move(rounded)}});
  }
  Json v_m = Json::array();
  for (const double v : plot.at_v_m) v_m.push_back(std::round(v * 1e4) / 1e4);
  return {{"title", plot.title},      {"u_m", number(plot.u_m)},
          {"v_m", number(plot.v_m)},  {"value_m", number(plot.value_m)},
          {"at_v_m", std::move(v_m)}, {"lines", std::move(lines)}};
}

Json comparison_json(const ComparisonView& c) {
  Json worst = Json::array();
  for (const CrossPlot& plot : c.worst) worst.push_back(cross_json(plot));
  return {{"key", c.key},
          {"reference", c.reference},
          {"points", c.points},
          {"share_without_reference", number(c.share_without_reference)},
          {"mean_m", number(c.mean_m)},
          {"abs_error_m",
           {{"p50", number(c.p50_m)},
            {"p95", number(c.p95_m)},
            {"p99", number(c.p99_m)},
            {"max", number(c.max_m)}}},
          {"histogram",
           {{"begin_m", number(c.histogram_begin_m)},
            {"step_m", number(c.histogram_step_m)},
            {"counts", c.histogram}}},
          {"worst", std::move(worst)}};
}

Json kerbs_json(const TrackReport& report) {
  Json list = Json::array();
  for (const KerbView& k : report.kerbs) {
    list.push_back({{"u_begin_m", number(k.u_begin_m)},
                    {"u_end_m", number(k.u_end_m)},
                    {"side", k.side},
                    {"v_begin_m", number(k.v_begin_m)},
                    {"v_end_m", number(k.v_end_m)},
                    {"height_m", number(k.height_m)},
                    {"width_m", number(k.width_m)},
                    {"profile", cross_json(k.profile)}});
  }
  return list;
}

Json roughness_json(const TrackReport& report) {
  Json list = Json::array();
  for (const RoughnessTrack& t : report.roughness) {
    Json iri = Json::array();
    for (const IriValue& value : t.iri) {
      iri.push_back({{"u_begin_m", number(value.u_begin_m)},
                     {"u_end_m", number(value.u_end_m)},
                     {"iri_m_per_km", number(value.iri_m_per_km)}});
    }
    Json n_cpm = Json::array(), psd_m3 = Json::array();
    for (const double n : t.n_cpm) n_cpm.push_back(number(n));
    for (const double g : t.psd_m3) psd_m3.push_back(number(g));
    Json track = {{"name", t.name}, {"v_m", number(t.v_m)}, {"before", t.before}};
    if (t.iso_class.empty()) {
      track["iso8608"] = nullptr;
    } else {
      track["iso8608"] = {{"class", t.iso_class},
                          {"psd_at_n0_m3", number(t.psd_at_n0_m3)},
                          {"exponent", number(t.exponent)},
                          {"n_min_cpm", number(t.fit_n_min_cpm)},
                          {"n_max_cpm", number(t.fit_n_max_cpm)},
                          {"band_cut", t.band_cut}};
    }
    if (t.facet_median_m > 0.0) {
      track["facets"] = {{"median_m", number(t.facet_median_m)},
                         {"p10_m", number(t.facet_p10_m)},
                         {"p90_m", number(t.facet_p90_m)}};
    } else {
      track["facets"] = nullptr;
    }
    track["iri"] = std::move(iri);
    track["psd"] = {{"n_cpm", std::move(n_cpm)}, {"psd_m3", std::move(psd_m3)}};
    list.push_back(std::move(track));
  }
  return list;
}

Json rough_json(const TrackReport& report) {
  Json places = Json::array();
  for (const RoughPlaceView& p : report.rough_places) {
    places.push_back({{"u_begin_m", number(p.u_begin_m)},
                      {"u_end_m", number(p.u_end_m)},
                      {"v_min_m", number(p.v_min_m)},
                      {"v_max_m", number(p.v_max_m)},
                      {"largest_error_m", number(p.largest_error_m)},
                      {"reason", p.reason}});
  }
  return {{"limit_m", number(report.rough_limit_m)}, {"places", std::move(places)}};
}

Json inputs_json(const TrackReport& report) {
  Json list = Json::array();
  for (const ReportInputFile& input : report.inputs)
    list.push_back({{"role", input.role}, {"path", input.path}, {"sha256", input.sha256}});
  return list;
}

Json control_points_json(const TrackReport& report) {
  Json list = Json::array();
  for (const ControlPointView& p : report.control_points) {
    list.push_back({{"name", p.name},
                    {"x_m", p.x_m},
                    {"y_m", p.y_m},
                    {"residual_m", number(p.residual_m)},
                    {"left_out", p.left_out}});
  }
  return list;
}

}  // namespace

Json rules_json(const TrackReport& report) {
  Json list = Json::array();
  for (const RuleView& r : report.rules)
    list.push_back({{"what", r.what},
                    {"unit", r.unit},
                    {"limit", number(r.limit)},
                    {"value", number(r.value)},
                    {"seen", r.is_seen},
                    {"u_m", r.u_m ? number(*r.u_m) : Json(nullptr)}});
  return list;
}

Json common_json(const TrackReport& report) {
  Json comparisons = Json::array();
  for (const ComparisonView& c : report.comparisons) comparisons.push_back(comparison_json(c));
  Json extra = Json::array();
  for (const ExtraSection& section : report.extra) {
    Json plots = Json::array();
    for (const CrossPlot& plot : section.plots) plots.push_back(cross_json(plot));
    extra.push_back({{"title", section.title},
                     {"sentences", section.sentences},
                     {"facts", facts_json(section.facts)},
                     {"plots", std::move(plots)}});
  }
  return {{"schema", "kerbstone.report"},
          {"schema_version", 1},
          {"title", report.title},
          {"verdict", report.verdict},
          {"findings", findings_json(report)},
          {"rules", rules_json(report)},
          {"looked_for", report.looked_for},
          {"lead", facts_json(report.lead)},
          {"facts", facts_json(report.facts)},
          {"u_begin_m", report.u_begin_m},
          {"u_step_m", report.u_step_m},
          {"u_end_m", report.u_end_m},
          {"closed", report.closed},
          {"comparisons", std::move(comparisons)},
          {"rough", report.rough_limit_m > 0.0 ? rough_json(report) : Json(nullptr)},
          {"kerbs", kerbs_json(report)},
          {"roughness", roughness_json(report)},
          {"file", facts_json(report.file)},
          {"header", facts_json(report.header)},
          {"comment", report.comment},
          {"notes", report.notes},
          {"inputs", inputs_json(report)},
          {"control_points", control_points_json(report)},
          {"versions", facts_json(report.versions)},
          {"command_line", report.command_line},
          {"extra", std::move(extra)}};
}

std::string dump(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string report_json(const TrackReport& report) {
  // The long curves are appended as text before the last brace of the rest.
  std::string text = dump(common_json(report), 1);
  text.resize(text.rfind('}'));
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  text += ",\n \"along_u\": {";
  for (std::size_t k = 0; k < report.curves.size(); ++k) {
    text += k > 0 ? ",\n  " : "\n  ";
    text += dump(report.curves[k].key, -1) + ": ";
    append_floats(text, report.curves[k].values);
  }
  text += "\n }\n}\n";
  return text;
}

}  // namespace report
