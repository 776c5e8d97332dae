// Roads and logs as the page draws them: a JSON head and rows of numbers. Private to lib/view.
#pragma once

#include <string>
#include <vector>

#include "crg/surface.h"
#include "recording/log.h"

namespace view {

/// What `unpack` of web/src/server.js reads: the length of the head (uint32), the head (JSON with
/// "arrays": name, type, count), blanks up to a multiple of eight bytes, the arrays, each beginning
/// at such a multiple. Little endian.

/// A road file as a sheet of at most 3,000 rows and 41 columns, its reference line and the edges of
/// what has a height.
std::string packed_road(const crg::Surface& surface);

/// Where on a road a place of its map lies: {"u_m", "v_m"}, null where it is more than 50 m beside
/// its line.
std::string place_json(const crg::Surface& surface, double x_m, double y_m);

/// The heights of a road from u_begin_m to u_end_m (where the first is larger: over the start), and
/// those of another one at the same places of the map: u_m per row, v_m per column, z_m and
/// against_m; at most 1,000 rows and 201 columns, NaN where there is none. Throws Error where no
/// row lies in between.
std::string packed_difference(const crg::Surface& surface, const crg::Surface& other,
                              double u_begin_m, double u_end_m);

/// Heights of a road along a straight line on the map, at 2 to 20,000 places 2 cm apart or more:
/// s_m along the line, u_m, v_m, z_m; NaN where there is no road. Throws Error where both ends are
/// one place.
std::string packed_profile(const crg::Surface& road, const crg::Point2& from,
                           const crg::Point2& to);

/// Names, units, rates and ranges of the channels: JSON.
std::string channels_json(const recording::Log& log);

/// The values of these channels, in rows. Throws Error on a name that the log has not.
std::string packed_channels(const recording::Log& log, const std::vector<std::string>& names);

/// Where on a road these places lie: u_m and v_m per row; NaN where they are more than 50 m beside
/// its line, and where a road that crosses itself lets them lie on another leg than the places
/// before and after. Throws Error on a name that the log has not.
std::string packed_places(const recording::Log& log, const std::string& x, const std::string& y,
                          const crg::Surface& road);

}  // namespace view
