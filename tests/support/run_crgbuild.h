// Runs the real crgbuild and makes small tracks for it.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace cli {

struct Ran {
  int code = -1;  ///< exit code; 128 + signal when killed
  std::string out, err;
};

/// Runs crgbuild with these arguments, standard input closed. With kill_after_s > 0 it gets
/// `signal` then.
Ran crgbuild(const std::vector<std::string>& arguments, double kill_after_s = 0.0, int signal = 9);

/// A folder that vanishes with the object.
class Folder {
 public:
  explicit Folder(const std::string& name = "crgbuild");  ///< what its name begins with
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string read(const std::string& path);
void write(const std::string& path, const std::string& bytes);
bool exists(const std::string& path);

/// A stadium: two straights of 120 m, two half circles of 40 m radius; 10 m of road with 3 m of
/// run-off on both sides. The road is banked by 2 % and waves by 0.5 m. u = 0 at (0, 0), driven
/// towards +x.
struct Stadium {
  bool closed = true;
  bool trees = true, road = true;
  bool names = true;
  bool y_up = false;
  double scale = 1.0;           ///< 1000: millimetres
  double x_m = 0.0, y_m = 0.0;  ///< offset
  double x2_m = 0.0;            ///< a second stadium at this offset, none if 0
  std::string first_vertex;     ///< replaces the first vertex line's numbers

  static double length_m();
  /// The height at the middle of the road after u metres.
  static double z_m(double u_m);
  /// As an .obj file.
  std::string obj() const;
};

}  // namespace cli
