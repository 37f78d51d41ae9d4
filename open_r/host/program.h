// A program of OPEN-R objects as one behaviour: the objects of a memory stick, connected, started,
// and driven turn by turn.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "open_r/files/settings.h"
#include "open_r/network/ip_stack.h"
#include "open_r/robot/virtual_robot.h"

namespace seam::open_r {

class Program {
 public:
  // The stick is a folder with OPEN-R/MW/CONF. Throws Fault where it is none.
  Program(const std::filesystem::path& stick, const std::string& design);

  // One turn; the first one starts the objects.
  TurnOrders turn(const sdk::Observation& seen);
  // DoStop of each object, then DoDestroy.
  void end();
  bool wants_images() const { return robot_->wants_images(); }

 private:
  void start(const sdk::Observation& seen);
  void tell_all(Selector entry, OReason reason);

  std::filesystem::path stick_;
  std::vector<Connection> connections_;
  System system_;
  IpStack network_{system_};
  std::unique_ptr<VirtualRobot> robot_;
  std::vector<OID> objects_;
  bool started_ = false, ended_ = false;
};

}  // namespace seam::open_r
