#include "tools/workbench/session/cache_key.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/system/own_files.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostFiles = 200'000;

void add_file(const fs::path& file, Hasher& hasher) {
  std::error_code missing;
  hasher.add(file.string());
  hasher.add(static_cast<uint64_t>(fs::file_size(file, missing)));
  hasher.add(int64_t{fs::last_write_time(file, missing).time_since_epoch().count()});
}

}  // namespace

std::string set_key(const Session& session) {
  std::vector<fs::path> files;
  std::error_code failed;
  fs::recursive_directory_iterator at(session.state().data, failed), end;
  for (; !failed && at != end; at.increment(failed)) {
    // The session itself may lie in the folder of its set.
    if (at->is_directory(failed) && fs::equivalent(at->path(), session.folder(), failed)) {
      at.disable_recursion_pending();
    } else if (at->is_regular_file(failed)) {
      files.push_back(at->path());
    }
    if (files.size() > kMostFiles)
      throw InputError(fmt::format("{}: has more than {} files", session.state().data, kMostFiles));
  }
  std::sort(files.begin(), files.end());
  Hasher hasher;
  for (const fs::path& file : files) add_file(file, hasher);
  add_file(program_file(), hasher);
  return to_hex(hasher.digest());
}

std::string cache_key(const std::string& set_key, const Session& session, const Version& version) {
  Hasher hasher;
  hasher.add(set_key);
  hasher.add(read_file(session.model(version.id)));
  hasher.add(left_out_table(version.left_out));
  return to_hex(hasher.digest());
}

}  // namespace seam::tools
