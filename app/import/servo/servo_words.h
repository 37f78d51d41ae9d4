// Columns whose names are ours but which hold words, or nothing, where numbers are expected: an
// import drops none of them without a word.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/set_draft.h"
#include "app/import/files/signals.h"
#include "app/import/servo/servo_columns.h"

namespace seam::app {

// Of columns by one of these names. Throws InputError for a word among numbers, and for a column
// that the user maps and that has none; says which of the usual ones has none.
void look_for_words(const ImportRequest& request, const SignalLog& log, const std::string& quantity,
                    const std::vector<std::string>& usual, SetDraft& draft);

// The same of the torques of joints: those without any number are left out, and how many rows of
// the others have none is said.
void look_at_efforts(const ImportRequest& request, const SignalLog& log,
                     std::vector<JointColumns>& joints, SetDraft& draft);

}  // namespace seam::app
