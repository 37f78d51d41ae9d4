// The robot that OPEN-R programs drive: OVirtualRobotComm and OVirtualRobotAudioComm over the SDK.
// Each turn of the simulator is a frame of 8 ms.
#pragma once

#include <OPENR/OPENRAPI.h>

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "open_r/files/memory_stick.h"
#include "open_r/library/system.h"
#include "open_r/robot/image_vector.h"
#include "open_r/robot/joint_board.h"
#include "open_r/robot/output_queue.h"
#include "open_r/robot/sensor_history.h"
#include "open_r/robot/vector_memory.h"

namespace seam::open_r {

struct RobotOptions {
  std::string design = "ERS-210";
  MemoryStick stick{"."};
  std::map<std::string, std::string> design_data;  // Of DESIGNDB.CFG.
};

// What one turn orders and notes.
struct TurnOrders {
  JointBoard::Orders joints;
  std::map<std::string, double> values;  // For the log: LEDs and ears that changed.
  std::vector<std::string> warnings;
};

class VirtualRobot {
 public:
  // That which OPENR::'s functions mean, the newest one of this process.
  static VirtualRobot& current();

  VirtualRobot(System& system, RobotOptions options);
  ~VirtualRobot();
  VirtualRobot(const VirtualRobot&) = delete;
  VirtualRobot& operator=(const VirtualRobot&) = delete;

  // Before the objects are started: what is measured now.
  void look(const sdk::Observation& seen);
  // Its own objects are ready for commands.
  void start();
  // One turn: frames that have passed, messages, orders. Throws Fault where the time is no frame's.
  TurnOrders turn(const sdk::Observation& seen);

  bool wants_images() const { return image_.NumberOfObservers() > 0; }
  bool is_over() const { return over_; }

  // ---- For OPENR:: ----
  System& system() { return system_; }
  const RobotDesign& design() const { return design_; }
  const RobotOptions& options() const { return options_; }
  JointBoard& joints() { return joints_; }
  const sdk::Sensors& sensors() const { return sensors_; }
  SyncKeys& keys() { return keys_; }
  VectorMemory& memory() { return memory_; }
  ColourTable& colours() { return colours_; }
  std::set<int>& opened() { return opened_; }
  void shut_down() { over_ = true; }

  // Battery, clock, volume.
  struct Watch {
    OPowerStatus changes;
    OServiceEntry entry;
  };
  OPowerStatus power_status() const;
  std::vector<Watch>& watches() { return watches_; }
  // Reports what differs from the status before to those who watch.
  void report_power(const OPowerStatus& before);
  int64_t clock_shift_s = 0;
  sbyte time_difference = 0;
  OVolumeSwitch volume = ovolumeSW3;
  OSpeakerSoundType sound_type = ospksndMONO8K8B;
  CameraSettings camera_settings;
  std::map<ODesignDataID, std::string> loaded_files;

 private:
  void handle_comm(Selector selector, void* message);
  void handle_audio(Selector selector, void* message);
  void frame(int64_t number, const std::vector<sdk::Frame>& images);
  void put_command(RCRegion& region, int64_t index, int64_t first);
  void put_light(int primitive, const std::string& name, double value);
  void send_image(const sdk::Frame& frame);
  void send_microphone();

  System& system_;
  RobotOptions options_;
  const RobotDesign& design_;
  JointBoard joints_;
  SyncKeys keys_;
  VectorMemory memory_;
  ColourTable colours_;
  SensorHistory history_;
  OutputQueue commands_, sounds_;
  OID comm_, audio_;
  OObserver effector_, speaker_;
  OSubject sensor_, image_, microphone_;
  sdk::Sensors sensors_;
  std::set<int> opened_;
  std::vector<Watch> watches_;
  std::map<int, double> lights_;
  TurnOrders orders_;
  int64_t first_frame_ = -1, last_frame_ = -1;
  word image_counter_ = 0;
  bool over_ = false;
  VirtualRobot* before_;
};

}  // namespace seam::open_r
