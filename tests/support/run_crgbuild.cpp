#include "support/run_crgbuild.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "support/places.h"

namespace cli {

Ran crgbuild(const std::vector<std::string>& arguments, double kill_after_s, int signal) {
  const Folder folder;
  const std::string out = folder / "out", err = folder / "err";
  std::string program = places::crgbuild();
  std::vector<char*> argv{program.data()};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open("/dev/null", O_RDONLY), 0);
    ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT, 0600), 1);
    ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT, 0600), 2);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  if (kill_after_s > 0.0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(kill_after_s));
    ::kill(child, signal);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read(out), read(err)};
}

Folder::Folder(const std::string& name) {
  std::string pattern = (std::filesystem::temp_directory_path() / (name + "_XXXXXX")).string();
  if (!::mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
  path_ = pattern;
}

Folder::~Folder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

bool exists(const std::string& path) { return std::filesystem::exists(path); }

namespace {

constexpr double kStraight = 120.0, kRadius = 40.0, kBanking = 0.02;

struct Place {
  double x, y, heading;
};

Place place(double u) {
  const double arc = std::numbers::pi * kRadius;
  u = std::fmod(u, 2 * (kStraight + arc));
  if (u < kStraight) return {u, 0, 0};
  u -= kStraight;
  if (u < arc) {
    const double a = u / kRadius;
    return {kStraight + kRadius * std::sin(a), kRadius - kRadius * std::cos(a), a};
  }
  u -= arc;
  if (u < kStraight) return {kStraight - u, 2 * kRadius, std::numbers::pi};
  const double a = (u - kStraight) / kRadius;
  return {-kRadius * std::sin(a), kRadius + kRadius * std::cos(a), std::numbers::pi + a};
}

class ObjText {
 public:
  explicit ObjText(const Stadium& stadium) : stadium_(stadium) {}

  std::size_t vertex(double x, double y, double z) {
    x = (x + stadium_.x_m) * stadium_.scale;
    y = (y + stadium_.y_m) * stadium_.scale;
    z *= stadium_.scale;
    if (count_ == 0 && !stadium_.first_vertex.empty())
      text_ += "v " + stadium_.first_vertex + "\n";
    else if (stadium_.y_up)
      text_ += fmt::format("v {:.6f} {:.6f} {:.6f}\n", x, z, -y);
    else
      text_ += fmt::format("v {:.6f} {:.6f} {:.6f}\n", x, y, z);
    return ++count_;
  }
  void object(const std::string& name) {
    if (stadium_.names) text_ += "o " + name + "\n";
  }
  void quad(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    text_ += fmt::format("f {0} {1} {2}\nf {0} {2} {3}\n", a, b, c, d);
  }
  const std::string& text() const { return text_; }

 private:
  const Stadium& stadium_;
  std::string text_;
  std::size_t count_ = 0;
};

void add_strip(ObjText& obj, const std::string& name, double v_right, double v_left, bool closed,
               double x_offset) {
  constexpr std::size_t kRings = 246;
  obj.object(name);
  std::vector<std::size_t> right, left;
  for (std::size_t i = 0; i < kRings; ++i) {
    const double u = Stadium::length_m() * static_cast<double>(i) / kRings;
    const Place p = place(u);
    for (const double v : {v_right, v_left})
      (v == v_right ? right : left)
          .push_back(obj.vertex(p.x - v * std::sin(p.heading) + x_offset,
                                p.y + v * std::cos(p.heading), Stadium::z_m(u) + kBanking * v));
  }
  for (std::size_t i = 0; i + (closed ? 0 : 60) < kRings; ++i) {
    const std::size_t j = (i + 1) % kRings;
    obj.quad(right[i], right[j], left[j], left[i]);
  }
}

void add_tree(ObjText& obj, double x, double y) {
  for (const double a : {0.0, 1.57}) {
    const double dx = 2.0 * std::cos(a), dy = 2.0 * std::sin(a);
    obj.quad(obj.vertex(x - dx, y - dy, 0), obj.vertex(x + dx, y + dy, 0),
             obj.vertex(x + dx, y + dy, 8), obj.vertex(x - dx, y - dy, 8));
  }
}

void add_stadium(ObjText& obj, const Stadium& stadium, double x_offset) {
  const std::string number = x_offset == 0.0 ? "" : "_2";
  if (stadium.road) {
    add_strip(obj, "road_main" + number, -5, 5, stadium.closed, x_offset);
    add_strip(obj, "grass_left" + number, 5, 8, stadium.closed, x_offset);
    add_strip(obj, "grass_right" + number, -8, -5, stadium.closed, x_offset);
  }
  if (!stadium.trees) return;
  obj.object("tree_row" + number);
  for (int i = 0; i < 12; ++i) add_tree(obj, 10.0 * i + x_offset, 14.0 + i % 3);
}

}  // namespace

double Stadium::length_m() { return 2 * (kStraight + std::numbers::pi * kRadius); }

double Stadium::z_m(double u_m) { return 0.5 * std::sin(2 * std::numbers::pi * u_m / length_m()); }

std::string Stadium::obj() const {
  ObjText text(*this);
  add_stadium(text, *this, 0.0);
  if (x2_m != 0.0) add_stadium(text, *this, x2_m);
  return text.text();
}

}  // namespace cli
