// Sequences of calls to the C API: each byte chooses a call, those behind it the arguments, wrong
// ids and NULL among them. Aborts when an answer that is said to be valid is not finite where it
// must be, or when a return value is neither 0 nor 1.
#include <cmath>
#include <cstdint>
#include <cstring>

#include "crgBaseLib.h"
#include "fuzz/target.h"

namespace {

int ignore(int level, char* message) { return level + static_cast<int>(std::strlen(message) > 0); }

// Roads to load: of the corpus of the reader, by number.
constexpr const char* kRoads[] = {"modifiers_refpoint.crg", "open_krbi.crg", "options.crg",
                                  "absent.crg"};

bool changed = true;  // data set 1 is no longer what was loaded

class Calls {
 public:
  explicit Calls(std::string_view bytes) : rest_(bytes) {}
  bool more() const { return !rest_.empty(); }
  void one();

 private:
  unsigned byte() {
    if (rest_.empty()) return 0;
    const auto value = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return value;
  }
  // Mostly on or near the roads, now and then far away or no number at all.
  double number() {
    const unsigned kind = byte();
    if (kind == 255) return NAN;
    if (kind == 254) return INFINITY;
    if (kind == 253) return -1e300;
    const double value = static_cast<double>(byte()) + static_cast<double>(byte()) / 256.0;
    return (kind % 2 == 0 ? value : -value) * (kind < 128 ? 0.1 : kind < 250 ? 1.0 : 1e6);
  }
  int id(unsigned most) {
    const unsigned value = byte();
    return value == 255 ? -1 : value == 254 ? 1 << 20 : static_cast<int>(value % most);
  }
  double* out(int k) { return byte() == 255 ? nullptr : &out_[k]; }
  void evaluate(unsigned which);
  void options(unsigned which);
  void modifiers(unsigned which);
  void data(unsigned which);

