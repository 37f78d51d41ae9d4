// The C++ client of a SEAM server: a robot's behaviour drives its robot through this. It depends on
// the wire alone (proto/), so a behaviour needs nothing else of SEAM.
//
//   seam::sdk::Robot robot(argc, argv);
//   robot.request_all_frames();
//   robot.on_observation([&](const seam::sdk::Observation& seen) {
//     robot.head({.pan_rad = 0.5 * std::sin(seen.time_s())});
//   });
//   return robot.run();
//
// Units: metres, radians, seconds; simulated time in integer nanoseconds. Body frame: x forward,
// y left, z up. Pan turns left, tilt looks up. Pixel (0, 0) is the centre of the top-left pixel.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace seam::sdk {

struct Vector3d {
  double x = 0, y = 0, z = 0;
};

struct JointAngles {
  int64_t time_ns = 0;  // When the encoders were read.
  double tilt_rad = 0, pan_rad = 0, roll_rad = 0;
  std::vector<double> legs_rad;  // 12: LF, RF, LR, RR, each rotator, elevator, knee.
  // Of each joint in the order of Robot::joint_names(), whatever the robot; one that is no ERS-210
  // has nothing in the fields above. Of a sliding joint m.
  std::vector<double> angles_rad;
};

struct Odometry {
  double x_m = 0, y_m = 0, heading_rad = 0;  // Since the start, in the frame of the start; drifts.
};

struct Sensors {
  JointAngles joints;
  std::vector<JointAngles> joint_log;  // All encoder readings since the last observation.
  Vector3d acceleration_m_s2;          // In the body's frame, gravity included.
  std::optional<Vector3d> angular_velocity_rad_s;  // As its gyroscope reads; none: it has none.
  Odometry odometry;
  std::array<bool, 4> paw_contact{};  // Left front, right front, left rear, right rear.
};

// A camera image. Row v collected light from row_start_ns[v] to row_end_ns[v].
struct Frame {
  uint64_t index = 0;
  int64_t stamp_ns = 0;
  int width_px = 0, height_px = 0;
  std::string rgb;      // Row-major, interleaved.
  std::string ycrcb;    // The same as Y, Cr, Cb.
  std::string colours;  // The colour detection table's output, one bit a channel; may be empty.
  int colours_width_px = 0, colours_height_px = 0;
  std::vector<int64_t> row_start_ns;
  std::vector<int64_t> row_end_ns;

  uint8_t red(int u, int v) const { return byte(rgb, u, v, 0); }
  uint8_t green(int u, int v) const { return byte(rgb, u, v, 1); }
  uint8_t blue(int u, int v) const { return byte(rgb, u, v, 2); }
  int64_t row_middle_ns(int v) const {
    return row_start_ns[v] + (row_end_ns[v] - row_start_ns[v]) / 2;
  }

 private:
  uint8_t byte(const std::string& image, int u, int v, int channel) const {
    return static_cast<uint8_t>(image[(static_cast<size_t>(v) * width_px + u) * 3 + channel]);
  }
};

struct RadioMessage {
  std::string from;
  int64_t sent_ns = 0;
  int64_t arrived_ns = 0;
  std::string payload;
};

struct Game {
  enum State { initial, ready, set, playing, finished };
  State state = initial;
  bool first_half = true;
  std::string kick_off_team;
  int own_score = 0, opponent_score = 0;
  int64_t remaining_ns = 0;
  int penalty = 0;  // 0: none.
  int64_t penalty_remaining_ns = 0;
};

struct Observation {
  uint64_t sequence = 0;
  int64_t time_ns = 0;
  Sensors sensors;
  std::vector<Frame> frames;
  std::vector<RadioMessage> messages;
  Game game;

  double time_s() const { return static_cast<double>(time_ns) * 1e-9; }
};

struct Head {
  double tilt_rad = 0, pan_rad = 0, roll_rad = 0;
  double max_speed_rad_s = 0;  // 0: as fast as the servo goes.
};

// Numbers of an ERS-210's joints; each leg has a rotator, an elevator and a knee.
enum Joint { kTilt, kPan, kRoll, kLeftFront = 3, kRightFront = 6, kLeftHind = 9, kRightHind = 12 };

struct JointTarget {
  int joint = 0;
  double angle_rad = 0;
  double max_speed_rad_s = 0;  // 0: as fast as the servo goes.
};

struct Walk {
  double vx_m_s = 0, vy_m_s = 0, omega_rad_s = 0;
};

// `grab` holds a ball between the front legs until a kick or `release`.
enum class Kick { none, leg_forward, leg_left, leg_right, head_left, head_right, grab, release };

// A decision or a hello that the server refused.
struct Refusal {
  std::string field;
  std::string message;
};

struct Connection {
  std::string address;  // "unix:/path", "host:port".
  std::string robot;
  std::string token;
  // A directory with ca.pem, client.pem and client.key (as `seam certs` makes it): TLS. Empty:
  // plain, which the server accepts on a Unix socket or loopback only.
  std::string certificates;
  double give_up_s = 60;  // Wall time for connecting, and for reconnecting after a lost connection.
  // A Unix socket of the same server for direct lines (proto/line.h), which make quicker turns than
  // gRPC does; empty: none.
  std::string line;

  // From --address, --robot, --token, --certs, or else the environment SEAM_ADDRESS, SEAM_ROBOT,
  // SEAM_TOKEN, SEAM_CERTS (as `seam run` sets it). SEAM_LINE counts where no --address is given.
  // Other arguments are left alone.
  static Connection from(int argc, char** argv);
};

class Robot {
 public:
  Robot(int argc, char** argv) : Robot(Connection::from(argc, argv)) {}
  explicit Robot(Connection connection);
  ~Robot();
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  // ---- Known once run() has connected ----
  const std::string& name() const;
  const std::string& team() const;
  int number() const;
  double decision_latency_s() const;
  // By number, as JointTarget and JointAngles::angles_rad count.
  const std::vector<std::string>& joint_names() const;
  // The number of the joint of this name; throws std::invalid_argument that lists the known ones.
  int joint(std::string_view name) const;

  // Called for each observation. What the handler orders through the calls below is the decision
  // that answers it; what it does not order stays as it was.
  void on_observation(std::function<void(const Observation&)> handler);
  // Something that this client sent was refused; by default it is printed on stderr.
  void on_refusal(std::function<void(const Refusal&)> handler);

  // Drives the robot until the run is over (0), or the server cannot be reached or refuses the
  // client (1). A lost connection is made again with the token, and goes on at the pending
  // observation.
  int run();

  // ---- Orders, for the handler (before run(): part of the first decision) ----
  void head(const Head& target);
  void walk(const Walk& velocity);
  void stop() { walk({}); }
  void kick(Kick kind);
  // Joint targets, this long after the decision acts (several calls make several frames, in
  // ascending order). Leg targets replace the gait until the next walk().
  void joints(const std::vector<JointTarget>& targets, int64_t offset_ns = 0);
  void request_frame(int64_t after_ns = 0);  // The next whose stamp is not before this time.
  void request_frames(int count);
  void request_all_frames();
  void request_no_frames();
  void send(std::string_view payload);  // To team mates.

  // ---- For the log and the viewer ----
  void log_value(std::string_view name, double value);
  void log_text(std::string_view name, std::string_view text);
  // x, y pairs on the field (metres, world frame) or in the image (pixels), joined by a line. A
  // drawing in the image belongs to the newest frame that this robot was sent, or to `frame_index`.
  void log_drawing(std::string_view name, const std::vector<double>& xy, bool in_image = false,
                   std::optional<uint64_t> frame_index = std::nullopt);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seam::sdk
