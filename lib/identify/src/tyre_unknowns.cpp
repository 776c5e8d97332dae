#include "identify/tyre_unknowns.h"

namespace identify {
namespace {

using K = SlipKind;
using N = Needs;

// Bounds are those within which one curve has one peak and goes on falling behind it: 1 <= C <= 2,
// E <= 1 (Pacejka 2012, section 4.3.1), friction and stiffness that are there. Spreads cover what
// published files of passenger and racing tyres have.
#define UNKNOWN(member, keyword) #keyword, &vehicle::TyreCoefficients::member
constexpr TyreUnknown kUnknowns[] = {
    {UNKNOWN(pcy1, PCY1), K::kLateral, N::kSlip, 0.3, 1.0, 2.0, true, true},
    {UNKNOWN(pdy1, PDY1), K::kLateral, N::kSlip, 0.5, 0.05, 5.0, true, true},
    {UNKNOWN(pdy2, PDY2), K::kLateral, N::kLoad, 0.3, -2.0, 2.0, true, true},
    {UNKNOWN(pdy3, PDY3), K::kLateral, N::kCamber, 8.0, -100.0, 100.0, true, true},
    {UNKNOWN(pey1, PEY1), K::kLateral, N::kSlip, 1.0, -30.0, 1.0, true, true},
    {UNKNOWN(pey2, PEY2), K::kLateral, N::kLoad, 1.0, -30.0, 30.0, true, true},
    {UNKNOWN(pey3, PEY3), K::kLateral, N::kSlip, 0.3, -10.0, 10.0, true, true},
    {UNKNOWN(pey4, PEY4), K::kLateral, N::kCamber, 15.0, -500.0, 500.0, true, true},
    {UNKNOWN(pey5, PEY5), K::kLateral, N::kCamber, 100.0, -5000.0, 5000.0, false, true},
    {UNKNOWN(pky1, PKY1), K::kLateral, N::kSlip, 15.0, -300.0, 300.0, true, true},
    {UNKNOWN(pky2, PKY2), K::kLateral, N::kLoad, 1.5, 0.1, 20.0, true, true},
    {UNKNOWN(pky3, PKY3), K::kLateral, N::kCamber, 1.0, -10.0, 10.0, true, true},
    {UNKNOWN(pky4, PKY4), K::kLateral, N::kLoad, 0.8, 0.5, 3.5, false, true},
    {UNKNOWN(pky5, PKY5), K::kLateral, N::kCamber, 40.0, -500.0, 500.0, false, true},
    {UNKNOWN(pky6, PKY6), K::kLateral, N::kCamber, 2.0, -20.0, 20.0, false, true},
    {UNKNOWN(pky7, PKY7), K::kLateral, N::kCamber, 1.0, -20.0, 20.0, false, true},
    {UNKNOWN(phy1, PHY1), K::kLateral, N::kSlip, 0.01, -0.1, 0.1, true, true},
    {UNKNOWN(phy2, PHY2), K::kLateral, N::kLoad, 0.01, -0.1, 0.1, true, true},
    {UNKNOWN(phy3, PHY3), K::kLateral, N::kCamber, 0.2, -2.0, 2.0, true, false},
    {UNKNOWN(pvy1, PVY1), K::kLateral, N::kSlip, 0.05, -0.5, 0.5, true, true},
    {UNKNOWN(pvy2, PVY2), K::kLateral, N::kLoad, 0.05, -0.5, 0.5, true, true},
    {UNKNOWN(pvy3, PVY3), K::kLateral, N::kCamber, 1.0, -10.0, 10.0, true, true},
    {UNKNOWN(pvy4, PVY4), K::kLateral, N::kCamber, 1.0, -10.0, 10.0, true, true},
    {UNKNOWN(ppy1, PPY1), K::kLateral, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(ppy2, PPY2), K::kLateral, N::kPressure, 1.0, -5.0, 5.0, false, true},
    {UNKNOWN(ppy3, PPY3), K::kLateral, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(ppy4, PPY4), K::kLateral, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(ppy5, PPY5), K::kLateral, N::kPressure, 1.0, -5.0, 5.0, false, true},
    {UNKNOWN(pcx1, PCX1), K::kLongitudinal, N::kSlip, 0.3, 1.0, 2.0, true, true},
    {UNKNOWN(pdx1, PDX1), K::kLongitudinal, N::kSlip, 0.5, 0.05, 5.0, true, true},
    {UNKNOWN(pdx2, PDX2), K::kLongitudinal, N::kLoad, 0.3, -2.0, 2.0, true, true},
    {UNKNOWN(pdx3, PDX3), K::kLongitudinal, N::kCamber, 8.0, -100.0, 100.0, true, true},
    {UNKNOWN(pex1, PEX1), K::kLongitudinal, N::kSlip, 0.7, -30.0, 1.0, true, true},
    {UNKNOWN(pex2, PEX2), K::kLongitudinal, N::kLoad, 0.7, -30.0, 30.0, true, true},
    {UNKNOWN(pex3, PEX3), K::kLongitudinal, N::kLoad, 0.7, -30.0, 30.0, true, true},
    {UNKNOWN(pex4, PEX4), K::kLongitudinal, N::kSlip, 0.3, -0.95, 0.95, true, true},
    {UNKNOWN(pkx1, PKX1), K::kLongitudinal, N::kSlip, 15.0, 1.0, 300.0, true, true},
    {UNKNOWN(pkx2, PKX2), K::kLongitudinal, N::kLoad, 20.0, -300.0, 300.0, true, true},
    {UNKNOWN(pkx3, PKX3), K::kLongitudinal, N::kLoad, 0.5, -5.0, 5.0, true, true},
    {UNKNOWN(phx1, PHX1), K::kLongitudinal, N::kSlip, 0.005, -0.1, 0.1, true, true},
    {UNKNOWN(phx2, PHX2), K::kLongitudinal, N::kLoad, 0.005, -0.1, 0.1, true, true},
    {UNKNOWN(pvx1, PVX1), K::kLongitudinal, N::kSlip, 0.05, -0.5, 0.5, true, true},
    {UNKNOWN(pvx2, PVX2), K::kLongitudinal, N::kLoad, 0.05, -0.5, 0.5, true, true},
    {UNKNOWN(ppx1, PPX1), K::kLongitudinal, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(ppx2, PPX2), K::kLongitudinal, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(ppx3, PPX3), K::kLongitudinal, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(ppx4, PPX4), K::kLongitudinal, N::kPressure, 0.5, -5.0, 5.0, false, true},
    {UNKNOWN(rbx1, RBX1), K::kCombined, N::kSlip, 6.0, 0.5, 60.0, true, true},
    {UNKNOWN(rbx2, RBX2), K::kCombined, N::kSlip, 6.0, -60.0, 60.0, true, true},
    {UNKNOWN(rbx3, RBX3), K::kCombined, N::kCamber, 500.0, -5000.0, 5000.0, false, true},
    {UNKNOWN(rcx1, RCX1), K::kCombined, N::kSlip, 0.15, 0.5, 1.4, true, true},
    {UNKNOWN(rex1, REX1), K::kCombined, N::kSlip, 0.7, -20.0, 1.0, true, true},
    {UNKNOWN(rex2, REX2), K::kCombined, N::kLoad, 0.5, -20.0, 20.0, true, true},
    {UNKNOWN(rhx1, RHX1), K::kCombined, N::kSlip, 0.01, -0.1, 0.1, true, true},
    {UNKNOWN(rby1, RBY1), K::kCombined, N::kSlip, 6.0, 0.5, 60.0, true, true},
    {UNKNOWN(rby2, RBY2), K::kCombined, N::kSlip, 6.0, -60.0, 60.0, true, true},
    {UNKNOWN(rby3, RBY3), K::kCombined, N::kSlip, 0.02, -0.5, 0.5, true, true},
    {UNKNOWN(rby4, RBY4), K::kCombined, N::kCamber, 1000.0, -9000.0, 9000.0, false, true},
    {UNKNOWN(rcy1, RCY1), K::kCombined, N::kSlip, 0.15, 0.5, 1.4, true, true},
    {UNKNOWN(rey1, REY1), K::kCombined, N::kSlip, 0.7, -20.0, 1.0, true, true},
    {UNKNOWN(rey2, REY2), K::kCombined, N::kLoad, 0.5, -20.0, 20.0, true, true},
    {UNKNOWN(rhy1, RHY1), K::kCombined, N::kSlip, 0.01, -0.1, 0.1, true, true},
    {UNKNOWN(rhy2, RHY2), K::kCombined, N::kLoad, 0.01, -0.1, 0.1, true, true},
    {UNKNOWN(rvy1, RVY1), K::kCombined, N::kSlip, 0.1, -2.0, 2.0, true, true},
    {UNKNOWN(rvy2, RVY2), K::kCombined, N::kLoad, 0.1, -2.0, 2.0, true, true},
    {UNKNOWN(rvy3, RVY3), K::kCombined, N::kCamber, 1.0, -20.0, 20.0, true, true},
    {UNKNOWN(rvy4, RVY4), K::kCombined, N::kSlip, 40.0, -300.0, 300.0, true, true},
    {UNKNOWN(rvy5, RVY5), K::kCombined, N::kSlip, 0.5, -10.0, 10.0, true, true},
    {UNKNOWN(rvy6, RVY6), K::kCombined, N::kSlip, 15.0, -200.0, 200.0, true, true},
};
#undef UNKNOWN

}  // namespace

std::span<const TyreUnknown> tyre_unknowns() { return kUnknowns; }

}  // namespace identify
