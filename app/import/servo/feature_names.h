// What the numbers of a learning robot's data set are called: in its info.json (LeRobot), or as
// texts beside the arrays of our own episodes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/import/files/signals.h"

namespace seam::app {

using FeatureNames = std::map<std::string, std::vector<std::string>>;

// Whether a file is called as those that hold names, and no samples.
bool is_feature_file(const std::filesystem::path& path);
// By feature. Throws InputError.
FeatureNames read_feature_names(const std::filesystem::path& path);

// FEATURE[0], FEATURE[1], ... become FEATURE.NAME, by these names and by those that the log itself
// has as texts FEATURE.names. Throws InputError where there are more or fewer.
void name_features(SignalLog& log, const FeatureNames& names);

}  // namespace seam::app
