// Tyre files as other programs write them: units, models, tables, wrapped remarks, axes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include "tyre_files.h"
#include "vehicle/car.h"
#include "vehicle/error.h"
#include "vehicle/magic_formula.h"

namespace tyre_kinds_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using vehicle::TyreCoefficients;

std::string refusal(const std::string& text) {
  try {
    vehicle::parse_tyre(text, "t.tir");
  } catch (const vehicle::Error& error) {
    return error.what();
  }
  return "";
}

TyreCoefficients read(const std::string& text) {
  return vehicle::parse_tyre(text, "t.tir").coefficients;
}

std::string with(std::string text, const std::string& old, const std::string& replacement) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), replacement);
}

TEST(TyreKinds, TheModelIsKnownByEitherKey) {
  const std::string text = test_tyre_text();
  for (const char* format : {"'PAC2002'", "'MF_05'", "pac2002", "\"Mf_05\""})
    EXPECT_EQ(
        read(with(text, "FITTYP = 61", std::string("PROPERTY_FILE_FORMAT = ") + format)).version,
        52)
        << format;
  EXPECT_EQ(read(with(text, "FITTYP = 61", "PROPERTY_FILE_FORMAT = 'USER'\nFITTYP = '61'")).version,
            61);
  EXPECT_THAT(refusal(with(text, "FITTYP = 61", "PROPERTY_FILE_FORMAT = 'USER'")),
              AllOf(HasSubstr("FITTYP"), HasSubstr("PAC2002")));
  for (const char* other : {"FIALA", "UA", "PAC89", "PAC94", "PAC_MC", "FTIRE", "5.2.1"})
    EXPECT_THAT(refusal(with(text, "FITTYP = 61",
                             std::string("FITTYP = 6\nPROPERTY_FILE_FORMAT = '") + other + "'")),
                AllOf(HasSubstr("t.tir:11:"), HasSubstr(other), HasSubstr("crgidentify tyre")));
}

TEST(TyreKinds, TakesTheUnitsThatTheFileNames) {
  // The same tyre in millimetres, pounds of force, pounds of mass and bar.
  std::string text = test_tyre_text();
  for (const auto& [old, other] : std::initializer_list<std::pair<const char*, const char*>>{
           {"LENGTH = 'meter'", "LENGTH = 'mm'"},
           {"FORCE = 'newton'", "FORCE = 'pound_force'"},
           {"MASS = 'kg'", "MASS = 'pound_mass'\nPRESSURE = 'bar'"},
           {"LONGVL = 20", "LONGVL = 20000"},
           {"VXLOW = 1", "VXLOW = 1000"},
           {"UNLOADED_RADIUS = 0.3", "UNLOADED_RADIUS = 300"},
           {"INFLPRES = 150000", "INFLPRES = 1.5"},
           {"NOMPRES = 150000", "NOMPRES = 1.5"},
           {"MASS = 10", "MASS = 22.0462262185"},
           {"IYY = 0.5", "IYY = 1102311.3109"},
           {"FNOMIN = 3000", "FNOMIN = 674.426829"},
           {"VERTICAL_STIFFNESS = 200000", "VERTICAL_STIFFNESS = 44.9617886"},
           {"VERTICAL_DAMPING = 200", "VERTICAL_DAMPING = 0.0449617886"},
           {"FZMAX = 9000", "FZMAX = 2023.280487"},
           {"LONGITUDINAL_STIFFNESS = 300000", "LONGITUDINAL_STIFFNESS = 67.4426829"},
           {"LATERAL_STIFFNESS = 150000", "LATERAL_STIFFNESS = 33.72134145"}})
    text = with(text, old, other);
  const TyreCoefficients si = read(test_tyre_text()), other = read(text);
#define VEHICLE_TYRE_COEFFICIENT(member, keyword, fallback) \
  EXPECT_NEAR(other.member, si.member, 1e-8 * std::abs(si.member)) << #keyword;
#include "vehicle/tyre_coefficients.def"
#undef VEHICLE_TYRE_COEFFICIENT
  // Values that are written back stand in the file's units.
  const auto written = vehicle::with_tyre_values(text, {{"UNLOADED_RADIUS", 0.31}, {"LMUY", 0.9}});
  EXPECT_THAT(written, HasSubstr("UNLOADED_RADIUS = 310\n"));
  EXPECT_NEAR(read(written).unloaded_radius_m, 0.31, 1e-12);
  for (const char* unit : {"LENGTH = furlong", "FORCE = 'stone'", "ANGLE = 'deg'"}) {
    EXPECT_THAT(refusal(text + "[UNITS]\n" + unit + "\n"),
                AllOf(HasSubstr("wanted one of"), HasSubstr("convert")));
  }
  // A number that no tyre has tells of units that nobody named.
  EXPECT_THAT(refusal(with(test_tyre_text(), "UNLOADED_RADIUS = 0.3", "UNLOADED_RADIUS = 300")),
              AllOf(HasSubstr("t.tir:15:"), HasSubstr("UNLOADED_RADIUS"), HasSubstr("[UNITS]")));
  EXPECT_THAT(refusal(with(with(test_tyre_text(), "INFLPRES = 150000", "INFLPRES = 1.5"),
                           "NOMPRES = 150000", "NOMPRES = 1.5")),
              AllOf(HasSubstr("INFLPRES"), HasSubstr("Pa"), HasSubstr("[UNITS]")));
}

