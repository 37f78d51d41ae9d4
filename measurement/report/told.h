// Values and structures in words, as every command prints them.
#pragma once

#include <string>
#include <vector>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// Two digits, without an exponent where people need none: 200, 1.5, 3e-05.
std::string two_digits(double value);

// "0.0021 +- 3e-05"; where the error is no less than the distance from neutral "0 within +- 3e-05",
// or "not determined (+- 200)" if the error is no small part of the parameter's typical size; and
// that a value lies at the end of its range, where no error means much.
std::string told_value(const effects::Parameter& parameter, const effects::ParameterValue& value);
// The same of a value of the model that is named `parameter`, of the last effect that it has of
// that name, or `effect.parameter`.
std::string told_value(const Model& model, const std::string& name,
                       const effects::ParameterValue& value);
// "k1 = 0.0021 +- 3e-05, k2 = not determined (+- 200)".
std::string told_values(const Assessment& assessment, const std::string& effect);

// Whether the data determine at least one value of an effect, or it is not fitted. Else the effect
// stands in the model for the sake of others: a shape that others scale.
bool determines_a_value(const Assessment& assessment, const std::string& effect);

// "mean of u_px varies with row x pan rate".
std::string told_structure(const Facts& facts, const Structure& structure);
// One line each, the strongest first, at most eight: with strength, noise units and p.
std::string structure_lines(const Problem& problem, const Assessment& assessment,
                            const std::vector<Structure>& structure);

// What a user can vary to learn more of what depends on this covariate, as the rest of a sentence;
// empty where it is nothing that can be varied (a label, the neighbour, a constant).
std::string what_to_vary(const Facts& facts, const std::string& covariate);

}  // namespace seam::measurement