  std::string_view rest_;
  double out_[2] = {};
  int whole_ = 0;
  int loads_ = 0;
};

void zero_or_one(int value) { fuzz::require(value == 0 || value == 1, "0 or 1 is answered"); }

void Calls::evaluate(unsigned which) {
  using Pair = int (*)(int, double, double, double*, double*);
  using Height = int (*)(int, double, double, double*);
  constexpr Pair kPairs[] = {crgEvalxy2uv, crgEvaluv2xy, crgEvaluv2pk, crgEvalxy2pk};
  constexpr Height kHeights[] = {crgEvaluv2z, crgEvalxy2z};
  const int cp = id(8);
  const double a = number(), b = number();
  double* first = out(0);
  double* second = out(1);
  if (which < 4) {
    const int done = kPairs[which](cp, a, b, first, second);
    zero_or_one(done);
    if (done == 1)
      fuzz::require(std::isfinite(*first) && !std::isnan(*second), "a valid answer is a number");
  } else {
    const int done = kHeights[which % 2](cp, a, b, first);
    zero_or_one(done);
    if (done == 1) fuzz::require(!std::isinf(*first), "a height is finite or a hole");
  }
}

void Calls::options(unsigned which) {
  const int cp = id(8);
  const unsigned option = byte() % 52;
  switch (which) {
    case 0:
      return zero_or_one(crgContactPointOptionSetInt(cp, option, static_cast<int>(byte() % 8) - 1));
    case 1:
      return zero_or_one(crgContactPointOptionSetDouble(cp, option, number()));
    case 2:
      return zero_or_one(crgContactPointOptionGetInt(cp, option, &whole_));
    case 3:
      return zero_or_one(crgContactPointOptionGetDouble(cp, option, out(0)));
    case 4:
      return zero_or_one(crgContactPointOptionRemove(cp, option));
    case 5:
      return zero_or_one(crgContactPointOptionRemoveAll(cp));
    case 6:
      return crgContactPointSetDefaultOptions(cp);
    case 7:
      return crgContactPointOptionsPrint(cp);
    default:
      return zero_or_one(crgContactPointSetHistory(cp, static_cast<int>(option) - 9));
  }
}

void Calls::modifiers(unsigned which) {
  const int set = id(4);
  changed = changed || set == 1;
  const unsigned modifier = 20 + byte() % 26;
  switch (which) {
    case 0:
      return zero_or_one(crgDataSetModifierSetInt(set, modifier, static_cast<int>(byte() % 5) - 1));
    case 1:
      return zero_or_one(crgDataSetModifierSetDouble(set, modifier, number()));
    case 2:
      return zero_or_one(crgDataSetModifierGetInt(set, modifier, &whole_));
    case 3:
      return zero_or_one(crgDataSetModifierGetDouble(set, modifier, out(0)));
    case 4:
      return zero_or_one(crgDataSetModifierRemove(set, modifier));
    case 5:
      return zero_or_one(crgDataSetModifierRemoveAll(set));
    case 6:
      return crgDataSetModifiersApply(set);
    case 7:
      return crgDataSetModifierSetDefault(set);
    case 8:
      return crgDataSetModifiersPrint(set);
    default:
      return crgDataSetOptionSetDefault(set);
  }
}

void Calls::data(unsigned which) {
  const int set = id(4);
  switch (which) {
    case 0:
    case 1: {
      static const std::string corpus = KERBSTONE_SOURCE "/tests/corpus/crg/";
      if (++loads_ <= 2 && crgDataSetGetURange(3, &out_[0], &out_[1]) == 0)  // few: it takes long
        crgLoaderReadFile((corpus + kRoads[static_cast<unsigned>(set) % 4]).c_str());
      return;
    }
    case 2:
      changed = changed || set == 1;
      return zero_or_one(crgDataSetRelease(set));
    case 3:
    case 4: {
      const int cp = crgContactPointCreate(set);
      fuzz::require(cp >= -1, "a contact point or none");
      if (cp > 40) crgContactPointDelete(cp);
      return;
    }
    case 5:
      return zero_or_one(crgContactPointDelete(id(8)));
    case 6:
      return crgContactPointDeleteAll(set);
    case 7:
      return zero_or_one(crgCheck(set));
    case 8:
      return crgDataPrintHeader(set);
    case 9:
      return crgDataPrintChannelInfo(set);
    case 10:
      return crgDataPrintRoadInfo(set);
    case 11:
      return zero_or_one(crgDataSetGetURange(set, out(0), out(1)));
    case 12:
      return zero_or_one(crgDataSetGetVRange(set, out(0), out(1)));
    case 13:
      return zero_or_one(crgDataSetGetIncrements(set, out(0), out(1)));
    case 14:
      return zero_or_one(crgDataSetGetUtilityDataClosedTrack(set, &whole_, out(0), out(1)));
    case 15:
      return crgMsgSetLevel(static_cast<int>(byte() % 8) - 1);
    case 16:
      return crgMsgSetMaxWarnMsgs(static_cast<int>(byte()) - 2);
    case 17:
      return crgMsgSetMaxLogMsgs(static_cast<int>(byte()) - 2);
    case 18:
      return zero_or_one(crgMsgIsPrintable(static_cast<int>(byte() % 8) - 1));
    case 19:
      return crgContactPointSetHistoryForAllPoints(static_cast<int>(byte()));
    case 20:
      return crgMsgPrint(static_cast<int>(byte() % 8), "%s %d\n", crgGetReleaseInfo(), set);
    case 21:
      return crgFree(crgRealloc(crgCalloc(byte(), byte()), 1 + byte()));
    default:
      changed = true;
      return crgMemRelease();
  }
}

void Calls::one() {
  const unsigned choice = byte();
  if (choice < 128) return evaluate(choice % 6);
  if (choice < 176) return options(choice % 9);
  if (choice < 208) return modifiers(choice % 10);
  data((choice - 208) % 24);
}

}  // namespace

void fuzz::run(std::string_view bytes) {
  crgMsgSetCallback(ignore);
  crgMsgSetLevel(dCrgMsgLevelWarn);
  static const std::string road = KERBSTONE_SOURCE "/tests/corpus/crg/closed_krbi.crg";
  if (changed) {
    crgMemRelease();
    require(crgLoaderReadFile(road.c_str()) == 1, "the first road has id 1");
    changed = false;
  }
  for (int k = 0; k < 4; ++k) require(crgContactPointCreate(1) == k, "contact points count up");
  Calls calls(bytes);
  for (int steps = 0; calls.more() && steps < 400; ++steps) calls.one();
  crgContactPointDeleteAll(-1);
  for (const int id : {2, 3}) crgDataSetRelease(id);
}