TEST(TyreKinds, RemarksThatWereWrappedAreRemarks) {
  const std::string text = test_tyre_text();
  const auto tyre =
      read(with(text, "LONGVL = 20", "LONGVL = 20 $ speed of\nthe test bench\nin m/s"));
  EXPECT_EQ(tyre.nominal_speed_mps, 20.0);
  EXPECT_EQ(read(with(text, "LONGVL = 20", "! about\nall\nLONGVL = 20")).nominal_speed_mps, 20.0);
  // A coefficient whose equals sign is lost is none.
  EXPECT_THAT(refusal(with(text, "PDX2 = -0.1", "PDX3 = 2 $ a remark\nPDX2 -0.1")),
              AllOf(HasSubstr("PDX2 -0.1"), HasSubstr("begin it with $")));
  EXPECT_THAT(refusal(with(text, "LONGVL = 20", "LONGVL = 20\nthe test bench")),
              HasSubstr("begin it with $"));
}

TEST(TyreKinds, NumbersAndWordsInOtherHands) {
  const std::string text = test_tyre_text();
  EXPECT_EQ(read(with(text, "PCX1 = 1.6", "\tpcx1\t=\t.16D+01 ! Fortran")).pcx1, 1.6);
  EXPECT_EQ(read("\xef\xbb\xbf" + text).pcx1, 1.6);
  EXPECT_EQ(read(with(text, "PCX1 = 1.6", "PCX1 = '1.6'")).pcx1, 1.6);
  EXPECT_FALSE(read(with(text, "TYRESIDE = 'LEFT'", "TYRESIDE = Right")).left_side);
  const auto unknown = vehicle::parse_tyre(with(text, "'LEFT'", "'UNKNOWN'"), "t.tir");
  EXPECT_TRUE(unknown.coefficients.left_side);
  EXPECT_THAT(unknown.remarks, ElementsAre(AllOf(HasSubstr("t.tir:11:"), HasSubstr("RIGHT"))));
  EXPECT_THAT(refusal(with(text, "'LEFT'", "'BOTH'")), HasSubstr("TYRESIDE = 'BOTH'"));
  // Nothing uses the masses, so two of them do no harm.
  EXPECT_EQ(refusal(text + "[BELT]\nMASS = 7\n"), "");
  // Names that PAC2002 has for the same coefficients.
  const auto adams = read(text + "[X]\nIP = 150000\nIP_NOM = 150000\nQPZ1 = 0.3\nLKYG = 0.8\n");
  EXPECT_EQ(adams.ppz1, 0.3);
  EXPECT_EQ(adams.lkyc, 0.8);
  EXPECT_THAT(refusal(text + "IP = 140000\n"), HasSubstr("INFLPRES = 140000 contradicts"));
  EXPECT_EQ(read(vehicle::with_tyre_values(text + "LKYG = 0.8\n", {{"LKYC", 0.9}})).lkyc, 0.9);
}

