#include "support/places.h"

namespace places {

std::string source() { return KERBSTONE_SOURCE; }
std::string data() { return KERBSTONE_DATA; }
std::string torcs_tracks() { return TORCS_TRACKS; }
std::string crgbuild() { return CRGBUILD; }
std::string crgdrive() { return CRGDRIVE; }
std::string crgexplain() { return CRGEXPLAIN; }
std::string crgidentify() { return CRGIDENTIFY; }
std::string crgsim() { return CRGSIM; }
std::string lidar2mesh() { return LIDAR2MESH; }
std::string kerbstone() { return KERBSTONE; }
std::string make_trials() { return MAKE_TRIALS; }
std::string blind_trials() { return BLIND_TRIALS; }
std::string kerbstone_car() { return KERBSTONE_CAR; }

}  // namespace places
