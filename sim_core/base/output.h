// One way to make an output. A file is claimed before the work that fills it, so that a path which
// cannot be written is an error at once. A regular file is written beside its target and renamed
// when it is whole: a reader never sees half of it, and an error leaves nothing behind. A device or
// a FIFO is written through, a symbolic link leads to its target.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string_view>
#include <vector>

namespace seam {

struct OutputRules {
  // Files that are read meanwhile. An output that is one of them, by another name or a link too,
  // is refused with a UsageError before anything is opened.
  std::vector<std::filesystem::path> inputs;
  // A log grows in place: what was written survives the death of the process. Two writers at once
  // are refused, and a regular file that exists too, unless `overwrite`.
  bool grows = false;
  bool overwrite = true;
  // The file's content is on the disk when `commit` returns.
  bool synced = true;
  // With `grows`: the file's name is on the disk when it was claimed, its content with each `sync`.
  bool durable = false;
  mode_t mode = 0666;  // Of a new file, less the umask.
};

class OutputFile {
 public:
  OutputFile() = default;  // Nobody asked for one: `fill` does nothing.
  // Claims `path`; an empty path is none. Throws InputError where it cannot be written.
  explicit OutputFile(std::filesystem::path path, const OutputRules& rules = {});
  ~OutputFile();  // What was not committed is removed, of a growing file only where it is empty.
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;

  explicit operator bool() const { return !path_.empty(); }
  const std::filesystem::path& path() const { return path_; }

  // Throws InputError with the operating system's reason (disk full, ...); a regular file then ends
  // where it did before this call.
  void write(std::string_view bytes);
  // What was written is on the disk when it returns. Throws InputError where it is not.
  void sync();
  // Ends the file; throws InputError where the operating system could not keep what was written.
  void commit();
  // The whole content at once.
  void fill(std::string_view contents);

 private:
  void claim(const OutputRules& rules);
  void claim_growing(bool exists, const OutputRules& rules);
  void open_temporary();
  void sync_folder() const;
  void abandon() noexcept;
  void take_back(size_t bytes) noexcept;
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;       // As the user named it.
  std::filesystem::path target_;     // Behind symbolic links.
  std::filesystem::path temporary_;  // Beside the target, while it is written.
  int descriptor_ = -1;
  mode_t mode_ = 0;
  bool renamed_ = false;       // Made as a temporary, from the first byte on.
  bool keeps_rights_ = false;  // Of the file that is replaced, whatever the umask.
  bool synced_ = true;
  bool remove_if_empty_ = false;
  bool truncate_first_ = false;  // The old content stays until the first new byte.
};

// A file of a folder that a command fills: as OutputFile, but not waited for until it is on the
// disk.
void write_file_atomically(const std::filesystem::path& path, std::string_view contents);

// Makes the folder and those above it; throws InputError where it cannot be made or written to.
void make_output_folder(const std::filesystem::path& folder);

// Throws UsageError where `output` is one of `inputs`, by device and inode.
void refuse_same_file(const std::filesystem::path& output,
                      const std::vector<std::filesystem::path>& inputs);

}  // namespace seam
