#include "render/assets/mesh_cache.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"

namespace seam::render {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "seam-cache/1";
constexpr size_t kHeadBytes = kMagic.size() + 8;

fs::path usual_folder() {
  const auto folder_of = [](const char* variable) {
    const char* value = std::getenv(variable);
    const fs::path path = value == nullptr ? "" : value;
    return path.is_absolute() ? path : fs::path();
  };
  if (const fs::path cache = folder_of("XDG_CACHE_HOME"); !cache.empty()) return cache / "seam";
  const fs::path home = folder_of("HOME");
  return home.empty() ? home : home / ".cache" / "seam";
}

// Of the key too, so that an entry under another's name is none.
std::string head_of(const std::string& key, std::string_view content) {
  Hasher hasher;
  hasher.add(std::string_view(key));
  hasher.add(content);
  const uint64_t sum = hasher.digest();
  std::string head(kMagic);
  head.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  return head;
}

// Removes what was used least lately until no more than `most` bytes are left.
void shrink(const fs::path& folder, uint64_t most) {
  struct Entry {
    fs::file_time_type used;
    fs::path path;
    uint64_t bytes;
  };
  std::vector<Entry> entries;
  uint64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;
    const uint64_t bytes = at->is_regular_file(gone) ? at->file_size(gone) : 0;
    const auto used = at->last_write_time(gone);
    if (gone || !at->is_regular_file(gone)) continue;
    entries.push_back({used, at->path(), bytes});
    sum += bytes;
  }
  if (sum <= most) return;
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.used != b.used ? a.used < b.used : a.path < b.path;
  });
  for (const Entry& entry : entries) {
    if (sum <= most) return;
    if (fs::remove(entry.path, error)) sum -= entry.bytes;
  }
}

}  // namespace

std::string digest_of(std::span<const std::string_view> parts) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        EVP_MD_CTX_free);
  bool good = context && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1;
  for (const std::string_view part : parts) {
    const uint64_t size = part.size();
    good = good && EVP_DigestUpdate(context.get(), &size, sizeof size) == 1 &&
           EVP_DigestUpdate(context.get(), part.data(), part.size()) == 1;
  }
  unsigned char bytes[EVP_MAX_MD_SIZE];
  unsigned count = 0;
  good = good && EVP_DigestFinal_ex(context.get(), bytes, &count) == 1;
  SEAM_CHECK(good, "no SHA-256");
  std::string text;
  for (unsigned i = 0; i < count; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

MeshCache MeshCache::of_environment() {
  const char* const named = std::getenv("SEAM_CACHE");
  fs::path folder = named == nullptr ? usual_folder() : fs::path(named);
  if (named != nullptr && (folder.empty() || folder == "off")) return MeshCache("");
  return MeshCache(folder.empty() ? folder : folder / "meshes");
}

std::optional<std::string> MeshCache::find(const std::string& key) const {
  if (folder_.empty()) return std::nullopt;
  const fs::path path = folder_ / key;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  try {
    std::string bytes = read_file(path, most_bytes_);
    const std::string_view content =
        std::string_view(bytes).substr(std::min(bytes.size(), kHeadBytes));
    if (!bytes.starts_with(head_of(key, content))) return std::nullopt;
    utimensat(AT_FDCWD, path.c_str(), nullptr, 0);  // Used now.
    return bytes.erase(0, kHeadBytes);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

void MeshCache::store(const std::string& key, std::string_view content) const {
  if (folder_.empty() || content.size() + kHeadBytes > most_bytes_) return;
  try {
    make_output_folder(folder_);
    write_file_atomically(folder_ / key, head_of(key, content) + std::string(content));
    shrink(folder_, most_bytes_);
  } catch (const InputError&) {
    return;  // A full disk, or a folder that others own.
  }
}

}  // namespace seam::render
