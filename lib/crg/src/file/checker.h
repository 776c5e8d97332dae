// The parts of check(). Private to it.
#pragma once

#include <optional>
#include <string>

#include "crg/check.h"
#include "crg/options.h"
#include "crg/reference_line.h"

namespace crg {

class Checker {
 public:
  Checker(const Crg& crg, CheckReport& report) : crg_(crg), report_(report) {}
  void run();

 private:
  void add(Severity severity, const char* rule, const std::string& message,
           std::optional<std::size_t> row = {}, std::size_t count = 1) {
    report_.findings.push_back({severity, rule, message, row, count});
  }
  // A header value that restates what the data say.
  void compare(const char* key, double actual, double tolerance, const char* what);

  void check_options();
  void check_modifiers();
  void check_increments();
  void check_header_against_channels();
  void check_projection();
  void check_wgs();

  // check_geometry.cpp
  void check_line();
  void check_curvature();
  void check_closure();
  void check_heights();

  const Crg& crg_;
  CheckReport& report_;
  Options options_;
  ReferenceLine line_;
};

}  // namespace crg
