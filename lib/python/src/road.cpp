// lib/crg for Python, with numpy arrays in and out. Names and answers are those
// of crg/surface.h; what users of Python read is in the docstrings below and in kerbstone.pyi.
#include "road.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/output_set.h"
#include "base/write_file.h"
#include "crg/check.h"
#include "crg/edit.h"
#include "crg/file.h"
#include "crg/options.h"
#include "crg/surface.h"
#include "road_arrays.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

using namespace pybind11::literals;

std::unique_ptr<Road> road_of(crg::Crg file, const crg::SurfaceOptions& options = {}) {
  return std::make_unique<Road>(Road{crg::Surface(std::move(file), options), options});
}

crg::SurfaceOptions options_with(const std::string& interpolation, double friction) {
  crg::SurfaceOptions out;
  if (interpolation == "smooth")
    out.interpolation = crg::Interpolation::Smooth;
  else if (interpolation != "bilinear")
    throw py::value_error("interpolation '" + interpolation +
                          "' seen; 'bilinear' or 'smooth' wanted");
  if (!(friction >= 0) || !std::isfinite(friction))
    throw py::value_error("friction " + std::to_string(friction) + " seen; a number from 0 wanted");
  out.friction = friction;
  return out;
}

std::unique_ptr<Road> read_road(const std::filesystem::path& path, bool apply_modifiers,
                                const std::string& interpolation, double friction,
                                const std::optional<std::filesystem::path>& friction_map) {
  crg::SurfaceOptions options = options_with(interpolation, friction);
  py::gil_scoped_release free;
  base::check_in_set(path.string());
  if (friction_map) base::check_in_set(friction_map->string());
  crg::Crg file = crg::read(path.string());
  if (!apply_modifiers) file.modifiers.clear();
  if (!file.modifiers.empty()) file = crg::apply_modifiers(std::move(file));
  if (friction_map) options.friction_map = crg::read(friction_map->string());
  return road_of(std::move(file), options);
}

std::vector<double> one_per(const Numbers& x, py::ssize_t rows, const char* name) {
  if (x.ndim() != 1 || x.shape(0) != rows)
    throw py::value_error(std::string(name) + ": one value per row of z_m wanted");
  return {x.data(), x.data() + rows};
}

std::unique_ptr<Road> from_arrays(
    const Numbers& x_m, const Numbers& y_m, const Numbers& v_m,
    const py::array_t<float, py::array::c_style | py::array::forcecast>& z_m,
    std::optional<double> u_step_m, double u_begin_m, bool closed) {
  if (z_m.ndim() != 2 || z_m.shape(0) < 2 || z_m.shape(1) < 2)
    throw py::value_error(
        "z_m: heights of at least two rows along the road and two columns across it wanted");
  if (v_m.ndim() != 1 || v_m.shape(0) != z_m.shape(1))
    throw py::value_error("v_m: one value per column of z_m wanted");
  crg::ReferenceLine line;
  line.u_begin_m = u_begin_m;
  line.x_m = one_per(x_m, z_m.shape(0), "x_m");
  line.y_m = one_per(y_m, z_m.shape(0), "y_m");
  line.closed = closed;
  const std::size_t rows = line.size();
  std::vector<double> step_m;
  line.heading_rad.assign(rows, 0.0);
  for (std::size_t i = 1; i < rows; ++i) {
    const double dx = line.x_m[i] - line.x_m[i - 1], dy = line.y_m[i] - line.y_m[i - 1];
    step_m.push_back(std::hypot(dx, dy));
    const double before = line.heading_rad[i - 1];
    line.heading_rad[i] =
        i == 1 ? std::atan2(dy, dx)
               : before + std::remainder(std::atan2(dy, dx) - before, 2 * std::numbers::pi);
  }
  line.heading_rad[0] = line.heading_rad[1];
  std::vector<double> sorted = step_m;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  line.u_step_m = u_step_m.value_or(sorted[sorted.size() / 2]);
  if (!(line.u_step_m > 0)) throw py::value_error("u_step_m: more than 0 wanted");
  // The steps along the line are all alike in the format.
  for (std::size_t i = 0; i + 1 < rows; ++i)
    if (!(std::abs(step_m[i] - line.u_step_m) <= 1e-3 * line.u_step_m))
      throw py::value_error("x_m, y_m: from row " + std::to_string(i) + " to the next it is " +
                            std::to_string(step_m[i]) + " m, and " + std::to_string(line.u_step_m) +
                            " m are wanted between all rows; resample the line to equal steps");
  crg::Grid grid;
  grid.u_begin_m = u_begin_m;
  grid.u_step_m = line.u_step_m;
  grid.v_m.assign(v_m.data(), v_m.data() + v_m.size());
  grid.z_m.assign(z_m.data(), z_m.data() + z_m.size());
  py::gil_scoped_release free;
  return road_of(crg::make_crg(line, std::move(grid)));
}

