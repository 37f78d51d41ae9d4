// The one seam through which logs touch the operating system. The in-memory twins serve tests,
// fuzzers and fault injection.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "sim_core/base/output.h"

namespace seam::mcap {

// Where a log is written. Bytes that `write` took survive the death of the process.
class Output {
 public:
  virtual ~Output() = default;
  // Throws InputError with the reason of the operating system (disk full, ...).
  virtual void write(std::string_view bytes) = 0;
  // Where the output was asked to be durable: what was written survives a power cut when it
  // returns. Throws InputError.
  virtual void sync() {}
  // Nothing follows. Throws InputError where the operating system could not keep what it took.
  virtual void close() {}
};

// Random access to a log.
class Input {
 public:
  virtual ~Input() = default;
  virtual uint64_t size() const = 0;
  // Exactly `size` bytes from `offset`; throws Malformed where the file ends before, InputError
  // where the operating system fails.
  virtual std::string read(uint64_t offset, uint64_t size) const = 0;
  // How messages name it.
  virtual const std::string& name() const = 0;
};

// Each write reaches the operating system at once.
std::unique_ptr<Output> create_file(const std::filesystem::path& path, const OutputRules& rules);
// Throws InputError where the file cannot be opened or is no regular file.
std::unique_ptr<Input> open_file(const std::filesystem::path& path);

class MemoryOutput : public Output {
 public:
  void write(std::string_view bytes) override { bytes_.append(bytes); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class MemoryInput : public Input {
 public:
  explicit MemoryInput(std::string bytes, std::string name = "memory")
      : bytes_(std::move(bytes)), name_(std::move(name)) {}
  uint64_t size() const override { return bytes_.size(); }
  std::string read(uint64_t offset, uint64_t size) const override;
  const std::string& name() const override { return name_; }

 private:
  std::string bytes_;
  std::string name_;
};

}  // namespace seam::mcap
