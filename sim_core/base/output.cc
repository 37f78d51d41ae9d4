#include "sim_core/base/output.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "sim_core/base/error.h"
#include "sim_core/signals/half_made.h"

namespace seam {
namespace {

namespace fs = std::filesystem;

// Where the links that end at a file lead, one after the other. A link below /proc (as /dev/stdout)
// stands for an open file and not for a name: it is left to the operating system.
fs::path behind_links(fs::path path) {
  for (int hops = 0; hops < 40; ++hops) {
    std::error_code error;
    if (!fs::is_symlink(path, error)) return path;
    const fs::path link = path.parent_path();
    if (fs::weakly_canonical(link.empty() ? "." : link).string().starts_with("/proc")) return path;
    path = link / fs::read_symlink(path);
  }
  throw InputError(fmt::format("{}: too many symbolic links", path.string()));
}

}  // namespace

void OutputFile::fail(int error) const {
  throw InputError(fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(error)));
}

OutputFile::OutputFile(fs::path path, const OutputRules& rules)
    : path_(std::move(path)), synced_(rules.synced) {
  if (path_.empty()) return;
  refuse_same_file(path_, rules.inputs);
  try {
    claim(rules);
  } catch (...) {
    abandon();
    throw;
  }
}

OutputFile::~OutputFile() {
  abandon();
}

OutputFile::OutputFile(OutputFile&& other) noexcept {
  *this = std::move(other);
}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(target_, other.target_);
  std::swap(temporary_, other.temporary_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(mode_, other.mode_);
  std::swap(renamed_, other.renamed_);
  std::swap(keeps_rights_, other.keeps_rights_);
  std::swap(synced_, other.synced_);
  std::swap(remove_if_empty_, other.remove_if_empty_);
  std::swap(truncate_first_, other.truncate_first_);
  return *this;
}

void OutputFile::claim(const OutputRules& rules) {
  struct stat status {};
  // The operating system follows links here, and refuses those that another user laid in a folder
  // that all may write to.
  const bool exists = ::stat(path_.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail(errno);
  if (exists && S_ISDIR(status.st_mode))
    throw InputError(fmt::format("{}: is a folder, expected a file", path_.string()));
  if (exists && (S_ISBLK(status.st_mode) || S_ISSOCK(status.st_mode)))
    throw InputError(fmt::format("{}: is a disk or a socket, expected a file", path_.string()));
  target_ = behind_links(path_);
  if (exists && (!S_ISREG(status.st_mode) || fs::is_symlink(target_))) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0) fail(errno);
    return;
  }
  if (exists && ::access(target_.c_str(), W_OK) != 0) fail(errno);
  if (rules.grows) return claim_growing(exists, rules);
  renamed_ = true;
  keeps_rights_ = exists;
  mode_ = exists ? status.st_mode & rules.mode : rules.mode;
  // Tried, and gone again until the first byte: a computation that is killed leaves nothing.
  open_temporary();
  abandon();
}

void OutputFile::open_temporary() {
  for (int attempt = 0; descriptor_ < 0; ++attempt) {
    temporary_ = target_;
    temporary_ += fmt::format(".{}-{}.part", ::getpid(), attempt);
    const SignalsWait wait;
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode_);
    if (descriptor_ >= 0) is_half_made(temporary_);
    if (descriptor_ >= 0) break;
    const int error = errno;
    temporary_.clear();
    if (error != EEXIST || attempt > 1000) fail(error);
  }
  if (keeps_rights_ && ::fchmod(descriptor_, mode_) != 0) fail(errno);
}

void OutputFile::claim_growing(bool exists, const OutputRules& rules) {
  const int create = exists ? 0 : O_CREAT | O_EXCL;
  descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC | create, rules.mode);
  if (descriptor_ < 0 && errno != EEXIST) fail(errno);
  if (descriptor_ < 0 || ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0)
    throw InputError(fmt::format("{}: another run is writing this file", path_.string()));
  if (exists && !rules.overwrite)
    throw InputError(fmt::format(
        "{}: exists already; give another name, or --force to overwrite it", path_.string()));
  remove_if_empty_ = !exists;
  truncate_first_ = exists;
  if (rules.durable) sync_folder();
}

// A file whose name is not on the disk is lost with all that was synced of it.
void OutputFile::sync_folder() const {
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int error = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) fail(error);
}

void OutputFile::sync() {
  // Devices and FIFOs cannot be synchronised, and say so.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP)
    fail(errno);
}

void OutputFile::write(std::string_view bytes) {
  if (descriptor_ < 0 && renamed_) open_temporary();
  SEAM_CHECK(descriptor_ >= 0, "{} is not open", path_.string());
  if (truncate_first_ && ::ftruncate(descriptor_, 0) != 0) fail(errno);
  truncate_first_ = false;
  if (!bytes.empty()) remove_if_empty_ = false;
  const size_t all = bytes.size();
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error = errno;
      take_back(all - bytes.size());
      fail(error);
    }
    bytes.remove_prefix(static_cast<size_t>(written));
  }
}

// On a full disk half a record would end a log that is whole up to there. What cannot be shortened
// (a FIFO) keeps it.
void OutputFile::take_back(size_t bytes) noexcept {
  const off_t end = ::lseek(descriptor_, 0, SEEK_CUR);
  if (end < 0 || bytes == 0) return;
  const off_t before = end - static_cast<off_t>(bytes);
  if (::ftruncate(descriptor_, before) == 0) ::lseek(descriptor_, before, SEEK_SET);
}

void OutputFile::commit() {
  write("");  // A file that stays empty is emptied too.
  remove_if_empty_ = false;
  if (synced_) sync();
  if (::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
  if (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
  if (!temporary_.empty()) is_made(temporary_);
  temporary_.clear();
  renamed_ = false;
}

void OutputFile::fill(std::string_view contents) {
  if (path_.empty()) return;
  write(contents);
  commit();
}

void OutputFile::abandon() noexcept {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  if (!temporary_.empty()) is_made(temporary_);
  if (remove_if_empty_) ::unlink(target_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
  temporary_.clear();
  remove_if_empty_ = false;
  descriptor_ = -1;
}

void write_file_atomically(const fs::path& path, std::string_view contents) {
  OutputFile(path, {.inputs = {}, .synced = false}).fill(contents);
}

void make_output_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && !fs::is_directory(folder)) error = std::make_error_code(std::errc::not_a_directory);
  if (error)
    throw InputError(
        fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw InputError(fmt::format("{}: no files can be written into this folder: {}",
                                 folder.string(), std::strerror(errno)));
}

void refuse_same_file(const fs::path& output, const std::vector<fs::path>& inputs) {
  struct stat ours {};
  if (output.empty() || ::stat(output.c_str(), &ours) != 0) return;
  for (const fs::path& input : inputs) {
    struct stat theirs {};
    if (input.empty() || ::stat(input.c_str(), &theirs) != 0) continue;
    if (ours.st_dev == theirs.st_dev && ours.st_ino == theirs.st_ino)
      throw UsageError(fmt::format("{}: the same file as {}, which is read; give another name",
                                   output.string(), input.string()));
  }
}

}  // namespace seam
