// An archive of regular files that `tar xzf` unpacks, too: POSIX ustar in gzip. Equal files give
// equal bytes: no times, no owners. The reader takes what the writer writes and nothing else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "sim_core/base/output.h"

namespace seam::app {

inline constexpr size_t kTarBlock = 512;

// Why an archive cannot have a file of this name; empty where it can. A name leads down from the
// archive's folder and is shorter than ustar's fields.
std::string why_no_archive_name(const std::string& name);

class ArchiveWriter {
 public:
  explicit ArchiveWriter(OutputFile& out);
  ~ArchiveWriter();
  ArchiveWriter(const ArchiveWriter&) = delete;
  ArchiveWriter& operator=(const ArchiveWriter&) = delete;

  // Its content follows, exactly `bytes` in all.
  void begin(const std::string& name, uint64_t bytes, bool program);
  void write(std::string_view piece);
  void end();
  // The archive is whole; the caller commits the output.
  void finish();

 private:
  void deflate_more(std::string_view bytes, bool last);

  struct Stream;
  OutputFile& out_;
  std::unique_ptr<Stream> stream_;
  std::string name_;
  uint64_t declared_ = 0, written_ = 0;
};

class ArchiveReader {
 public:
  // Throws InputError where the file cannot be read or is no such archive.
  explicit ArchiveReader(const std::filesystem::path& file);
  ~ArchiveReader();
  ArchiveReader(const ArchiveReader&) = delete;
  ArchiveReader& operator=(const ArchiveReader&) = delete;

  struct Entry {
    std::string name;  // By why_no_archive_name.
    uint64_t bytes = 0;
    bool program = false;
  };
  // The next file; none at the end, after which nothing follows. Throws InputError for damage,
  // for what is cut off, and for entries that are no regular files.
  std::optional<Entry> next();
  // All of the entry's content, before the next call of `next`.
  void content(const std::function<void(std::string_view)>& take);

 private:
  [[noreturn]] void refuse(const std::string& why) const;
  // Fills the piece; false where the archive ends before its first byte.
  bool read(char* to, size_t bytes);
  void read_end(std::string_view first);

  struct Stream;
  std::filesystem::path file_;
  std::unique_ptr<Stream> stream_;
  uint64_t left_ = 0;  // Of the present entry's content.
};

}  // namespace seam::app
