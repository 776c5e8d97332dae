// Every number that decides what is looked for, named, let go or left over. Of each: what it means;
// where it comes from; what shows what it is for. "Trials" are drawn by the second car of the tests
// (docs/crgexplain.md); "loss" is that of a least-squares fit in standard deviations squared, twice
// the logarithm of a likelihood.
#pragma once

#include <array>

#include "base/interval90.h"
#include "explain/model.h"

namespace explain::selection {

/// Standard deviations to either side of a 90 % interval.
inline constexpr double k90 = base::kNormal90;

// ---- How much a measurement counts -----------------------------------------------------------

/// A relation with forces counts as no more than this many independent rows where it is weighed by
/// cost: errors of the stated curves come back in every state and every lap.
/// From: recordings of trials without any effect. Shown by: Trials, Proofs.
inline constexpr double kIndependentRows = 60.0;

/// Share of the lateral force that stated tyre curves get wrong: what takes its place is no
/// finding. From: recordings of the stated car itself, where little grip is used or the air presses
/// little. Shown by: OwnCar.
inline constexpr double kCurveAcross = 0.01;

/// The same on top where the load swings, per rms of its share of gravity: tyres push less on the
/// mean than the car that is led, which feels waves of the road smoothed. From: the stated car
/// itself on two circuits of game meshes with facets, 3 to 16 % at 0.17 to 1.1.
inline constexpr double kLostBySwing = 0.15;

/// Rows that the analysis wants, about 15 s of driving. From: judgement. Shown by: BadInput.
inline constexpr std::size_t kLeastRows = 200;

// ---- Null replicates -------------------------------------------------------------------------

/// Share of the null replicates below the threshold of a score: both stages together then stay
/// below two alarms in a hundred. From: nulls of trials. Shown by:
/// Search.FalseAlarmsOfPureNoiseStayAtTheirRate, Trials.ASmallSetIsSealedExplainedAndScored.
inline constexpr double kNullQuantile = 0.9955;

/// Factor on that threshold where forces take part: errors of the stated curves and of the road's
/// slopes return every lap, which turned signs do not show. From: 200 recordings of trials without
/// any effect. Shown by: OtherSimulator.
inline constexpr double kMargin = 1.25;

/// Score from which something counts as an effect that was found and is taken out of the replicates
/// too, beside the best. From: the largest of all scores of noise alone rarely reaches it. Shown
/// by: Search.
inline constexpr double kPlanted = 5.0;

/// What noise does not show: errors of the model itself. Recordings of cars of another simulator
/// with nothing missing, on which these numbers were looked at, and how many of them raised an
/// alarm. The page prints it beside the share of the null replicates. Shown by: OtherSimulator.
inline constexpr int kOtherCars = 10, kOtherCarsAlarmed = 0;

/// Standard deviations from which something that is not named is listed as seen. From: noise alone
/// reaches it in one of a thousand.
inline constexpr double kSeen = 3.3;

// ---- A mechanism by its score ----------------------------------------------------------------

/// Findings of one stage at most. From: judgement; trials hold two effects at most.
inline constexpr int kMostFindings = 4;

/// Gain from which an amount is sought exactly and judged on laps left out. From: three standard
/// deviations.
inline constexpr double kWorthALook = 9.0;

/// How many are sought exactly; how many of those that differ in a constant alone; how many of the
/// best are judged. From: time; more never changed a finding of a trial.
inline constexpr int kMostExact = 10, kMostAlike = 3, kMostJudged = 6;

/// Standard errors between folds by which the gain on laps left out must be more than nothing.
/// From: convention. A gain that is nearly the whole (kNearlyWhole) needs kSureEnough only: two
/// folds have no standard error. Shown by: Search.FindsAndSizesWhatWasPlanted.
inline constexpr double kSure = 2.0, kNearlyWhole = 0.8, kSureEnough = 1.5;

/// Standard deviations between stretches of road (or of time, for the road itself) that a finding
/// must reach: errors of curves return at the same places. From: trials. Shown by: Trials.
inline constexpr double kGrouped = 4.0;

/// Share of half samples in which an amount keeps its sign. From: stability selection, convention.
inline constexpr double kStable = 0.8;

// ---- A stretch of road -----------------------------------------------------------------------

/// Loss that a stretch must save where forces count as few, as a mechanism must (kNamed); more
/// where it stands out less from what the same mechanism seems to do elsewhere. From: stretches of
/// low grip that were there saved 19 to 56, those that curves of tyres pretended in every lap 3 to
/// 4. Shown by: Proofs.
inline constexpr double kPlaced = 30.0;

/// Standard deviations from what relations without forces say of a stretch's amount at which they
/// deny it. From: where grip was missing, the tyres' forces asked for a banking that the
/// accelerometer denied by nine. Shown by: OtherSimulator.
inline constexpr double kDenied = 4.0;

// ---- A mechanism by what it costs ------------------------------------------------------------

/// Loss that a mechanism of car or air must save where forces count as few. From: in 300 trials
/// without any effect no mechanism did. Shown by: Trials, OtherSimulator.
inline constexpr double kNamed = 14.0;

/// Mechanisms that save this much alike are not told apart; parameters by kLead below. From: a
/// factor of 4.5 of likelihoods.
inline constexpr double kAsGood = 3.0;

/// Of a mechanism's square that curves and parameters must leave to it: below, as with inclined
/// tyres in most recordings, what the stated curves get wrong passes for it. From: trials. Shown
/// by: Search.FindsWhatTheModelCanNearlyDoIfAskedTo.
inline constexpr double kLeastLeft = 0.015;

/// The same of a sensor of the motion where the motion's own relations judge it: the unknown level
/// of the accelerometer takes nearly all of a gyro's gain, and what it leaves is exact. From: a
/// gain of -4.9 % put onto drives without any effect. Shown by: Trials.AGyrosGain.
inline constexpr double kLeastLeftOfMotion = 0.005;

// ---- A parameter that is off -----------------------------------------------------------------

/// Loss that letting a parameter go must save; on top for one that is held for want of evidence;
/// factor on its prior width then. From: trials. Shown by: Trials (brakes stronger than stated).
inline constexpr double kLetGo = 5.0, kHeldGo = 5.0, kFreed = 10.0;

/// Loss that letting a parameter go must have saved for the verdict to doubt it where it comes out
/// outside its prior width, but not beyond it for sure. From: masses stated 8 % off without wheel
/// loads saved 16; on a lap and a half without any effect a lift area saved 6. Shown by: OffMass.
inline constexpr double kDoubt = 10.0;

/// And the standard deviations outside it. From: masses truly 2 to 4 % off, stated to 5 %, without
/// wheel loads: two of eight came out 6.5 and 6.1 %, 0.6 of one outside; those 8 % off 1.0 and 1.7.
/// Shown by: OffMass, OtherSimulator.
inline constexpr double kDoubtful = 0.75;

/// Share of what letting a parameter go saves that it must still save beside a stretch of road that
/// saves more. From: torque stated 18 % off, beside which a grade saved more. Shown by: Proofs.
inline constexpr double kStillSaves = 0.5;

/// Standard deviations by which a parameter must lie beyond its prior width to be a finding. From:
/// on 599 trials 18 false ones and 3 right ones lay between 1.6 and this.
inline constexpr double kBeyond = 2.2;

/// Correlation of two parameters from which one is a rival of the other, and not separable from it.
/// From: convention.
inline constexpr double kRivalParameter = 0.9, kSameParameter = 0.95;

/// Share of its limit from which a parameter counts as run into it.
inline constexpr double kAtLimit = 0.99;

/// Two parameters this share off, beyond their priors, or one more by less: another car's file. And
/// two kinds of them off at all: both axles' lift alone may be one wrong number. From: 11 right and
/// 17 wrong pairs of five cars. Shown by: BadInput.
inline constexpr double kOtherCar = 0.3, kOtherCarLess = 0.2, kOtherCarAtAll = 0.1;
inline constexpr int kOtherCarParameters = 2;

// ---- Rivals ----------------------------------------------------------------------------------

/// Share of the gain from which another mechanism is a rival.
inline constexpr double kRival = 0.3;

/// Rivals are not separable below this lead in loss, or this share of the gain, which relations
/// that are not exact may get wrong about a column's shape (two errors of one sensor are judged by
/// the same kinematics, which are exact). From: pairs of trials that look alike. Shown by:
/// Trials, Proofs.
inline constexpr double kLead = 8.0, kInexact = 0.1, kInexactSensor = 0.03;

/// Nor are those whose columns are nearly parallel, without a lead of two standard errors and of
/// this much loss. From: the tangent spaces of pairs of trials that look alike.
inline constexpr double kParallel = 0.95, kParallelLead = 25.0, kParallelSure = 2.0;

// ---- The road along the whole lap ------------------------------------------------------------

/// Loss on what was left out that a profile must save, and standard errors between folds. From:
/// ovals that lean or not. Shown by: RoadProfiles.
inline constexpr double kProfileGain = 30.0, kProfileSure = 3.0;

/// One standard deviation of a gyro's gain: no lean is known better than it, for it takes the same
/// from the yaw rate. From: makers' data sheets.
inline constexpr double kUsualGyroGain = 0.0035;

/// Banking that turning alone tells takes this much from the cosine (6.8 degrees): twice the gain
/// of a gyro as it is usual. No gyro's gain is off by more than the other: 5 % is what makers of
/// cheap ones state. From: drives with known roads. Shown by: BankingByTurning,
/// tests/trials/banked_roads.
inline constexpr double kLeastDeficit = 0.007, kMostGyroGain = 0.05;

/// Factor on the intervals of banking that turning tells; standard deviations up to its limit (99
/// %, one-sided). From: drives on known roads, whose places lay inside 98 % of the intervals of 90
/// % without the factor; two limits of 45 of 95 % did not hold. Shown by:
/// tests/trials/banked_roads.
inline constexpr double kNarrowerTurning = 0.75, kTurningLimit = 2.33;

/// One standard deviation of the lean of a road where it does not turn and nothing tells it, m/m.
/// From: the straights of ovals lean by up to 12 degrees.
inline constexpr double kLeanUnseen = 0.1;

/// Share of what one kind of measurement saves that another must save too, or share by which laps
/// differ in speed: else what the car does in a place passes for its road. From: a sports car on a
/// flat circuit, whose ay is 2 to 4 % too large: 3 % and 5 %. Shown by: RoadProfiles.
inline constexpr double kSecondKind = 0.05, kOtherSpeeds = 0.1;

/// A stretch that is shorter is looked for by itself, m. From: the longest that is scanned.
inline constexpr double kOneStretch_m = 640.0;

/// A yaw rate that is this late is told beside the road, s. From: half a sample of 50 Hz.
inline constexpr double kLate_s = 0.01;

/// Factor on the intervals of a profile. From: errors on eight drives with known roads were 1.6
/// times as large as linear theory makes them. Shown by: RoadProfiles.
inline constexpr double kWiderProfile = 1.6;

// ---- What is left over -----------------------------------------------------------------------

/// Below these a leftover is of no use to anyone who drives or tunes, in the relation's unit. From:
/// the noise of good loggers, and what 0.3 s of it moves.
inline constexpr std::array<double, kRelationCount> kLeastLeftover{
    0.004, 0.004, 0.08, 0.2, 0.5, 0.12, 0.15, 0.3, 0.25, 0.4, 0.3, 0.4, 0.4, 0.4, 0.001, 0.01, 3e4};

/// Adjusted p above which nothing is called a mismatch. From: convention.
inline constexpr double kMismatch = 0.05;

// ---- Short waves -----------------------------------------------------------------------------

/// Share of the nulls (one half of the laps moved along the road) below the threshold of
/// agreement; RMS heights below which a simulation has no use for them, m. Shown by: Proofs.
inline constexpr double kWavesQuantile = 0.985, kLeastWave_m = 0.0015;

/// A contact takes a height's place from this share of what new heights take away, and of the whole
/// error; heights can imitate any contact, a contact no height. It is not told from heights below
/// kContactAlone. From: trials about waves. Shown by: Proofs.
inline constexpr double kContactShare = 0.6, kContactLeast = 0.3, kContactAlone = 0.85;

// ---- Brake discs -----------------------------------------------------------------------------

/// Of 1000 turns of blocks of 20 s at most so many may reach the score; share of laps left out that
/// must be predicted better; slope that matters. Rivals as above (kLead, kInexact). From: trials
/// about discs. Shown by: Proofs.
inline constexpr int kMostTurns = 10;
inline constexpr double kBetterLaps = 0.75, kLeastSlope = 0.15;

// ---- The whole simulated car -----------------------------------------------------------------

/// Share by which an error on laps left out may be worse for sure where the rest is better. From:
/// ten right corrections of trials, of which none was worse by more than 0.8 %. Shown by: WholeCar.
inline constexpr double kWorse = 0.02;

}  // namespace explain::selection
