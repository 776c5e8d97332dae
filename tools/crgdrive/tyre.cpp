#include <fmt/format.h>

#include <cstdio>

#include "commands.h"
#include "files/write_file.h"
#include "vehicle/table.h"
#include "vehicle/tyre_points.h"

namespace crgdrive {

int tyre(const TyreCommand& command) {
  const vehicle::TyreFile file = vehicle::read_tyre(command.tyre_path);
  vehicle::TyreOptions options;
  options.alpha = command.alpha == "angle" ? vehicle::AlphaConvention::kAngle
                                           : vehicle::AlphaConvention::kTangent;
  options.mirrored = command.mirrored;
  const vehicle::Table points = vehicle::read_table(command.points_path);
  const vehicle::Table forces =
      vehicle::evaluate_tyre(file.coefficients, points, command.points_path, options);
  files::write_file(command.out_path, vehicle::format_table(forces, 10));
  fmt::print("{}: Magic Formula {:.1f}, {} coefficients at their default; {} points -> {}\n",
             command.tyre_path, file.coefficients.version / 10.0, file.defaulted.size(),
             forces.rows(), command.out_path);
  return 0;
}

}  // namespace crgdrive
