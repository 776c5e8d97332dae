// The OpenCRG C API of this project beside another library with the same interface, in one run.
//
//   crg_api_bench [--library FILE] [--km LENGTH] [--rounds NUMBER]
//
// Both are loaded at run time and called through the same pointers, in turn, on the same points of
// the same file; without --library ours alone. Processor time of this thread; the median of the
// rounds, and the median of their ratios. Figures: docs/evidence.md.
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "crg/roads.h"
#include "crg/surface.h"

namespace {

constexpr double kHalfWidth_m = 7.5;

struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

using Pair = int (*)(int, double, double, double*, double*);
using One = int (*)(int, double, double, double*);

/// A library with the interface, and what is called of it.
struct Library {
  explicit Library(const std::string& path) : name(path) {
    // Local, so that neither library finds the functions of the other.
    void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) throw Failure(::dlerror());
    const auto find = [&](const char* function, auto& pointer) {
      void* symbol = ::dlsym(handle, function);
      if (symbol == nullptr)
        throw Failure(path + ": no " + function + "; wanted a library with the OpenCRG C API");
      std::memcpy(&pointer, &symbol, sizeof pointer);
    };
    find("crgMsgSetLevel", set_level);
    find("crgLoaderReadFile", read_file);
    find("crgCheck", check);
    find("crgDataSetRelease", release);
    find("crgContactPointCreate", create_point);
    find("crgEvalxy2z", xy_to_z);
    find("crgEvaluv2z", uv_to_z);
    find("crgEvalxy2uv", xy_to_uv);
    find("crgEvaluv2xy", uv_to_xy);
    find("crgEvalxy2pk", xy_to_pk);
    find("crgEvaluv2pk", uv_to_pk);
    set_level(1);  // what is fatal
  }
  int load(const std::string& path) const {
    const int set = read_file(path.c_str());
    if (set <= 0) throw Failure(name + ": cannot read " + path);
    if (check(set) != 1) throw Failure(name + ": " + path + " does not pass its check");
    return set;
  }

  std::string name;
  void (*set_level)(int) = nullptr;
  int (*read_file)(const char*) = nullptr;
  int (*check)(int) = nullptr;
  int (*release)(int) = nullptr;
  int (*create_point)(int) = nullptr;
  One xy_to_z = nullptr, uv_to_z = nullptr;
  Pair xy_to_uv = nullptr, uv_to_xy = nullptr, xy_to_pk = nullptr, uv_to_pk = nullptr;
};

double now_s() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A closed, banked circuit, 0.1 x 0.1 m, 15 m wide.
crg::Crg road_of(double km) {
  const auto rows = static_cast<std::size_t>(std::lround(km * 10000.0)) + 1;
  crg::ReferenceLine line = crg::test::circuit(rows, 150.0 * km, 0.12, 5);
  for (std::size_t i = 0; i < rows; ++i) {
    const double t = 2.0 * M_PI * static_cast<double>(i) / static_cast<double>(rows - 1);
    line.z_m.push_back(200.0 + 10.0 * std::sin(2.0 * t));
    line.banking.push_back(0.04 * std::sin(5.0 * t));
  }
  return crg::make_crg(
      line, crg::test::grid_of(line, -kHalfWidth_m, kHalfWidth_m, 151, [](double u, double v) {
        return 0.01 * std::sin(7.0 * u) + 0.02 * std::cos(0.9 * v);
      }));
}

/// What is asked for: u, v and x, y of the same places.
struct Places {
  std::vector<crg::UV> uv;
  std::vector<crg::Point2> xy;
  std::size_t wheels = 1;  ///< contact points that take turns
};

Places driving(const crg::Surface& road) {
  const crg::ReferenceLine& line = road.reference_line();
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  Places places;
  places.wheels = 4;
  for (double u = 2.0; u < length - 2.0; u += 0.06)  // 60 m/s, 1 ms
    for (const double du : {1.4, -1.4})
      for (const double dv : {0.8, -0.8})
        places.uv.push_back({u + du, 4.0 * std::sin(u / 90.0) + dv});
  for (const crg::UV& p : places.uv) places.xy.push_back(road.xy_of_uv(p.u_m, p.v_m));
  return places;
}

