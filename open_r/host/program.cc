#include "open_r/host/program.h"

#include <cstdio>

#include "open_r/files/settings.h"
#include "open_r/files/text_file.h"
#include "open_r/library/program_object.h"

namespace seam::open_r {

Program::Program(const std::filesystem::path& stick, const std::string& design) : stick_(stick) {
  const MemoryStick files(stick_);
  const std::filesystem::path objects = files.find("/MS/OPEN-R/MW/CONF/OBJECT.CFG");
  if (!std::filesystem::exists(objects))
    throw Fault(stick_.string() +
                ": no OPEN-R/MW/CONF/OBJECT.CFG, expected a memory stick as `seam open-r build` "
                "makes it");
  RobotOptions options{design, files, {}};
  // Most programs look for no file by a keyword.
  const std::filesystem::path data = files.find("/MS/OPEN-R/MW/CONF/DESIGNDB.CFG");
  if (std::filesystem::exists(data))
    options.design_data = read_design_data(read_text(data), design);
  connections_ = read_connections(read_text(files.find("/MS/OPEN-R/MW/CONF/CONNECT.CFG")), design);
  robot_ = std::make_unique<VirtualRobot>(system_, std::move(options));
  for (const std::string& name : read_object_settings(read_text(objects), design)) {
    const std::filesystem::path file = files.find(name);
    if (!std::filesystem::exists(file)) {
      std::printf("OBJECT.CFG: %s is not there: the run goes without it\n", name.c_str());
      continue;
    }
    objects_.push_back(load_object(system_, file.stem().string(), file));
  }
  if (objects_.empty()) throw Fault(stick_.string() + ": no object of OBJECT.CFG is there");
}

void Program::tell_all(Selector entry, OReason reason) {
  for (const OID& object : objects_)
    system_.post({object, entry}, std::make_shared<OReasonMessage>(reason));
  system_.deliver();
}

void Program::start(const sdk::Observation& seen) {
  started_ = true;
  robot_->look(seen);
  tell_all(oentryINIT, oreasonBOOT);
  for (const Connection& connection : connections_)
    system_.connect(connection.subject, connection.observer);
  // The robot's own objects are started first: they are ready when a program's objects start.
  robot_->start();
  tell_all(oentrySTART, oreasonBOOT);
}

TurnOrders Program::turn(const sdk::Observation& seen) {
  if (!started_) start(seen);
  if (ended_) return {};
  network_.poll();
  TurnOrders orders = robot_->turn(seen);
  if (robot_->is_over()) end();
  return orders;
}

void Program::end() {
  if (ended_ || !started_) return;
  ended_ = true;
  tell_all(oentrySTOP, oreasonSHUTDOWN);
  tell_all(oentryDESTROY, oreasonSHUTDOWN);
}

}  // namespace seam::open_r
