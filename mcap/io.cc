#include "mcap/io.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "mcap/bytes.h"
#include "sim_core/base/error.h"

namespace seam::mcap {
namespace {

class FileOutput : public Output {
 public:
  FileOutput(const std::filesystem::path& path, const OutputRules& rules)
      : file_(path, rules), durable_(rules.durable) {}
  void write(std::string_view bytes) override { file_.write(bytes); }
  void sync() override {
    if (durable_) file_.sync();
  }
  void close() override { file_.commit(); }

 private:
  OutputFile file_;
  bool durable_;
};

class FileInput : public Input {
 public:
  FileInput(const std::filesystem::path& path) : name_(path.string()) {
    descriptor_ = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) fail(std::strerror(errno));
    if (!S_ISREG(status.st_mode)) fail("not a regular file");
    size_ = static_cast<uint64_t>(status.st_size);
  }
  ~FileInput() override {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  FileInput(const FileInput&) = delete;
  FileInput& operator=(const FileInput&) = delete;

  uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }

  std::string read(uint64_t offset, uint64_t size) const override {
    if (offset > size_ || size > size_ - offset) throw Malformed("a place beyond the file's end");
    std::string bytes(size, '\0');
    uint64_t done = 0;
    while (done < size) {
      const ssize_t got =
          ::pread(descriptor_, bytes.data() + done, size - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(std::strerror(errno));
      if (got == 0) fail("became shorter while it was read");
      done += static_cast<uint64_t>(got);
    }
    return bytes;
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw InputError(fmt::format("{}: cannot be read: {}", name_, what));
  }

  std::string name_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
};

}  // namespace

std::unique_ptr<Output> create_file(const std::filesystem::path& path, const OutputRules& rules) {
  return std::make_unique<FileOutput>(path, rules);
}

std::unique_ptr<Input> open_file(const std::filesystem::path& path) {
  return std::make_unique<FileInput>(path);
}

std::string MemoryInput::read(uint64_t offset, uint64_t size) const {
  if (offset > bytes_.size() || size > bytes_.size() - offset) {
    throw Malformed("a place beyond the file's end");
  }
  return bytes_.substr(offset, size);
}

}  // namespace seam::mcap