Places anywhere(const crg::Surface& road) {
  const crg::ReferenceLine& line = road.reference_line();
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u_of(
      2.0, line.u_step_m * static_cast<double>(line.size() - 1) - 2.0),
      v_of(-0.99 * kHalfWidth_m, 0.99 * kHalfWidth_m);
  Places places;
  for (int k = 0; k < 20000; ++k) places.uv.push_back({u_of(random), v_of(random)});
  for (const crg::UV& p : places.uv) places.xy.push_back(road.xy_of_uv(p.u_m, p.v_m));
  return places;
}

/// One library on one road.
struct Side {
  Side(const Library& used, const std::string& file) : library(used), set(used.load(file)) {
    for (int& point : points)
      if ((point = library.create_point(set)) < 0) throw Failure(library.name + ": no point");
  }
  const Library& library;
  int set;
  int points[4]{};
};

struct Row {
  const char* name;
  const Places* places;
  /// Answers into `out`; 0 where the call failed.
  int (*ask)(const Side&, int point, const crg::UV&, const crg::Point2&, double out[2]);
};

/// Seconds for all places; the answers in `answers`.
double asked(const Row& row, const Side& side, std::vector<double>& answers) {
  answers.assign(2 * row.places->uv.size(), 0.0);
  const double begin = now_s();
  for (std::size_t k = 0; k < row.places->uv.size(); ++k) {
    if (row.ask(side, side.points[k % row.places->wheels], row.places->uv[k], row.places->xy[k],
                &answers[2 * k]) != 1)
      throw Failure(fmt::format("{}: {} failed at u = {} m, v = {} m", side.library.name, row.name,
                                row.places->uv[k].u_m, row.places->uv[k].v_m));
  }
  return now_s() - begin;
}

std::vector<Row> rows_of(const Places& lap, const Places& random) {
  const auto xy_to_z = [](const Side& s, int point, const crg::UV&, const crg::Point2& p,
                          double out[2]) { return s.library.xy_to_z(point, p.x_m, p.y_m, out); };
  const auto uv_to_z = [](const Side& s, int point, const crg::UV& p, const crg::Point2&,
                          double out[2]) { return s.library.uv_to_z(point, p.u_m, p.v_m, out); };
  return {
      {"crgEvalxy2z, driving", &lap, xy_to_z},
      {"crgEvaluv2z, driving", &lap, uv_to_z},
      {"crgEvalxy2uv, driving", &lap,
       [](const Side& s, int point, const crg::UV&, const crg::Point2& p, double out[2]) {
         return s.library.xy_to_uv(point, p.x_m, p.y_m, out, out + 1);
       }},
      {"crgEvaluv2xy, driving", &lap,
       [](const Side& s, int point, const crg::UV& p, const crg::Point2&, double out[2]) {
         return s.library.uv_to_xy(point, p.u_m, p.v_m, out, out + 1);
       }},
      {"crgEvaluv2pk, driving", &lap,
       [](const Side& s, int point, const crg::UV& p, const crg::Point2&, double out[2]) {
         return s.library.uv_to_pk(point, p.u_m, p.v_m, out, out + 1);
       }},
      {"crgEvalxy2pk, driving", &lap,
       [](const Side& s, int point, const crg::UV&, const crg::Point2& p, double out[2]) {
         return s.library.xy_to_pk(point, p.x_m, p.y_m, out, out + 1);
       }},
      {"crgEvalxy2z, random", &random, xy_to_z},
      {"crgEvaluv2z, random", &random, uv_to_z},
  };
}

void print(const char* name, const char* unit, double ours, std::optional<double> theirs,
           double ratio, double difference) {
  if (!theirs) {
    fmt::print("{:24} {:8.2f} {}\n", name, ours, unit);
  } else {
    fmt::print("{:24} {:8.2f} {:8.2f} {:4} {:8.2f} {:11.1e}\n", name, ours, *theirs, unit, ratio,
               difference);
  }
}

