// The numbers by which the search decides: when an effect counts as found, which of several comes
// first, when it may go again, and what is worth a fit. Each has its reason; where a study stands
// behind it, docs/evidence/studies.md has its figures, else it is called a judgement: practice sets
// and studies were right with it, and no study compared it with its neighbours.
//
// "Units" are natural units of log-likelihood: 2 units are a likelihood ratio of 7, and a
// parameter that stands z standard errors clear of neutral gains z^2 / 2.
#pragma once

#include <cstddef>

namespace seam::measurement {

// ---- Found or not -------------------------------------------------------------------------------

// An effect counts as found where its log-evidence, with all effects that were looked at as likely,
// is ahead by this: odds of 12 to 1. With ten looks that is 3.5 standard errors of one parameter,
// with the power and the false alarms of docs/evidence/benchmark.md ("Numbers 2200"); with 2 a null
// set of whole runs named an effect (Outcomes.NothingHiddenNothingFound).
inline constexpr double kOdds = 2.5;
// Standard errors that a value may reach where the effect is not there: priors are no narrower. A
// judgement.
inline constexpr double kReachOfNothing = 3;
// Structure tests are designed for false alarms in half of 1 % of sets. Measured: 0 to 3 in 200
// sets of each kind (docs/evidence/studies.md, "Measured").
inline constexpr double kAlarm = 0.005;

// An error above this is no sampling error of a model that lacks nothing: that of 300 held-out
// residuals scatters by 0.04 (docs/evidence/studies.md, "Final error"), so that 1.15 is more than
// three of these.
inline constexpr double kMisfit = 1.15;

// A model with an error above this explains nothing yet: its outliers mean nothing, and training
// groups can be fitted by what is wrong elsewhere. A judgement.
inline constexpr double kUseless = 10;

// An effect whose values lie within so many of their stated errors of neutral is no result: the
// interval that holds the truth in 95 % of sets holds its absence.
inline constexpr double kWithinError = 2;

// Held-out groups agree that an effect helps unless they lose more than this, in units: bad luck
// is the likelier reason of less (docs/evidence/studies.md, "Flat fields": they lose once in ten
// times at five standard errors).
inline constexpr double kUnluckyLoss = -2;
// Above kMisfit a likelihood says little: held-out groups must gain by more than one standard error
// of their scatter. A judgement.
inline constexpr double kAgreedGain = 1;

// An error that falls to less than this share of itself falls plainly, whatever the scatter of few
// groups is. It is so defined in this project.
inline constexpr double kPlainlyLess = 0.5;

// With fewer held-out groups than this their scatter is not known.
inline constexpr int kLeastGroupsForScatter = 3;

// While the noise is missed, an effect of the mean that lowers residuals in their own units by this
// share is taken before any spread: a spread wide enough makes any residual small in units of
// itself. A twentieth of the residual is a tenth of its square. A judgement.
inline constexpr double kHeardFirst = 0.05;

// Standard errors of the held-out gain at which an effect of the mean helps in most groups, not by
// the luck of a few: jitter moves whole groups and lets other effects seem to help. A judgement.
inline constexpr double kClearGain = 4;

// What moves predictions by less than this share of the noise is a trace, however significant: it
// adds 0.5 % to the error. With many observations every model is wrong significantly; another
// renderer's pictures made a blur of 0.01 px a missing effect that lowered the error from 1.0041 to
// 1.0039.
inline constexpr double kMaterial = 0.1;

// A trace beside which a value of the model moves by more than this many of the errors that are
// told of it stays in the model: a value so far off is told wrong, whatever one takes an error for.
// A judgement: traces of real flat fields move some value by 59, 12, 7 and 4 of its errors
// (docs/evidence/real-ccd.md).
inline constexpr double kToldWrong = 10;
// As many stay at most. A judgement: each is a further fit of all the others.
inline constexpr size_t kMostKept = 4;

// A spread that widens the noise over a misfit is none if a mean explains this share of the squared
// residuals that it calls noise. A judgement.
inline constexpr double kHiddenMean = 0.25;
// The same where the model misses by far more than the noise, so that a spread can be any mean.
// Between what a true wander of some 60 lengths leaves by chance (0.02) and what one leaves that
// stands for a limit of torque (0.1). A judgement.
inline constexpr double kHiddenMeanFar = 0.05;

// More outliers than this share are no gross errors but a model that fails: none is left out. So
// the word is defined in this project.
inline constexpr double kMostOutliers = 0.1;

// Marks of outliers and the model found under them are settled in turn, at most so often. A
// judgement: two rounds are the rule.
inline constexpr int kOutlierRounds = 5;

// ---- Doubted although found ---------------------------------------------------------------------

// Effects cancel each other where all of them together move predictions by less than this share of
// what one moves alone. Of two effects of random sizes that act alike one pair in eleven does so.
// A judgement.
inline constexpr double kCancelled = 0.25;
// A value that one group moves by more than so many of its errors, by so many standard deviations
// of what chance lets its information move it (in one of a million cases), and by this share of
// itself, is that group's: where it moves by less, its stated error is too small and its cause the
// same. The share is a judgement.
inline constexpr double kManyErrors = 3, kManyScatters = 5, kMadeShare = 0.1;

// ---- Which comes first --------------------------------------------------------------------------

// Two explanations within this many units count as equally good: a likelihood ratio of 100 to 1.
// In units of the misfit where a model misses more than the noise.
inline constexpr double kTieWidth = 4.6;
// Ties are passed on (where a is as good as b and b as c, all three are declared), but no further
// from the best than so many widths: there the likelihood ratio is 10,000 to 1. A judgement.
inline constexpr double kTieReach = 2;
// How many others are named beside a tied effect: more would hide the point. A judgement.
inline constexpr size_t kMostTiesNamed = 3;
// Where fewer numbers than this are held out, one that they deny is named beside an equal that they
// do not: an error of 30 numbers is good to an eighth. A judgement.
inline constexpr int kFewHeldOut = 30;
// A cause without a name must be ahead of all named ones by this, at which the likelihood ratio is
// 10,000 to 1: a field is free to be anything.
inline constexpr double kUnnamedWidth = kTieReach * kTieWidth;
// Beside such a cause, or where something speaks against it, an effect imitates what smooth
// functions can do where less than this share of what it takes is its own; a formula explains
// nothing that takes less than this share of the excess that they do. A judgement.
inline constexpr double kOwnBesideUnnamed = 1.0 / 3;
// Beside a cause without a name, an effect is missing for sure, and imitates nothing, where it
// moves predictions by so many times what the cause does: what stands for a cause but for a tenth
// would be its name. A judgement.
inline constexpr double kFarAboveUnnamed = 10;
// An exchange of one effect for another must gain this share of a tie's width: less is within what
// two fits of one model differ by, and the search would go round in circles. A judgement.
inline constexpr double kExchangeGain = 0.25;

// ---- The way of the search ----------------------------------------------------------------------

// Effects taken one after another. A judgement: sets with four at once were tried, none with more.
inline constexpr size_t kMostSteps = 8;
// Effects that were significant in some look are tried in exchanges, as many as these.
inline constexpr size_t kMostPromising = 8;
// An effect so many standard errors from neutral cannot go: dropping it would lose 32 units, more
// than any price. It saves the fit that would show it.
inline constexpr double kCannotGo = 8;
inline constexpr double kAnyPrice = 0.5 * kCannotGo * kCannotGo;
// The model with its steps in order is kept in the place of the one that the search ended with
// unless it lost more than this in units, which is what two fits of one model differ by.
inline constexpr double kSameFit = 0.5;

// ---- What is worth a fit ------------------------------------------------------------------------

// A value that is known so many times worse beside the others than alone may be one that these can
// make up for, as where both polynomials of a quotient have a factor in common: derivatives are too
// coarse to show it (1e-4), so the model is fitted without it. A judgement: the numbers of rational
// lenses stood at 100 to 700 without such a factor and above 1,000 with one.
inline constexpr double kHangsOnOthers = 1e3;
// The same where an earlier value of the effect was left out.
inline constexpr double kMayHangOnOthers = 100;
// A column of which others leave less than this share, by length, is theirs: differences of
// predictions are good to about this.
inline constexpr double kAbsorbed = 1e-5;
// Of a model whose parameters are all refitted, one whose column has less than this share of its
// own is not freed: its standard error would be 10,000 times what it is alone. A judgement.
inline constexpr double kUntold = 1e-4;
// A parameter that moves residuals by less than two standard errors over all of its bounds cannot
// be seen at any size in them.
inline constexpr double kLeastReach = 2;
// Of the counts of an effect that is tried (bits, periods) so many go on to a fit. A judgement: the
// best of them without a fit is nearly always the best with one.
inline constexpr size_t kMostCountsFitted = 2;
// More starts than this stand for several valleys, of which a step from the first says little.
inline constexpr size_t kMostStartsOfOneValley = 4;
// Of the prospects that a score test calls promising the best few are fitted, those whose corrected
// p-value is below kPromising if gains exceed the step's by kScoreMargin. A judgement.
inline constexpr size_t kMostFitted = 6;
inline constexpr double kScoreMargin = 1.5;
inline constexpr double kPromising = 0.5;

// ---- Formulas that are suggested ----------------------------------------------------------------

// The price of a number in a formula is Schwarz's, so often log n: no record says how large it is.
inline constexpr double kPriceOfNumber = 0.5;
// Terms of one formula. A judgement.
inline constexpr size_t kMostTerms = 6;
// Waves have up to so many half periods over a variable's range. A judgement: each is a look.
inline constexpr int kMostWaves = 300;
// Those that are so strong, as a share of the strongest, may be the strongest once their frequency
// is found: half a step of the grid off, a wave has four fifths of its gain. A faster one is taken
// if it gains so many times as much. A judgement.
inline constexpr double kNearlyAsStrong = 0.7, kClearlyStronger = 1.02;
// A wave is looked for with so many observations at least, those on which its output acts by this
// share of the most or more.
inline constexpr size_t kLeastForWaves = 30;
inline constexpr double kLeastActing = 0.2;
// A column of which others leave less than this share of its sum of squares is theirs (kAbsorbed
// for columns made with one step of difference, whose length is good to 1e-4). A judgement.
inline constexpr double kSpanned = 1e-8;
// The gain of a formula must be so many standard errors of its scatter between held-out groups, or,
// where fewer than this are held out, between their blocks or all groups: a formula is free to be
// anything, so it is held to more than an effect with a name. A judgement.
inline constexpr size_t kGroupsForAgreement = 6;
inline constexpr double kAgreedFormula = 2.5;
// A term takes at least this share of a channel's squared residual, or it is not worth reading: at
// the noise what kMaterial moves takes so much.
inline constexpr double kLeastWorthReading = 0.01;
// And this share of what the squared error has beyond the noise, where the model misses that: a few
// terms that each take less explain nothing, and are dear. A judgement.
inline constexpr double kLeastOfExcess = 0.1;

}  // namespace seam::measurement
