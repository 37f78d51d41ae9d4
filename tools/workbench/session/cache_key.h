// What a look at a version was made from. What was computed of other files, another model, other
// rows or by another program is computed again.
#pragma once

#include <string>

#include "tools/workbench/session/session.h"

namespace seam::tools {

// Of the set's files (names, sizes, times of change) and of this program.
std::string set_key(const Session& session);
// With that of the set, of the model's text and the rows left out.
std::string cache_key(const std::string& set_key, const Session& session, const Version& version);

}  // namespace seam::tools
