// Files and folders that are only half made, which a signal that ends this process removes.
#pragma once

#include <filesystem>
#include <utility>

namespace seam {

// SIGINT, SIGTERM, SIGHUP and SIGPIPE remove what is half made, then act as ever. For a program's
// start; a signal that is ignored or waited for stays so.
void remove_half_made_on_signals();
// The same removal for who ends the process by itself. Async-signal-safe.
void remove_half_made() noexcept;

// From now on the file, or the folder with what it holds, counts as half made; until `is_made`. A
// process that is forked from this one leaves it alone.
void is_half_made(const std::filesystem::path& path);
void is_made(const std::filesystem::path& path) noexcept;

// While one lives, a signal that would end this process waits. Between making a file under a name
// that is free and `is_half_made`, nobody would remove it.
class SignalsWait {
 public:
  SignalsWait() noexcept;
  ~SignalsWait();
  SignalsWait(const SignalsWait&) = delete;
  SignalsWait& operator=(const SignalsWait&) = delete;
};

// Half made as long as this object lives. To be constructed before the file is made.
class HalfMade {
 public:
  explicit HalfMade(std::filesystem::path path) : path_(std::move(path)) { is_half_made(path_); }
  ~HalfMade() { is_made(path_); }
  HalfMade(const HalfMade&) = delete;
  HalfMade& operator=(const HalfMade&) = delete;

 private:
  std::filesystem::path path_;
};

}  // namespace seam
