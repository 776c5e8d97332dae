// A log of any maker; the columns mean what their names say.
#include <cmath>

#include "base/error.h"
#include "fuzz/target.h"
#include "recording/recording.h"

void fuzz::run(std::string_view bytes) {
  const std::string path = folder().put("log.csv", bytes);
  recording::Mapping turned;  // every step of reading a recording
  turned.imu_yaw_rad = 0.3, turned.imu_ahead_m = 0.5;
  for (const char* channel : {"time_s", "vx_mps", "ax_mps2", "ay_mps2", "yaw_rate_radps"})
    turned.columns.push_back({channel, channel, 2.0, 0.5, 0.1, 0.05, true});
  turned.columns.front().delay_s = turned.columns.front().low_pass_s = 0.0;
  for (const recording::Mapping& mapping : {recording::Mapping{}, turned}) {
    try {
      const recording::Recording recording = recording::read_recording(path, mapping);
      const std::vector<double>& time = *recording.table.find("time_s");
      require(time.size() >= 10, "ten rows");
      for (std::size_t k = 1; k < time.size(); ++k)
        require(time[k] > time[k - 1], "a clock that ascends");
      for (const std::vector<double>& column : recording.table.columns)
        require(column.size() == time.size(), "columns of one length");
    } catch (const base::Error& error) {
      require_refusal(error, path);
    }
  }
}
