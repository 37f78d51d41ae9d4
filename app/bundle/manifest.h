// What a bundle says of itself: its first file, manifest.json, format seam-bundle/1
// (docs/reference/bundle.md).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace seam::app {

inline constexpr const char* kManifestName = "manifest.json";
// Sizes of a bundle in sum, and of its manifest.
inline constexpr uint64_t kMostBundleBytes = uint64_t{8} << 30;
inline constexpr uint64_t kMostManifestBytes = uint64_t{64} << 20;
inline constexpr size_t kMostBundleFiles = 100'000;

struct BundleFile {
  std::string name;  // In the archive.
  uint64_t bytes = 0;
  std::string sha256;
  bool program = false;  // It may be executed.
};

struct BundleManifest {
  std::string version, program;  // Of the SEAM that made the bundle.
  std::string of;                // The results, or the log; a file of the archive.
  std::vector<BundleFile> files;
  // Folders of meshes and textures as scenarios name them, and where they are in the archive.
  std::map<std::string, std::string> folders;
  // Words of behaviours' commands, and what stands in their place in the folder `work`.
  std::map<std::string, std::string> words;
  std::vector<std::string> needs;  // What the runs need beside the archive: sentences for people.

  std::string to_text() const;
  // Throws InputError naming the key; names are checked, none is there twice, none is a folder of
  // another, and sizes are within the limits.
  static BundleManifest from_text(const std::string& text, const std::string& where);
};

}  // namespace seam::app
