// Behaviours that stand by between the runs of one process (robot_sdk/standby.h): a program is
// started for the first run and forks a client for each. Programs that know nothing of this are
// started for each run, as ever.
#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

#include "app/session/behaviours.h"

namespace seam::app {

class Standbys {
 public:
  Standbys() = default;
  ~Standbys();  // Those that stand by end.
  Standbys(const Standbys&) = delete;
  Standbys& operator=(const Standbys&) = delete;

  // The process that plays in this run: a new client of a program that stands by, or a program that
  // was started. Either is this process's child.
  pid_t start(const BehaviourProcess& process);
  // Programs that were found to stand by since they were started, each with its first client, who
  // plays in its place.
  std::map<pid_t, pid_t> take_first_clients();

 private:
  struct Standby {
    pid_t process = -1;
    int socket = -1;
    bool stands_by = false;  // It has announced its first client.
  };
  Standby open(const BehaviourProcess& process);
  static void end(const Standby& standby);

  std::map<std::vector<std::string>, Standby> by_command_;
};

}  // namespace seam::app