crg::Format format_of(const std::string& name) {
  for (const auto& [known, format] : {std::pair{"KRBI", crg::Format::KRBI},
                                      {"KDBI", crg::Format::KDBI},
                                      {"LRFI", crg::Format::LRFI},
                                      {"LDFI", crg::Format::LDFI}})
    if (name == known) return format;
  throw py::value_error("format '" + name + "' seen; KRBI, KDBI, LRFI or LDFI wanted");
}

/// All that makes the road again, bit for bit.
py::tuple state_of(const Road& road) {
  const auto bytes_of = [](const crg::Crg& file) {
    return py::bytes(crg::to_bytes(file, crg::Format::KDBI));
  };
  const crg::SurfaceOptions& options = road.options;
  return py::make_tuple(
      bytes_of(road.surface.file()), options.interpolation == crg::Interpolation::Smooth,
      options.friction,
      options.friction_map ? py::object(bytes_of(*options.friction_map)) : py::object(py::none()));
}

std::unique_ptr<Road> road_of_state(const py::tuple& state) {
  if (state.size() != 4) throw py::value_error("not the state of a Road");
  const auto file_of = [](const py::handle& bytes) {
    return crg::read_bytes(bytes.cast<std::string>(), "pickled road");
  };
  crg::SurfaceOptions options;
  if (state[1].cast<bool>()) options.interpolation = crg::Interpolation::Smooth;
  options.friction = state[2].cast<double>();
  if (!state[3].is_none()) options.friction_map = file_of(state[3]);
  return road_of(file_of(state[0]), options);
}

void add_sample(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(crg::Sample, valid, inside, u_m, v_m, x_m, y_m, z_m, dzdx, dzdy, heading_rad,
                       curvature_1pm, normal_x, normal_y, normal_z, friction);

  py::class_<crg::Sample>(m, "Sample", "Everything a query answers; NaN where there is no road.")
      .def_readonly("valid", &crg::Sample::valid, "there is a road")
      .def_readonly("inside", &crg::Sample::inside, "u and v lie within the grid")
      .def_readonly("u_m", &crg::Sample::u_m)
      .def_readonly("v_m", &crg::Sample::v_m)
      .def_readonly("x_m", &crg::Sample::x_m)
      .def_readonly("y_m", &crg::Sample::y_m)
      .def_readonly("z_m", &crg::Sample::z_m)
      .def_readonly("dzdx", &crg::Sample::dzdx, "gradient along map x")
      .def_readonly("dzdy", &crg::Sample::dzdy, "gradient along map y")
      .def_readonly("heading_rad", &crg::Sample::heading_rad,
                    "of the reference line, counter-clockwise from +x")
      .def_readonly("curvature_1pm", &crg::Sample::curvature_1pm,
                    "of the line through the point, left turn positive")
      .def_readonly("normal_x", &crg::Sample::normal_x)
      .def_readonly("normal_y", &crg::Sample::normal_y)
      .def_readonly("normal_z", &crg::Sample::normal_z)
      .def_readonly("friction", &crg::Sample::friction)
      .def("__repr__", [](const crg::Sample& s) {
        return "Sample(u_m=" + std::to_string(s.u_m) + ", v_m=" + std::to_string(s.v_m) +
               ", z_m=" + std::to_string(s.z_m) + ")";
      });
}

void add_finding(py::module_& m) {
  py::class_<crg::Finding>(m, "Finding", "Something that is wrong or odd about a file.")
      .def_property_readonly(
          "severity", [](const crg::Finding& f) { return crg::name_of(f.severity); },
          "note, warning or error")
      .def_readonly("rule", &crg::Finding::rule, "short stable name")
      .def_readonly("message", &crg::Finding::message, "value seen and value wanted, with units")
      .def_readonly("row", &crg::Finding::row, "first grid row concerned, or None")
      .def_readonly("count", &crg::Finding::count, "how often it occurs")
      .def("__repr__",
           [](const crg::Finding& f) { return "Finding(" + f.rule + ": " + f.message + ")"; });
}

