// Calls of the C library as objects see them: paths below /MS/ are the memory stick's, and time is
// the robot's. The linker hands such calls of an object to these (programs/compiler.cc).
#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <ctime>

#include "open_r/robot/virtual_robot.h"

namespace {

std::string on_stick(const char* path) {
  return seam::open_r::VirtualRobot::current().options().stick.find(path).string();
}

}  // namespace

extern "C" {

FILE* __wrap_fopen(const char* path, const char* mode) {
  return std::fopen(on_stick(path).c_str(), mode);
}

FILE* __wrap_freopen(const char* path, const char* mode, FILE* file) {
  return std::freopen(on_stick(path).c_str(), mode, file);
}

int __wrap_open(const char* path, int flags, ...) {
  // The stick knows no rights.
  return open(on_stick(path).c_str(), flags, 0666);
}

int __wrap_stat(const char* path, struct stat* result) {
  return stat(on_stick(path).c_str(), result);
}

int __wrap_access(const char* path, int mode) {
  return access(on_stick(path).c_str(), mode);
}

DIR* __wrap_opendir(const char* path) {
  return opendir(on_stick(path).c_str());
}

int __wrap_mkdir(const char* path, mode_t) {
  return mkdir(on_stick(path).c_str(), 0777);
}

int __wrap_rmdir(const char* path) {
  return rmdir(on_stick(path).c_str());
}

int __wrap_unlink(const char* path) {
  return unlink(on_stick(path).c_str());
}

int __wrap_remove(const char* path) {
  return std::remove(on_stick(path).c_str());
}

int __wrap_rename(const char* from, const char* to) {
  return std::rename(on_stick(from).c_str(), on_stick(to).c_str());
}

// Seconds since 1970 of a robot whose clock begins with the year 2000.
time_t __wrap_time(time_t* result) {
  constexpr time_t kYear2000 = 946'684'800;
  const time_t now =
      kYear2000 + static_cast<time_t>(seam::open_r::System::current().now_ns() / 1'000'000'000);
  if (result != nullptr) *result = now;
  return now;
}

int __wrap_gettimeofday(struct timeval* result, void*) {
  result->tv_sec = __wrap_time(nullptr);
  result->tv_usec =
      static_cast<suseconds_t>(seam::open_r::System::current().now_ns() % 1'000'000'000 / 1000);
  return 0;
}

clock_t __wrap_clock() {
  return static_cast<clock_t>(seam::open_r::System::current().now_ns() / 1000);
}

}  // extern "C"
