#include "sim_core/signals/half_made.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <climits>
#include <csignal>
#include <cstring>
#include <string>

namespace seam {
namespace {

namespace fs = std::filesystem;

// What a signal removes. Signal handlers may neither allocate nor wait: the places are fixed, and
// who finds none is not removed. A place that the handler has taken stays taken, so that no path
// changes under its hands.
struct Slot {
  enum State { free, filling, set, taken };
  std::atomic<int> state = free;
  pid_t process = 0;
  char path[PATH_MAX] = {};
};
std::array<Slot, 64> half_made;

std::atomic<int> waits = 0;           // Objects of SignalsWait that live.
std::atomic<int> waiting_signal = 0;  // The last signal that came meanwhile, or 0.

// Removes what is in a folder. By the system's calls alone: readdir allocates.
void empty_folder(int folder, int depth) noexcept {
  constexpr int kDeepest = 16;
  alignas(dirent64) char entries[4096];
  for (bool removed = true; removed && depth < kDeepest;) {
    removed = false;
    ::lseek(folder, 0, SEEK_SET);
    for (long size = 0; (size = ::syscall(SYS_getdents64, folder, entries, sizeof entries)) > 0;) {
      for (long at = 0; at < size;) {
        const auto* entry = reinterpret_cast<const dirent64*>(entries + at);
        at += entry->d_reclen;
        const char* name = entry->d_name;
        if (std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0) continue;
        const int inner = ::openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        if (inner >= 0) {
          empty_folder(inner, depth + 1);
          ::close(inner);
        }
        if (::unlinkat(folder, name, inner >= 0 ? AT_REMOVEDIR : 0) == 0) removed = true;
      }
    }
  }
}

extern "C" void end_by_signal(int signal) {
  if (waits > 0) {
    waiting_signal = signal;
    // Who waited may have ended in between, and have seen no signal.
    if (waits > 0 || waiting_signal.exchange(0) == 0) return;
  }
  remove_half_made();
  // Blocked until this handler returns; acts then.
  std::signal(signal, SIG_DFL);
  ::raise(signal);
}

// Empty where it is not known; such a path is not removed.
std::string absolute_text(const fs::path& path) noexcept {
  try {
    std::string text = fs::absolute(path).string();
    return text.size() < PATH_MAX ? text : "";
  } catch (const std::exception&) {
    return "";
  }
}

}  // namespace

SignalsWait::SignalsWait() noexcept {
  ++waits;
}

SignalsWait::~SignalsWait() {
  if (--waits > 0) return;
  if (const int signal = waiting_signal.exchange(0); signal != 0) ::raise(signal);
}

void is_half_made(const fs::path& path) {
  const std::string text = absolute_text(path);
  if (text.empty()) return;
  for (Slot& slot : half_made) {
    int state = Slot::free;
    if (!slot.state.compare_exchange_strong(state, Slot::filling)) continue;
    std::memcpy(slot.path, text.c_str(), text.size() + 1);
    slot.process = ::getpid();
    slot.state = Slot::set;
    return;
  }
}

void is_made(const fs::path& path) noexcept {
  const std::string text = absolute_text(path);
  for (Slot& slot : half_made) {
    int state = Slot::set;
    // Taken while it is looked at: another thread may use it for another path.
    if (!slot.state.compare_exchange_strong(state, Slot::filling)) continue;
    const bool found = slot.process == ::getpid() && text == slot.path;
    slot.state = found ? Slot::free : Slot::set;
  }
}

void remove_half_made() noexcept {
  for (Slot& slot : half_made) {
    int state = Slot::set;
    if (!slot.state.compare_exchange_strong(state, Slot::taken)) continue;
    if (slot.process != ::getpid()) continue;
    const int folder = ::open(slot.path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) {
      ::unlink(slot.path);
      continue;
    }
    empty_folder(folder, 0);
    ::close(folder);
    ::rmdir(slot.path);
  }
}

void remove_half_made_on_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) != 0 || action.sa_handler != SIG_DFL) continue;
    action.sa_handler = end_by_signal;
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace seam
