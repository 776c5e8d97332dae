// Any log as a table of channels, before anything is mapped: what `kerbstone open` lists.
#include "recording/log.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "recording/look.h"
#include "road.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

using recording::ChannelLook;

struct OpenedLog {
  recording::Log log;
  std::vector<ChannelLook> looks;
  std::string path;
};

/// A channel of a log, which stays as long as it.
struct OpenedChannel {
  std::shared_ptr<const OpenedLog> of;
  std::size_t place = 0;

  const recording::Channel& channel() const { return of->log.channels[place]; }
  const ChannelLook& look() const { return of->looks[place]; }
};

py::array_t<double> array_of(const std::vector<double>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

std::shared_ptr<OpenedLog> open_log(const std::filesystem::path& path) {
  const py::gil_scoped_release free;
  auto out = std::make_shared<OpenedLog>();
  out->path = path.string();
  out->log = recording::read_log(out->path);
  out->looks = recording::look_at_channels(out->log);
  return out;
}

std::vector<std::string> names_of(const OpenedLog& opened) {
  std::vector<std::string> out;
  for (const ChannelLook& look : opened.looks) out.push_back(look.name);
  return out;
}

/// A notebook's table of the channels.
std::string html_of(const OpenedLog& opened) {
  const auto escape = py::module_::import("html").attr("escape");
  const auto text = [&](const std::string& of) { return py::cast<std::string>(escape(of)); };
  std::string out = fmt::format(
      "<p>{}, {} channels</p><table><tr><th>channel<th>unit<th>rate, "
      "Hz<th>samples<th>least<th>greatest<th>remark",
      text(opened.log.format), opened.looks.size());
  for (const ChannelLook& look : opened.looks)
    out += fmt::format("<tr><td>{}<td>{}<td>{:.4g}<td>{}<td>{:.6g}<td>{:.6g}<td>{}",
                       text(look.name), text(look.unit), look.rate_hz, look.samples, look.least,
                       look.greatest, look.dead ? "dead" : "");
  return out + "</table>";
}

OpenedChannel channel_of(const std::shared_ptr<OpenedLog>& opened, const std::string& name) {
  for (std::size_t k = 0; k < opened->looks.size(); ++k)
    if (opened->looks[k].name == name) return {opened, k};
  throw py::key_error(name);
}

py::object dataframe_of(const OpenedLog& opened) {
  const recording::Log rows = recording::in_rows(opened.log, opened.path);
  py::dict columns;
  for (const recording::Channel& channel : rows.channels)
    columns[py::str(channel.name)] = array_of(channel.values);
  return py::module_::import("pandas").attr("DataFrame")(columns);
}

void add_channel(py::module_& m) {
  py::class_<OpenedChannel> type(m, "LogChannel", "One channel of a log, as logged.");
  const auto fact = [&](const char* name, auto ChannelLook::*member, const char* text) {
    type.def_property_readonly(
        name, [member](const OpenedChannel& c) { return c.look().*member; }, text);
  };
  fact("name", &ChannelLook::name, "as in the file");
  fact("unit", &ChannelLook::unit, "as in the file; empty: it names none");
  fact("rate_hz", &ChannelLook::rate_hz, "0: the file has no clock");
  fact("samples", &ChannelLook::samples, "that are numbers");
  fact("words", &ChannelLook::words, "cells that were none");
  fact("least", &ChannelLook::least, "of the samples; 0 where there are none");
  fact("greatest", &ChannelLook::greatest, "of the samples; 0 where there are none");
  fact("held", &ChannelLook::held, "share of the samples that repeat the one before");
  fact("dead", &ChannelLook::dead, "one value in all of 50 samples or more");
  fact("longest_gap_s", &ChannelLook::longest_gap_s, "between two samples; 0: no clock");
  type.def_property_readonly(
          "values", [](const OpenedChannel& c) { return array_of(c.channel().values); },
          "NaN: an empty cell")
      .def_property_readonly(
          "time_s",
          [](const OpenedChannel& c) {
            return array_of(recording::moments_of(c.of->log, c.channel()));
          },
          "the moments of the values; empty: no clock")
      .def("__repr__", [](const OpenedChannel& c) {
        return fmt::format("LogChannel({} [{}], {} samples, {:.4g} Hz, {:.6g} to {:.6g}{})",
                           c.look().name, c.look().unit.empty() ? "?" : c.look().unit,
                           c.look().samples, c.look().rate_hz, c.look().least, c.look().greatest,
                           c.look().dead ? ", dead" : "");
      });
}

}  // namespace

void add_log(py::module_& m) {
  using namespace pybind11::literals;
  add_channel(m);
  py::class_<OpenedLog, std::shared_ptr<OpenedLog>> type(
      m, "Log", "A log as it was logged: a mapping from names to channels.");
  type.def("__getitem__", &channel_of, "A channel by its name in the file.", "name"_a)
      .def("__len__", [](const OpenedLog& opened) { return opened.looks.size(); })
      .def("__iter__", [](const OpenedLog& opened) { return py::iter(py::cast(names_of(opened))); })
      .def("keys", &names_of)
      .def_property_readonly(
          "channels",
          [](const std::shared_ptr<OpenedLog>& opened) {
            std::vector<OpenedChannel> out;
            for (std::size_t k = 0; k < opened->looks.size(); ++k) out.push_back({opened, k});
            return out;
          },
          "all channels, in the order of the file")
      .def_property_readonly(
          "format", [](const OpenedLog& opened) { return opened.log.format; },
          "'CSV', 'MoTeC .ld', 'Racelogic .vbo', 'iRacing .ibt', 'MCAP' or 'rosbag2'")
      .def_property_readonly(
          "notes", [](const OpenedLog& opened) { return opened.log.notes; },
          "what was not read and why, a sentence each")
      .def("to_dataframe", &dataframe_of,
           "The channels as columns of a pandas.DataFrame, one row for each moment of the fastest; "
           "wants pandas.")
      .def("__repr__",
           [](const OpenedLog& opened) {
             return fmt::format("Log({}, {} channels)", opened.log.format, opened.looks.size());
           })
      .def("_repr_html_", &html_of);
  m.def("open", &open_log,
        "Opens a log of any kind as a table of channels, before anything is known of what they "
        "mean, as `kerbstone open` does.\nRaises Error with the format's name where it cannot be "
        "read.",
        "path"_a);
}

}  // namespace kerbstone