TEST(TyreKinds, SideForceTowardsTheSlipIsRefused) {
  EXPECT_THAT(refusal(with(test_tyre_text(), "PKY1 = -45", "PKY1 = 45")),
              AllOf(HasSubstr("PKY1 = 45"), HasSubstr("ISO-W")));
  // The sign of the peak alone is none of the axes: sin and its argument turn together.
  const auto usual = read(test_tyre_text()),
             other = read(with(test_tyre_text(), "PDY1 = 1.7", "PDY1 = -1.7"));
  EXPECT_LT(other.pdy1 * usual.pdy1, 0.0);
}

TEST(TyreKinds, LoadsByTheCurveOfTheFile) {
  const std::string curve =
      "[DEFLECTION_LOAD_CURVE]\n{pen fz}\n0.0 0.0\n0.010 1000.0 $ one\n0.020 3000\n";
  const std::string text = with(test_tyre_text(), "PFZ1 = 0.7\n", "") + curve;
  const TyreCoefficients tyre = read(text);
  for (const auto& [deflection, load] : {std::pair{0.005, 500.0},
                                         {0.010, 1000.0},
                                         {0.015, 2000.0},
                                         {0.020, 3000.0},
                                         {0.025, 4000.0}}) {
    EXPECT_NEAR(vehicle::tyre_load(tyre, deflection, 0.0, 0.0), load, 1e-9);
    EXPECT_NEAR(vehicle::static_deflection(tyre, load, 0.0), deflection, 1e-12);
  }
  EXPECT_NEAR(vehicle::tyre_load(read(text + "LCZ = 1.5\n"), 0.010, 0.0, 0.0), 1500.0, 1e-9);
  const auto stiff = [&](const std::string& rest) {
    return read(with(text, "VERTICAL_STIFFNESS = 200000", "VERTICAL_STIFFNESS = 0") + rest)
        .vertical_stiffness_npm;
  };
  EXPECT_NEAR(stiff(""), 200000.0, 1e-6);
  EXPECT_EQ(refusal(text + curve), "");
  EXPECT_THAT(refusal(text + "[DEFLECTION_LOAD_CURVE]\n0 0\n0.01 1200\n"),
              AllOf(HasSubstr("contradicts that of line"), HasSubstr("remove")));
  EXPECT_THAT(refusal(test_tyre_text() + "[DEFLECTION_LOAD_CURVE]\n0 0\n0.02 10\n0.01 20\n"),
              HasSubstr("both growing"));
  EXPECT_THAT(refusal(test_tyre_text() + "[DEFLECTION_LOAD_CURVE]\n0.01 20\n0.02 40\n"),
              HasSubstr("from 0 0 on"));
  EXPECT_THAT(
      refusal(with(test_tyre_text(), "VERTICAL_STIFFNESS = 200000", "VERTICAL_STIFFNESS = 0")),
      AllOf(HasSubstr("t.tir:24:"), HasSubstr("[DEFLECTION_LOAD_CURVE]")));
  EXPECT_NEAR(read(with(test_tyre_text(), "VERTICAL_STIFFNESS = 200000", "Q_FZ1 = 18"))
                  .vertical_stiffness_npm,
              3000.0 / 0.3 * std::sqrt(18.0 * 18.0 + 80.0), 1e-6);
}

