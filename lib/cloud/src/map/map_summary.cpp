#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "cloud/map.h"

namespace cloud {

std::string map_summary_json(const MapReport& r) {
  nlohmann::ordered_json drift = nlohmann::ordered_json::array();
  for (const DriftStation& s : r.drift)
    drift.push_back({{"pass", s.pass},
                     {"u_m", s.u_m},
                     {"x_m", s.correction[0]},
                     {"y_m", s.correction[1]},
                     {"z_m", s.correction[2]},
                     {"roll_rad", s.correction[3]},
                     {"pitch_rad", s.correction[4]},
                     {"yaw_rad", s.correction[5]},
                     {"stddev", s.stddev},
                     {"base_believed", s.base_believed}});
  const nlohmann::ordered_json out = {{"points",
                                       {{"read", r.points},
                                        {"used", r.used},
                                        {"looked_at_for_drift", r.looked_at},
                                        {"without_pose", r.without_pose},
                                        {"beside_the_road", r.off_road},
                                        {"far_from_base", r.far_from_base},
                                        {"on_obstacles", r.on_obstacles},
                                        {"on_grass", r.on_grass}}},
                                      {"registration",
                                       {{"converged", r.converged},
                                        {"iterations", r.iterations},
                                        {"last_move_m", r.last_move_m},
                                        {"sections", r.sections},
                                        {"passes", r.passes},
                                        {"inlier_share", r.inlier_share},
                                        {"base_stddev_m", r.base_stddev_m},
                                        {"base_tilt", r.base_tilt},
                                        {"base_tilt_stddev", r.base_tilt_stddev},
                                        {"base_crown", r.base_crown},
                                        {"base_together", r.base_together},
                                        {"view_stddev_factor", r.view_stddev_factor},
                                        {"view_together", r.view_together},
                                        {"rms_before_m", r.rms_before_m},
                                        {"rms_after_m", r.rms_after_m},
                                        {"pass_rms_before_m", r.pass_rms_before_m},
                                        {"pass_rms_after_m", r.pass_rms_after_m},
                                        {"left_out_nodes", r.left_out_nodes},
                                        {"left_out_within_90", r.left_out_within_90},
                                        {"noise_factor", r.noise_factor},
                                        {"typical_stddev",
                                         {{"x_m", r.typical_stddev[0]},
                                          {"y_m", r.typical_stddev[1]},
                                          {"z_m", r.typical_stddev[2]},
                                          {"roll_rad", r.typical_stddev[3]},
                                          {"pitch_rad", r.typical_stddev[4]},
                                          {"yaw_rad", r.typical_stddev[5]}}},
                                        {"unfixed", r.unfixed}}},
                                      {"grid",
                                       {{"nodes", r.nodes},
                                        {"from_points", r.nodes_lidar},
                                        {"interpolated", r.nodes_interpolated},
                                        {"from_base", r.nodes_base},
                                        {"blended", r.nodes_blended},
                                        {"holes", r.nodes_hole},
                                        {"coverage", r.coverage},
                                        {"changed_p50_m", r.changed_p50_m},
                                        {"changed_p99_m", r.changed_p99_m},
                                        {"changed_max_m", r.changed_max_m}}},
                                      {"remarks", r.remarks},
                                      {"faults", r.faults},
                                      {"drift", drift}};
  return base::json_text(out);
}

std::string map_timing_json(const MapReport& r) {
  const nlohmann::ordered_json out = {{"schema", 1},
                                      {"seconds",
                                       {{"read", r.seconds_read},
                                        {"first_reading", r.seconds_estimate},
                                        {"drift", r.seconds_drift},
                                        {"grid", r.seconds_grid},
                                        {"fusion", r.seconds_fuse}}}};
  return base::json_text(out);
}

}  // namespace cloud
