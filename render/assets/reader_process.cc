// Assimp in a process of its own: whatever a file makes of it, we go on.
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <fstream>

#include "render/assets/mesh_bytes.h"
#include "sim_core/input/shown_text.h"

namespace seam::render {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostMemory = uint64_t{1} << 30;  // Beyond what the process has already.

// Whole numbers of seconds, at least one.
rlim_t seconds_left(const AssetLimits& limits) {
  return static_cast<rlim_t>(std::max(1.0, std::ceil(limits.reader_seconds_left())));
}

rlim_t memory_now() {
  uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

std::string sent(const ReadMesh& mesh) {
  ByteWriter out;
  out.add(mesh.error);
  out.add(mesh.vertices), out.add(mesh.indices), out.add(mesh.parts);
  out.add(uint64_t{mesh.pictures.size()});
  for (const PictureSource& picture : mesh.pictures) out.add(picture.name), out.add(picture.bytes);
  for (const auto* names : {&mesh.files, &mesh.missed}) {
    out.add(uint64_t{names->size()});
    for (const std::string& name : *names) out.add(name);
  }
  return out.bytes();
}

ReadMesh received(std::string_view bytes) {
  ByteReader in(bytes);
  ReadMesh mesh;
  in.read(mesh.error);
  in.read(mesh.vertices), in.read(mesh.indices), in.read(mesh.parts);
  const auto count_of_names = [&] {
    constexpr uint64_t kMost = 10'000;
    const uint64_t count = in.number();
    if (count > kMost)
      throw InputError(fmt::format("it names {} files, expected at most {}", count, kMost));
    return count;
  };
  for (uint64_t left = count_of_names(); left > 0; --left) {
    PictureSource& picture = mesh.pictures.emplace_back();
    in.read(picture.name), in.read(picture.bytes);
  }
  for (auto* names : {&mesh.files, &mesh.missed})
    for (uint64_t left = count_of_names(); left > 0; --left) in.read(names->emplace_back());
  return mesh;
}

// In the reading process.
[[noreturn]] void read_and_exit(const fs::path& folder, const std::string& name,
                                const std::string& file, rlim_t seconds, int out) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlim_t bytes = memory_now() + kMostMemory;
  const rlimit memory{bytes, bytes};
  setrlimit(RLIMIT_AS, &memory);
#endif
  const rlimit time{seconds, seconds}, core{0, 0};
  setrlimit(RLIMIT_CPU, &time);
  setrlimit(RLIMIT_CORE, &core);
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL}) std::signal(number, SIG_DFL);
  try {
    ReadMesh mesh;
    try {
      mesh = import_mesh(folder, name, file);
    } catch (const std::bad_alloc&) {
      mesh = {};
      mesh.error = "it needs more memory than meshes may take, expected a smaller one";
    } catch (const std::exception& error) {
      mesh = {};
      mesh.error = error.what();
    }
    const std::string bytes = sent(mesh);
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t written = write(out, bytes.data() + at, bytes.size() - at);
      if (written <= 0) _exit(2);
      at += static_cast<size_t>(written);
    }
  } catch (...) {
    _exit(3);
  }
  _exit(0);
}

// What the process has written.
class Written {
 public:
  explicit Written(int file)
      : size_(static_cast<size_t>(std::max<off_t>(0, lseek(file, 0, SEEK_END)))) {
    if (size_ > 0) data_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    if (size_ == 0 || data_ == MAP_FAILED) throw InputError("its reader ended early");
  }
  ~Written() { munmap(data_, size_); }
  Written(const Written&) = delete;
  Written& operator=(const Written&) = delete;
  std::string_view bytes() const { return {static_cast<const char*>(data_), size_}; }

 private:
  size_t size_;
  void* data_ = nullptr;
};

struct Closed {
  int file;
  ~Closed() {
    if (file >= 0) close(file);
  }
};

}  // namespace

ReadMesh import_mesh_apart(const fs::path& folder, const std::string& name,
                           const std::string& bytes, AssetLimits& limits) {
  const rlim_t seconds = seconds_left(limits);
  const Closed shared{memfd_create("seam-mesh", MFD_CLOEXEC)};
  const pid_t reader = shared.file < 0 ? -1 : fork();
  if (reader < 0) throw InputError("no process can be started to read it");
  if (reader == 0) read_and_exit(folder, name, bytes, seconds, shared.file);
  int status = 0;
  rusage used{};
  while (wait4(reader, &status, 0, &used) < 0 && errno == EINTR) {
  }
  for (const timeval& part : {used.ru_utime, used.ru_stime})
    limits.take_reader_seconds(static_cast<double>(part.tv_sec) +
                               1e-6 * static_cast<double>(part.tv_usec));
  if (WIFSIGNALED(status))
    throw InputError(
        WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL
            ? fmt::format("not read within {} s, which all meshes of a scene may take together, "
                          "expected smaller ones",
                          AssetLimits::kMostReaderSeconds)
            : "not a readable mesh: its reader broke down on it");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw InputError("its reader ended early");
  ReadMesh mesh = received(Written(shared.file).bytes());
  if (!mesh.error.empty()) throw InputError("not a readable mesh: " + shown(mesh.error));
  return mesh;
}

}  // namespace seam::render
