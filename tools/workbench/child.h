// A command of this program in a process of its own, which can be ended at any moment: what the
// page asks of the engine runs so. It says how far it is (tools/work_lines.h).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace seam::tools {

class Child {
 public:
  struct Ended {
    int code = 0;        // As a shell has it; 137 of one that was killed.
    std::string errors;  // What it wrote to standard error, its end alone where it is long.
    bool stopped = false;

    // What it said is wrong, without the program's name before it.
    std::string trouble() const;
  };
  using Line = std::function<void(std::string_view)>;

  // Runs `seam ARGUMENTS` in this folder and waits for its end; each line of its standard output
  // goes to `line`; what that throws ends the process. One at a time. Throws InputError where none
  // can be started.
  Ended run(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
            const Line& line = {});
  // Ends it, if one runs, and refuses others until `allow`.
  void stop();
  void allow();

 private:
  void start(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
             int output, int errors);
  Ended reap(std::string errors);

  std::mutex mutex_;
  pid_t process_ = 0;
  bool stopped_ = false;
};

}  // namespace seam::tools
