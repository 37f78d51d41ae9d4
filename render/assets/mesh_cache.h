// What was made of a file, kept for the next run: a folder of entries by the digest of all that
// went into them. It may be deleted at any time, and an entry that is damaged or that someone else
// put there is as none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace seam::render {

// SHA-256 of the parts, each with its length, as 64 hexadecimal digits.
std::string digest_of(std::span<const std::string_view> parts);

class MeshCache {
 public:
  static constexpr uint64_t kMostBytes = uint64_t{512} << 20;

  // Where the environment says: the folder that SEAM_CACHE names ("off": none), else
  // $XDG_CACHE_HOME/seam, else ~/.cache/seam.
  static MeshCache of_environment();
  // An empty folder keeps nothing.
  explicit MeshCache(std::filesystem::path folder, uint64_t most_bytes = kMostBytes)
      : folder_(std::move(folder)), most_bytes_(most_bytes) {}

  // The content that was stored under this key, whole. Its checksum is right, but whoever reads it
  // must not trust it further: anyone may compute one.
  std::optional<std::string> find(const std::string& key) const;
  // Never fails: a cache that cannot be written is none. Beyond `most_bytes` the entries that were
  // used least lately go.
  void store(const std::string& key, std::string_view content) const;

 private:
  std::filesystem::path folder_;
  uint64_t most_bytes_;
};

}  // namespace seam::render
