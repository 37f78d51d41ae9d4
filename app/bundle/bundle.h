// A bundle: results of a sweep, or the log of a run, with all that making them again takes, in one
// archive (docs/reference/bundle.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/bundle/manifest.h"

namespace seam::app {

struct BundleOptions {
  std::filesystem::path source;   // Results or a log.
  std::filesystem::path out;      // The bundle.
  std::vector<std::string> with;  // Files and folders that behaviours open by themselves.
  bool logs = true;               // Those of a sweep that keeps them.
};

// Whether a file begins as a log does.
bool is_log(const std::filesystem::path& file);

// Throws InputError where something cannot be read, or is too large for a bundle.
BundleManifest make_bundle(const BundleOptions& options);

}  // namespace seam::app