/// Where roads come from and go to.
void add_files(py::class_<Road>& type) {
  type.def_static(
          "read", &read_road,
          "Reads an OpenCRG file. Its modifiers are worked in, unless apply_modifiers is False.\n"
          "interpolation: 'bilinear' (the standard) or 'smooth'. friction holds where there is no "
          "friction_map,\n"
          "which is the path of a second file of the same shape whose heights are friction "
          "coefficients.",
          "path"_a, py::kw_only(), "apply_modifiers"_a = true, "interpolation"_a = "bilinear",
          "friction"_a = 1.0, "friction_map"_a = py::none())
      .def_static(
          "from_arrays", &from_arrays,
          "A road from the nodes of its reference line, equal steps apart (to 0.1 %), and heights\n"
          "z_m[row, column] at row and v_m[column]; v ascends and is positive to the left. NaN: no "
          "road.",
          "x_m"_a, "y_m"_a, "v_m"_a, "z_m"_a, py::kw_only(), "u_step_m"_a = py::none(),
          "u_begin_m"_a = 0.0, "closed"_a = false)
      .def(
          "write",
          [](const Road& road, const std::filesystem::path& path, const std::string& format) {
            const crg::Format wanted = format_of(format);
            py::gil_scoped_release free;
            base::write_file(path.string(), crg::to_bytes(road.surface.file(), wanted));
          },
          "Writes the road, whole or not at all. KRBI, KDBI: binary floats or doubles; LRFI, LDFI: "
          "text.",
          "path"_a, "format"_a = "KRBI")
      .def(
          "check", [](const Road& road) { return crg::check(road.surface.file()).findings; },
          "What is wrong or odd about the file; empty where nothing is.")
      .def(py::pickle(&state_of, &road_of_state));
}

/// What a road answers. Numbers first: they need no array.
void add_queries(py::class_<Road>& type) {
  type.def(
          "z",
          [](Road& road, double x_m, double y_m) {
            return road.surface.z_at_xy(x_m, y_m, road.cursor);
          },
          "x_m"_a.noconvert(), "y_m"_a.noconvert())
      .def("z", &z_of_arrays,
           "Height at map points; numbers or arrays. NaN beside the road or on a hole.", "x_m"_a,
           "y_m"_a)
      .def(
          "z_at_uv",
          [](const Road& road, double u_m, double v_m) { return road.surface.z_at_uv(u_m, v_m); },
          "u_m"_a.noconvert(), "v_m"_a.noconvert())
      .def("z_at_uv", &z_of_uv_arrays, "Height at (u, v); numbers or arrays.", "u_m"_a, "v_m"_a)
      .def(
          "uv",
          [](Road& road, double x_m, double y_m) {
            const crg::UV at = road.surface.uv_of_xy(x_m, y_m, road.cursor);
            return std::pair{at.u_m, at.v_m};
          },
          "x_m"_a.noconvert(), "y_m"_a.noconvert())
      .def(
          "uv",
          [](const Road& road, const py::object& x_m, const py::object& y_m) {
            crg::Cursor cursor;
            return two_of_arrays(x_m, y_m, [&](double x, double y) {
              const crg::UV at = road.surface.uv_of_xy(x, y, cursor);
              return std::pair{at.u_m, at.v_m};
            });
          },
          "(u, v) of map points; numbers or arrays.", "x_m"_a, "y_m"_a)
      .def(
          "xy",
          [](const Road& road, double u_m, double v_m) {
            const crg::Point2 at = road.surface.xy_of_uv(u_m, v_m);
            return std::pair{at.x_m, at.y_m};
          },
          "u_m"_a.noconvert(), "v_m"_a.noconvert())
      .def(
          "xy",
          [](const Road& road, const py::object& u_m, const py::object& v_m) {
            return two_of_arrays(u_m, v_m, [&](double u, double v) {
              const crg::Point2 at = road.surface.xy_of_uv(u, v);
              return std::pair{at.x_m, at.y_m};
            });
          },
          "Map points of (u, v); numbers or arrays.", "u_m"_a, "v_m"_a)
      .def(
          "sample",
          [](Road& road, double x_m, double y_m) {
            return road.surface.at_xy(x_m, y_m, road.cursor);
          },
          "x_m"_a.noconvert(), "y_m"_a.noconvert())
      .def("sample", &samples_of_arrays,
           "Everything at map points: a Sample for numbers, for arrays a record array with the "
           "same names.",
           "x_m"_a, "y_m"_a)
      .def("strip", &strip_of,
           "Heights under a contact patch: along x across samples, step_m apart, centred on (x_m, "
           "y_m).",
           "x_m"_a, "y_m"_a, "heading_rad"_a, py::kw_only(), "along"_a = 10, "across"_a = 40,
           "step_m"_a = 0.01);
}