/// Each is first as often as the other: the second finds the machine as the first left it.
std::size_t turn(std::size_t n, int round, std::size_t count) {
  return (n + static_cast<std::size_t>(round)) % count;
}

void measure(const std::vector<Library>& libraries, const std::string& file, int rounds) {
  const crg::Surface road(crg::read(file));
  const Places lap = driving(road), random = anywhere(road);
  if (libraries.size() > 1) {
    fmt::print("{:24} {:>8} {:>8} {:4} {:>8} {:>11}\n", "", "ours", "other", "", "ratio",
               "difference");
  }
  std::vector<double> spent[2], ratios;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t n = 0; n < libraries.size(); ++n) {
      const std::size_t l = turn(n, round, libraries.size());
      const double begin = now_s();
      const int set = libraries[l].load(file);
      spent[l].push_back(1e3 * (now_s() - begin));
      libraries[l].release(set);
    }
    if (libraries.size() > 1) ratios.push_back(spent[1].back() / spent[0].back());
  }
  const auto other = [&](double scale) {
    return libraries.size() > 1 ? std::optional(scale) : std::nullopt;
  };
  print("read and check", "ms", median(spent[0]),
        libraries.size() > 1 ? other(median(spent[1])) : std::nullopt,
        ratios.empty() ? 1.0 : median(ratios), 0.0);
  std::vector<Side> sides;
  sides.reserve(libraries.size());
  for (const Library& library : libraries) sides.emplace_back(library, file);
  for (const Row& row : rows_of(lap, random)) {
    std::vector<double> answers[2], rates[2], of_round;
    for (int round = 0; round < rounds; ++round) {
      double seconds[2]{};
      for (std::size_t n = 0; n < sides.size(); ++n) {
        const std::size_t l = turn(n, round, sides.size());
        seconds[l] = asked(row, sides[l], answers[l]);
        rates[l].push_back(1e-6 * static_cast<double>(row.places->uv.size()) / seconds[l]);
      }
      of_round.push_back(seconds[1] / seconds[0]);
    }
    double difference = 0.0;
    for (std::size_t k = 0; sides.size() > 1 && k < answers[0].size(); ++k)
      difference = std::max(difference, std::abs(answers[0][k] - answers[1][k]));
    print(row.name, "M/s", median(rates[0]),
          sides.size() > 1 ? other(median(rates[1])) : std::nullopt, median(of_round), difference);
  }
}

template <typename Number>
Number number_of(const char* option, const std::string& text, Number least, Number most) {
  Number value{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size() ||
      !(value >= least && value <= most))
    throw Failure(fmt::format("{} {}: wanted {} to {}", option, text, least, most));
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path folder;
  int code = 0;
  try {
    std::string other;
    double km = 3.0;
    int rounds = 9;
    for (int k = 1; k < argc; k += 2) {
      const std::string option = argv[k];
      if (k + 1 == argc) throw Failure(option + ": a value is missing");
      if (option == "--library") {
        other = argv[k + 1];
      } else if (option == "--km") {
        km = number_of("--km", argv[k + 1], 0.5, 30.0);
      } else if (option == "--rounds") {
        rounds = number_of("--rounds", argv[k + 1], 1, 1000);
      } else {
        throw Failure(option + ": wanted --library FILE, --km LENGTH, --rounds NUMBER");
      }
    }
    std::vector<Library> libraries{Library(KERBSTONE_OPENCRG)};
    if (!other.empty()) libraries.emplace_back(other);
    std::string made = (std::filesystem::temp_directory_path() / "crg_api_XXXXXX").string();
    if (::mkdtemp(made.data()) == nullptr) throw Failure(made + ": cannot be made");
    folder = made;
    crg::write(road_of(km), folder / "road.crg", crg::Format::KRBI);
    measure(libraries, folder / "road.crg", rounds);
  } catch (const std::exception& error) {
    fmt::print(stderr, "crg_api_bench: {}\n", error.what());
    code = 1;
  }
  if (!folder.empty()) std::filesystem::remove_all(folder);
  return code;
}
