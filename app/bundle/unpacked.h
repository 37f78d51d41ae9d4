// A bundle unpacked into a folder of its own, to be run. Nothing of it is used before all of it has
// its checksums; nothing in it is started here.
#pragma once

#include <filesystem>

#include "app/bundle/manifest.h"
#include "app/scratch_folder.h"
#include "sim_core/scenario/scenario.h"

namespace seam::app {

// Whether a file begins as a bundle does.
bool is_bundle(const std::filesystem::path& file);

class UnpackedBundle {
 public:
  // Throws InputError for damage, for a file that is not in the manifest or not as it says, and for
  // one that is missing. Unpacks files of the manifest's sizes alone.
  explicit UnpackedBundle(const std::filesystem::path& file);

  const BundleManifest& manifest() const { return manifest_; }
  // Where a file of the archive is now.
  std::filesystem::path place(const std::string& name) const;
  // A folder for what is made meanwhile; it goes with the bundle.
  std::filesystem::path scratch() const { return folder_.path() / "made"; }
  // The behaviours' working folder.
  std::filesystem::path work() const { return place("work"); }
  // The scenario with files and programs of the bundle. Throws InputError where it names a mesh or
  // a texture that is not in there.
  void move_here(Scenario& scenario) const;

 private:
  ScratchFolder folder_;
  BundleManifest manifest_;
};

// While it lives the process works in another folder.
class WorkingFolder {
 public:
  explicit WorkingFolder(const std::filesystem::path& folder);
  ~WorkingFolder();
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  std::filesystem::path before_;
};

}  // namespace seam::app
