#include "tools/program.h"

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/signals/half_made.h"
#include "tools/command.h"
#include "tools/work_lines.h"

namespace seam::tools {
namespace {

void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // The lowest free descriptor: this one.
    if (open("/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY) != stream)
      throw InputError("/dev/null cannot be opened for a standard stream that is closed");
  }
}

int finish_output(const std::string& name, int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  std::fprintf(stderr, "%s: standard output cannot be written: %s\n", name.c_str(),
               std::strerror(errno));
  return code == 0 ? 1 : code;
}

// Predictions of a set, and frames, take and free the same megabytes thousands of times. By default
// the C library gives them back to the system each time, which clears them anew: a tenth of a
// search's time (docs/evidence/photometry.md).
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kMebibyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 64 * kMebibyte);
  mallopt(M_TRIM_THRESHOLD, 256 * kMebibyte);
  mallopt(M_TOP_PAD, 64 * kMebibyte);
#endif
}

}  // namespace

int run_program(const std::string& name, const std::function<int()>& work) {
  keep_freed_memory();
  remove_half_made_on_signals();
  try {
    open_standard_streams();
    const WorkLines lines;
    return finish_output(name, work());
  } catch (const ExitCode& exit) {
    return finish_output(name, exit.code);
  } catch (const UsageError& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), shown_lines(error.what()).c_str());
    return 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: there is not enough memory (or a limit of it, ulimit -v)\n",
                 name.c_str());
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), shown_lines(error.what()).c_str());
    return 1;
  }
}

}  // namespace seam::tools
