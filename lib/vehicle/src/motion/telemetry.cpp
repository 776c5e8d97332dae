#include "vehicle/telemetry.h"

namespace vehicle {

void fill_telemetry(double time_s, const State<double>& s, const Detail<double>& d,
                    const Controls<double>& c, double u_m, double v_m, std::span<double> values) {
  std::size_t column = 0;
  const auto put = [&](double value) { values[column++] = value; };
  const auto put4 = [&](std::size_t group) {
    for (std::size_t i = 0; i < kWheels; ++i) put(s[group + i]);
  };
  put(time_s);
  put(u_m);
  put(v_m);
  for (const std::size_t i :
       {kX, kY, kZ, kRoll, kPitch, kYaw, kVx, kVy, kRollRate, kPitchRate, kYawRate})
    put(s[i]);
  put(d.specific_force_mps2.x);
  put(d.specific_force_mps2.y);
  put(d.specific_force_mps2.z);
  put(c.steer_command_rad);
  put(d.inputs.steer_rad);
  put(c.throttle_command);
  put(d.inputs.throttle);
  for (const double pressure : c.brake_command_pa) put(pressure);
  for (const double pressure : d.inputs.brake_pa) put(pressure);
  put(d.inputs.gear);
  put(s[kEngine]);
  put(d.boost);
  put(s[kFuel]);
  put4(kSpin);
  for (const auto& wheel : d.wheel) put(wheel.fz_n);
  put4(kTravel);
  put4(kDiscSurface);
  put4(kTyre);
}

}  // namespace vehicle