/// Magic Formula 5.2 after H. B. Pacejka, Tyre and Vehicle Dynamics (2nd edition, 2006), section
/// 4.3.2, written down apart from the program: values by keyword from the text itself, no factors
/// but the file's, no pressure. `alpha` in radians, `gamma` the sine of the inclination, which
/// itself stands in the friction along the wheel (4.E13) alone.
struct Published {
  std::map<std::string, double> c;
  double of(const std::string& key) const {
    const auto found = c.find(key);
    if (found != c.end()) return found->second;
    return key.front() == 'L' ? 1.0 : 0.0;
  }
  explicit Published(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string key, equals;
      double value = 0.0;
      if (words >> key >> equals >> value && equals == "=") c.emplace(key, value);
    }
  }
  static double magic(double d, double c, double b, double e, double x) {
    return d * std::sin(c * std::atan(b * x - e * (b * x - std::atan(b * x))));
  }
  double dfz(double fz) const { return fz / (of("FNOMIN") * of("LFZO")) - 1.0; }
  struct Pure {
    double value, shift_h, shift_v, peak, slope;
  };
  Pure fx(double fz, double kappa, double gamma) const {
    const double f = dfz(fz), sh = (of("PHX1") + of("PHX2") * f) * of("LHX"), x = kappa + sh;
    const double sv = fz * (of("PVX1") + of("PVX2") * f) * of("LVX") * of("LMUX");
    const double shape = of("PCX1") * of("LCX"), camber = std::asin(gamma) * of("LGAX");
    const double peak =
        fz * (of("PDX1") + of("PDX2") * f) * (1.0 - of("PDX3") * camber * camber) * of("LMUX");
    double e = (of("PEX1") + of("PEX2") * f + of("PEX3") * f * f) *
               (1.0 - of("PEX4") * (x > 0   ? 1
                                    : x < 0 ? -1
                                            : 0)) *
               of("LEX");
    e = std::min(e, 1.0);
    const double slope = fz * (of("PKX1") + of("PKX2") * f) * std::exp(of("PKX3") * f) * of("LKX");
    return {magic(peak, shape, slope / (shape * peak), e, x) + sv, sh, sv, peak, slope};
  }
  Pure fy(double fz, double alpha, double gamma) const {
    const double f = dfz(fz), fz0 = of("FNOMIN") * of("LFZO"), camber = gamma * of("LGAY");
    const double kyg = c.contains("LKYG") ? of("LKYG") : 1.0;
    const double sh = (of("PHY1") + of("PHY2") * f) * of("LHY") + of("PHY3") * camber * kyg;
    const double sv =
        fz * of("LMUY") *
        ((of("PVY1") + of("PVY2") * f) * of("LVY") + (of("PVY3") + of("PVY4") * f) * camber * kyg);
    const double x = alpha + sh, shape = of("PCY1") * of("LCY");
    const double peak =
        fz * (of("PDY1") + of("PDY2") * f) * (1.0 - of("PDY3") * camber * camber) * of("LMUY");
    double e = (of("PEY1") + of("PEY2") * f) *
               (1.0 - (of("PEY3") + of("PEY4") * camber) * (x > 0   ? 1
                                                            : x < 0 ? -1
                                                                    : 0)) *
               of("LEY");
    e = std::min(e, 1.0);
    const double slope = of("PKY1") * fz0 * std::sin(2.0 * std::atan(fz / (of("PKY2") * fz0))) *
                         (1.0 - of("PKY3") * std::abs(camber)) * of("LKY");
    return {magic(peak, shape, slope / (shape * peak), e, x) + sv, sh, sv, peak, slope};
  }
  /// Forces at both slips: weights of the combined slip, in which the slip angle is its tangent.
  std::pair<double, double> weighted(double fz, double kappa, double alpha, double gamma) const {
    const double f = dfz(fz);
    const auto weight = [&](double b, double c_shape, double e, double shift, double slip) {
      const auto g = [&](double x) {
        return std::cos(c_shape * std::atan(b * x - e * (b * x - std::atan(b * x))));
      };
      return g(slip + shift) / g(shift);
    };
    const double gx = weight(of("RBX1") * std::cos(std::atan(of("RBX2") * kappa)) * of("LXAL"),
                             of("RCX1"), of("REX1") + of("REX2") * f, of("RHX1"), std::tan(alpha));
    const double gy = weight(
        of("RBY1") * std::cos(std::atan(of("RBY2") * (std::tan(alpha) - of("RBY3")))) * of("LYKA"),
        of("RCY1"), of("REY1") + of("REY2") * f, of("RHY1") + of("RHY2") * f, kappa);
    const Pure y = fy(fz, alpha, gamma);
    const double induced = y.peak * (of("RVY1") + of("RVY2") * f + of("RVY3") * gamma) *
                           std::cos(std::atan(of("RVY4") * std::tan(alpha))) *
                           std::sin(of("RVY5") * std::atan(of("RVY6") * kappa)) * of("LVYKA");
    return {gx * fx(fz, kappa, gamma).value, gy * y.value + induced};
  }
  /// The friction ellipse of Adams as its manual has it, with the angle beta.
  std::pair<double, double> ellipse(double fz, double kappa, double alpha, double gamma) const {
    const Pure x = fx(fz, kappa, gamma), y = fy(fz, alpha, gamma);
    const double kappa_c = kappa + x.shift_h + x.shift_v / x.slope;
    const double alpha_c = alpha + y.shift_h + y.shift_v / y.slope, s = std::sin(alpha_c);
    const double beta = std::acos(std::abs(kappa_c) / std::sqrt(kappa_c * kappa_c + s * s));
    const double mx = std::abs(x.value - x.shift_v) / fz, my = std::abs(y.value - y.shift_v) / fz;
    const double mx_most = std::abs(x.peak) / fz, my_most = std::abs(y.peak) / fz;
    const double cx =
        1.0 / std::sqrt(std::pow(1.0 / mx, 2) + std::pow(std::tan(beta) / my_most, 2));
    const double cy =
        std::tan(beta) / std::sqrt(std::pow(1.0 / mx_most, 2) + std::pow(std::tan(beta) / my, 2));
    return {x.value * cx / mx, y.value * cy / my};
  }
};

