// What the Magic Formula of the stated tyre has and the stated car may leave out.
#include <fmt/format.h>

#include <algorithm>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"

namespace explain::tyre_terms {
namespace {

using vehicle::Term;

template <Term kTerm>
void list_term(const Listing& l, const char* id, const Amount& amount, const char* text,
               const Effect& effect) {
  if (!l.lateral) return untestable(l, id, kNoSlip);
  if (l.car.terms[kTerm] != 0.0)
    return untestable(
        l, id, "the stated car has it; what may be wrong about its curve is absorbed as uncertain");
  candidate(l, id, amount,
            {text, "as in the Magic Formula of the stated tyre",
             "constant-radius cornering at several speeds"},
            [&effect](Setting& s, double v) { s.act(effect, v); });
}

/// Amounts up to one are the term's; what is beyond goes to `beyond`.
template <Term kTerm>
double write_term(CarChanges& out, const Finding& f) {
  const double amount = out.car.terms[kTerm] + f.parameters[0].value;
  out.set(kTerm, std::clamp(amount, 0.0, 1.0));
  return amount;
}

void say_too_much(CarChanges& out, const Finding& f, double amount) {
  if (amount > 1)
    out.remarks.push_back(
        fmt::format("{}: found {:.4g} of what the tyre files say; a term holds 1 at most",
                    f.mechanism, amount));
}

Mechanism load_sensitivity() {
  return {.id = "vehicle.tyre_load_sensitivity",
          .list =
              [](const Listing& l) {
                list_term<Term::tyre_load_sensitivity>(
                    l, "vehicle.tyre_load_sensitivity",
                    {"tyre_load_sensitivity", "1", 0.3, 0.3, true}, "grip per load falls with load",
                    kMoreOf<Term::tyre_load_sensitivity>);
              },
          .most = 6.0,
          .write_car =
              [](CarChanges& out, const Finding& f) {
                say_too_much(out, f, write_term<Term::tyre_load_sensitivity>(out, f));
              }};
}

Mechanism camber() {
  return {.id = "vehicle.tyre_camber",
          .list =
              [](const Listing& l) {
                list_term<Term::tyre_camber>(
                    l, "vehicle.tyre_camber", {"tyre_camber", "1", 0.3, 0.3, true},
                    "inclined tyres push sideways", kMoreOf<Term::tyre_camber>);
              },
          .most = 10.0,
          .write_car =
              [](CarChanges& out, const Finding& f) {
                const double amount = write_term<Term::tyre_camber>(out, f);
                for (std::size_t k = 0; k < 2 && amount > 1; ++k)
                  out.tyre[k]["LGAY"] = amount * out.car.files.tyre[k].lgay;
              }};
}

Mechanism combined_slip() {
  return {.id = "vehicle.tyre_combined_slip",
          .list =
              [](const Listing& l) {
                list_term<Term::tyre_combined_slip>(l, "vehicle.tyre_combined_slip",
                                                    {"tyre_combined_slip", "1", 0.3, 0.3, true},
                                                    "braking and driving take side force away",
                                                    kMoreOfPositive<Term::tyre_combined_slip>);
              },
          .most = 3.0,
          .write_car =
              [](CarChanges& out, const Finding& f) {
                say_too_much(out, f, write_term<Term::tyre_combined_slip>(out, f));
              }};
}

Mechanism relaxation() {
  return {.id = "vehicle.tyre_relaxation",
          .list =
              [](const Listing& l) {
                list_term<Term::tyre_relaxation>(
                    l, "vehicle.tyre_relaxation", {"tyre_relaxation", "1", 0.3, 0.4, true},
                    "side force builds up over a distance", kMoreOfPositive<Term::tyre_relaxation>);
              },
          .most = 15.0,
          .write_car =
              [](CarChanges& out, const Finding& f) {
                const double amount = write_term<Term::tyre_relaxation>(out, f);
                for (std::size_t k = 0; k < 2 && amount > 1; ++k) {
                  const vehicle::TyreCoefficients& t = out.car.files.tyre[k];
                  if (t.lateral_stiffness_npm > 0)
                    out.tyre[k]["LATERAL_STIFFNESS"] = t.lateral_stiffness_npm / amount;
                  else
                    out.tyre[k]["PTY1"] = amount * t.pty1;
                }
              }};
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {load_sensitivity(), camber(), combined_slip(), relaxation()};
}

}  // namespace explain::tyre_terms
