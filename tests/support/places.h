// Where the checkout, the tools built from it and the real data beside it lie. Only places.cpp
// knows the paths, so that a checkout in another folder compiles all other tests to the same
// objects.
#pragma once

#include <string>

namespace places {

std::string source();        ///< the checkout
std::string data();          ///< real files beside it; tests that need them skip themselves without
std::string torcs_tracks();  ///< meshes of the Debian package torcs-data
std::string crgbuild(), crgdrive(), crgexplain(), crgidentify(), crgsim(), lidar2mesh(),
    kerbstone();  ///< the programs
std::string make_trials(), blind_trials();
std::string kerbstone_car();  ///< the shared object of lib/fmu

}  // namespace places
