// What the redundancy between the columns says of a guessed mapping: signs, zeros and delays.
#pragma once

#include <string>
#include <vector>

#include "explain/mapping.h"
#include "recording/table.h"

namespace explain {

/// The column of a channel; nullptr: none.
ColumnMapping* find_channel(Mapping& mapping, const std::string& channel);

/// The values of a channel as they are mapped; empty: no such channel.
std::vector<double> mapped_values(Mapping& mapping, const recording::Table& table,
                                  const std::string& channel);

/// Turns signs and zeros as the path wants them, leaves out what it contradicts, and notes both.
/// The path goes through x_m, y_m at the log's own clock t_s.
void confirm_mapping(const recording::Table& table, const std::vector<double>& t_s,
                     const std::vector<double>& x_m, const std::vector<double>& y_m,
                     bool by_satellites, Mapping& mapping);

/// Of a log without a place: whether the speed's unit, which no name says, is that of the
/// acceleration; else a speed that may be km/h or m/s is left out, and `missing` says so. Notes a
/// yaw rate and a lateral acceleration whose signs contradict each other.
void confirm_without_place(const recording::Table& table, const std::vector<double>& t_s,
                           Mapping& mapping);

/// Turns the signs of suspension travels so that braking bumps the front and driving the rear, by
/// vx_mps at the clock t_s, and notes what it did and what a log cannot tell of travels.
void confirm_travels(const recording::Table& table, const std::vector<double>& t_s,
                     Mapping& mapping);

/// Speeds of wheels whose unit is not known, against the confirmed vx_mps: km/h, mph, rad/s where
/// they turn as wheels of 0.12 to 0.42 m do; what is none of these is left out.
void confirm_wheels(const recording::Table& table, Mapping& mapping);

}  // namespace explain
