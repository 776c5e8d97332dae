// A saved state of a unit, as an importer may hand it back: the input is a list of changes to a
// true one, ten bytes each (two say where, eight are put there), or, after a first byte 0xff, the
// state itself. What is taken must give the same bytes again, and drive without a crash.
#include <cstring>
#include <memory>

#include "base/archive.h"
#include "base/error.h"
#include "crg/error.h"
#include "fmu/instance.h"
#include "fuzz/target.h"

namespace {

constexpr const char* kToken = "{fuzz}";

fmu::Instance& car() {
  static const std::unique_ptr<fmu::Instance> made = [] {
    fuzz::folder().put("unit.txt",
                       std::string("token = ") + kToken +
                           "\nvehicle = " + KERBSTONE_SOURCE "/vehicles/open_wheel/vehicle.yaml\n" +
                           "road = " KERBSTONE_SOURCE "/tests/corpus/crg/closed_lrfi.crg\n");
    return std::make_unique<fmu::Instance>(fuzz::folder() / "", kToken);
  }();
  return *made;
}

const std::string& true_state() {
  static const std::string bytes = [] {
    fmu::Instance& own = car();
    own.enter_initialisation(0.0);
    own.leave_initialisation();
    for (int i = 0; i < 3; ++i) own.step(own.time_s(), 0.001);
    return fmu::to_bytes(own.save(), kToken);
  }();
  return bytes;
}

}  // namespace

void fuzz::run(std::string_view bytes) {
  std::string state = true_state();
  if (!bytes.empty() && bytes.front() == '\xff') {
    state = bytes.substr(1);
  } else {
    for (; bytes.size() >= 10; bytes.remove_prefix(10)) {
      const std::size_t at =
          static_cast<unsigned char>(bytes[0]) + 256u * static_cast<unsigned char>(bytes[1]);
      if (at + 8 <= state.size()) std::memcpy(state.data() + at, bytes.data() + 2, 8);
    }
    // The checksum that no change would have right.
    state.resize(state.size() - 8);
    const std::uint64_t sum = base::checksum(state);
    state.append(reinterpret_cast<const char*>(&sum), 8);
  }
  fmu::Instance& own = car();
  try {
    const fmu::SavedState taken = fmu::from_bytes(state, kToken, own.list());
    require(fmu::to_bytes(taken, kToken) == state, "a state that is taken comes back as it was");
    own.restore(taken);
    if (own.phase() == fmu::Phase::kStepping) own.step(own.time_s(), 0.001);
  } catch (const base::Error& error) {
    require_refusal(error, "");
  } catch (const crg::Error&) {  // another path for the road
  }
}
