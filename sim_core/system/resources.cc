#include "sim_core/system/resources.h"

#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <vector>

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

namespace seam {
namespace {

void require_files(int wanted) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < limit.rlim_max) {
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
  std::vector<int> opened;
  for (int i = 0; i < wanted; ++i) {
    const int descriptor = ::eventfd(0, EFD_CLOEXEC);
    if (descriptor < 0) break;
    opened.push_back(descriptor);
  }
  for (const int descriptor : opened) ::close(descriptor);
  if (opened.size() < static_cast<size_t>(wanted))
    throw InputError(
        fmt::format("too few file descriptors: {} more can be had, expected {}; raise the limit "
                    "(ulimit -n)",
                    opened.size(), wanted));
}

// Each thread of a library takes address space for its stack and for memory of its own.
void require_addresses() {
  constexpr size_t kBytes = size_t{512} << 20;
  void* place =
      ::mmap(nullptr, kBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED)
    throw InputError(
        fmt::format("too little memory: {} MiB of addresses cannot be had; raise the limit "
                    "(ulimit -v)",
                    kBytes >> 20));
  ::munmap(place, kBytes);
}

// All at once, as they will be needed: a thread that has ended gives its memory back.
void require_threads(int wanted) {
  std::atomic<bool> ending = false;
  std::vector<std::jthread> threads;
  std::string refused;
  try {
    for (int i = 0; i < wanted; ++i)
      threads.push_back(start_thread([&ending] { ending.wait(false); }));
  } catch (const InputError& error) {
    refused = error.what();
  }
  ending = true;
  ending.notify_all();
  const size_t started = threads.size();
  threads.clear();  // Joins them.
  if (!refused.empty())
    throw InputError(
        fmt::format("{}: {} more can run, expected {}; raise the limit of threads or of memory "
                    "(ulimit -u, ulimit -v)",
                    refused, started, wanted));
}

}  // namespace

void require_resources(int threads, int files) {
  require_files(files);
  require_addresses();
  require_threads(threads);
}

}  // namespace seam