// A made-up tyre, all blocks used. The formula of the program has 1e-6 N in its denominators, which
// bounds what can agree.
TEST(TyreKinds, ForcesOfOlderFilesAreThePublishedOnes) {
  std::string text = with(test_tyre_text(), "FITTYP = 61", "PROPERTY_FILE_FORMAT = 'PAC2002'");
  for (const char* key : {"PKY4 = 1.8", "PKY5 = 4\n", "PKY6 = -1\n", "PKY7 = -0.2\n", "PEY5 = 2\n",
                          "RBX3 = 5\n", "RBY4 = 3\n"})
    text = with(text, key, "");
  text += "PHY3 = 0.03\nLKYG = 1.2\nLFZO = 0.9\nLMUX = 0.8\nLMUY = 0.85\nLKY = 0.9\nLGAY = 1.1\n";
  const auto compare = [](const std::string& file, double friction_bound) {
    const Published published(file);
    const TyreCoefficients tyre = read(file);
    for (const double load : {0.3, 1.0, 1.7})
      for (const double kappa : {-0.3, -0.04, 0.0031, 0.02, 0.2})
        for (const double alpha : {-0.25, -0.03, 0.0047, 0.05, 0.3})
          for (const double gamma : {0.0, -0.05, 0.08}) {
            const double fz = load * tyre.nominal_load_n;
            vehicle::TyreInput<double> in;
            in.fz_n = fz;
            in.kappa = kappa;
            in.tan_alpha = std::tan(alpha);
            in.gamma_rad = std::asin(gamma);
            in.vx_mps = 20.0;
            const auto force =
                vehicle::tyre_forces(tyre, in, {}, {.alpha = vehicle::AlphaConvention::kAngle});
            const auto expected = tyre.friction_ellipse
                                      ? published.ellipse(fz, kappa, alpha, gamma)
                                      : published.weighted(fz, kappa, alpha, gamma);
            EXPECT_NEAR(force.fx_n, expected.first, friction_bound * fz);
            EXPECT_NEAR(force.fy_n, expected.second, friction_bound * fz);
          }
  };
  compare(text, 1e-7);
  compare(with(text, "PROPERTY", "FE_METHOD = 'YES'\nPROPERTY"), 1e-7);
}

}  // namespace tyre_kinds_test
