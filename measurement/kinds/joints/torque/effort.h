// Column effort_nm of a servo's log: the torque of its motor, or a current that was turned into it.
// A model with torque says what its drive gives at each row, in acceleration of the joint; times
// the inertia it is a torque. Where the model states no inertia (joint_inertia), the column says
// itself which one agrees best.
#pragma once

#include <string>
#include <vector>

#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

inline constexpr const char* kEffort = "effort_nm";

// The column's values by row, NaN where blank; empty without the column, without a value in it, or
// where no value differs from another, which is no measurement. Throws InputError for what no motor
// gives.
std::vector<double> read_efforts(const CsvTable& table);

// Why a column that is there takes no part whatever the model; empty: it does, or is not there.
std::string note_of_efforts(const CsvTable& table);

// Whether torques are held against what this model predicts.
bool predicts_efforts(const Model& model);
// Whether it says what the inertia is, or leaves it to a fit.
bool states_inertia(const Model& model);
// Whether it says so for good: no fit moves the inertia.
bool knows_inertia(const Model& model);
// Whether an effect acts on measured torques alone.
bool is_of_efforts(const EffectDefinition& effect);

// Fills the residuals of the second channel's scalars in these groups from the drive by row.
// Returns the inertia that the model states, or that agrees best with what is used.
double add_effort_residuals(const Problem& problem, const Model& model, const Groups& groups,
                            const std::vector<double>& efforts_nm,
                            const std::vector<double>& drive_rad_per_s2, Evaluation& evaluation);

}  // namespace seam::measurement