/// Roads made from roads.
void add_edits(py::class_<Road>& type) {
  type.def(
          "crop",
          [](const Road& road, std::optional<double> u_begin_m, std::optional<double> u_end_m,
             std::optional<double> v_right_m, std::optional<double> v_left_m) {
            return road_of(
                crg::crop(road.surface.file(), {u_begin_m, u_end_m, v_right_m, v_left_m}));
          },
          "The rows and columns within.", py::kw_only(), "u_begin_m"_a = py::none(),
          "u_end_m"_a = py::none(), "v_right_m"_a = py::none(), "v_left_m"_a = py::none())
      .def(
          "resample",
          [](const Road& road, std::optional<double> u_step_m, std::optional<double> v_step_m) {
            return road_of(crg::resample(road.surface.file(), {u_step_m, v_step_m}));
          },
          "The same road on another grid.", py::kw_only(), "u_step_m"_a = py::none(),
          "v_step_m"_a = py::none())
      .def(
          "reverse", [](const Road& road) { return road_of(crg::reverse(road.surface.file())); },
          "The road driven the other way.")
      .def(
          "append",
          [](const Road& road, const Road& second, bool move) {
            return road_of(crg::append(road.surface.file(), second.surface.file(), {move}));
          },
          "Both roads in one; move: bring the second to the end of the first.", "second"_a,
          py::kw_only(), "move"_a = false);
}

/// What a road holds.
void add_nodes(py::class_<Road>& type) {
  type.def_property_readonly(
          "z_m",
          [](const py::object& self) {
            const crg::Grid& grid = self.cast<const Road&>().surface.grid();
            return view_of(
                self, grid.z_m,
                {static_cast<py::ssize_t>(grid.rows()), static_cast<py::ssize_t>(grid.columns())});
          },
          "Heights of the grid's nodes above the line's own, [row, column]; read only, not copied.")
      .def_property_readonly(
          "v_m",
          [](const py::object& self) {
            const crg::Grid& grid = self.cast<const Road&>().surface.grid();
            return view_of(self, grid.v_m, {static_cast<py::ssize_t>(grid.columns())});
          },
          "Of the columns, ascending; read only.")
      .def_property_readonly(
          "x_m",
          [](const py::object& self) {
            const crg::ReferenceLine& line = self.cast<const Road&>().surface.reference_line();
            return view_of(self, line.x_m, {static_cast<py::ssize_t>(line.size())});
          },
          "Of the reference line's nodes; read only.")
      .def_property_readonly(
          "y_m",
          [](const py::object& self) {
            const crg::ReferenceLine& line = self.cast<const Road&>().surface.reference_line();
            return view_of(self, line.y_m, {static_cast<py::ssize_t>(line.size())});
          },
          "Of the reference line's nodes; read only.")
      .def_property_readonly(
          "heading_rad",
          [](const py::object& self) {
            const crg::ReferenceLine& line = self.cast<const Road&>().surface.reference_line();
            return view_of(self, line.heading_rad, {static_cast<py::ssize_t>(line.size())});
          },
          "Of the segment that ends at each node, the first is the start heading; read only.");
}

/// Its sizes.
void add_facts(py::class_<Road>& type) {
  type.def_property_readonly("u_begin_m",
                             [](const Road& road) { return road.surface.grid().u_begin_m; })
      .def_property_readonly("u_step_m",
                             [](const Road& road) { return road.surface.grid().u_step_m; })
      .def_property_readonly("length_m",
                             [](const Road& road) {
                               const crg::ReferenceLine& line = road.surface.reference_line();
                               return line.u_step_m * static_cast<double>(line.size() - 1);
                             })
      .def_property_readonly("closed", [](const Road& road) { return road.surface.closed(); })
      .def_property_readonly(
          "notes", [](const Road& road) { return road.surface.file().notes; },
          "What was accepted although it is not quite the standard.")
      .def("__repr__", [](const Road& road) {
        const crg::ReferenceLine& line = road.surface.reference_line();
        const crg::Grid& grid = road.surface.grid();
        return "Road(" + std::string(line.closed ? "closed" : "open") + ", " +
               std::to_string(line.u_step_m * static_cast<double>(line.size() - 1)) + " m, " +
               std::to_string(grid.rows()) + " x " + std::to_string(grid.columns()) + " nodes)";
      });
}

}  // namespace

void add_road(py::module_& m) {
  add_sample(m);
  add_finding(m);
  py::class_<Road> road(m, "Road", "A road: a reference line with heights z(u, v) above it.");
  add_files(road);
  add_queries(road);
  add_edits(road);
  add_nodes(road);
  add_facts(road);
}

}  // namespace kerbstone
