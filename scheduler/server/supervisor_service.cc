// The supervisor's calls: each is checked, then served on the loop's thread.
#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>

#include "scheduler/server/services.h"
#include "scheduler/wire/token.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace seam::scheduler {

namespace {

constexpr int64_t kMaxStep_ns = int64_t{1'000'000} * 1'000'000'000;

class SupervisorService final : public v1::Supervisor::CallbackService {
 public:
  SupervisorService(const World& world, std::string token, ClientHub& hub, RunControl& control,
                    TokenTries& tries)
      : world_(world), token_(std::move(token)), hub_(hub), control_(control), tries_(tries) {}

  grpc::ServerUnaryReactor* GetStatus(grpc::CallbackServerContext* context,
                                      const v1::SupervisorRequest* request,
                                      v1::Status* reply) override {
    return serve(context, *request, [this, reply](bool) { fill(*reply); });
  }

  grpc::ServerUnaryReactor* GetGroundTruth(grpc::CallbackServerContext* context,
                                           const v1::SupervisorRequest* request,
                                           v1::GroundTruth* reply) override {
    return serve(
        context, *request,
        [this, reply](bool running) {
          if (running) fill(*reply);
        },
        true);
  }

  grpc::ServerUnaryReactor* Pause(grpc::CallbackServerContext* context,
                                  const v1::SupervisorRequest* request,
                                  v1::Status* reply) override {
    return serve(context, *request, [this, reply](bool) {
      control_.pause();
      fill(*reply);
    });
  }

  grpc::ServerUnaryReactor* Resume(grpc::CallbackServerContext* context,
                                   const v1::SupervisorRequest* request,
                                   v1::Status* reply) override {
    return serve(context, *request, [this, reply](bool) {
      control_.resume();
      fill(*reply);
    });
  }

  grpc::ServerUnaryReactor* Step(grpc::CallbackServerContext* context,
                                 const v1::StepRequest* request, v1::Status* reply) override {
    auto* reactor = context->DefaultReactor();
    if (!authorised(*context, request->token(), *reactor)) return reactor;
    if (request->duration_ns() < 1 || request->duration_ns() > kMaxStep_ns) {
      reactor->Finish({grpc::StatusCode::INVALID_ARGUMENT,
                       fmt::format("duration_ns: found {}, expected 1 to {}",
                                   request->duration_ns(), kMaxStep_ns)});
      return reactor;
    }
    if (!control_.paused()) {
      reactor->Finish({grpc::StatusCode::FAILED_PRECONDITION, "the run is not paused"});
      return reactor;
    }
    control_.step(SimDuration::from_ns(request->duration_ns()));
    control_.post_when_standing([this, reply, reactor](bool) {
      fill(*reply);
      reactor->Finish(grpc::Status::OK);
    });
    return reactor;
  }

  grpc::ServerUnaryReactor* Act(grpc::CallbackServerContext* context, const v1::ActRequest* request,
                                v1::Status* reply) override {
    auto* reactor = context->DefaultReactor();
    if (!authorised(*context, request->token(), *reactor)) return reactor;
    std::vector<std::string> robots;
    for (const RobotSpec& robot : world_.scenario().robots) robots.push_back(robot.id);
    std::vector<SupervisorAction> actions;
    if (request->actions_size() > WireLimits::kMaxSupervisorActions) {
      reactor->Finish({grpc::StatusCode::INVALID_ARGUMENT,
                       fmt::format("actions: found {}, expected at most {}",
                                   request->actions_size(), WireLimits::kMaxSupervisorActions)});
      return reactor;
    }
    for (const v1::SupervisorAction& wire : request->actions()) {
      const auto action = action_from_wire(wire, robots);
      if (const auto* bad = std::get_if<FieldError>(&action)) {
        reactor->Finish({grpc::StatusCode::INVALID_ARGUMENT, bad->field + ": " + bad->message});
        return reactor;
      }
      actions.push_back(std::get<SupervisorAction>(action));
    }
    hub_.act(std::move(actions));
    control_.post([this, reply, reactor](bool) {
      fill(*reply);
      reactor->Finish(grpc::Status::OK);
    });
    return reactor;
  }

  grpc::ServerUnaryReactor* Stop(grpc::CallbackServerContext* context,
                                 const v1::SupervisorRequest* request, v1::Status* reply) override {
    return serve(context, *request, [this, reply](bool) {
      control_.stop();
      fill(*reply);
    });
  }

 private:
  static constexpr const char* kTried = "supervisor";

  bool authorised(const grpc::CallbackServerContext& context, const std::string& token,
                  grpc::ServerUnaryReactor& reactor) const {
    const std::string peer = peer_of(context.peer());
    if (const double wait_s = tries_.wait_s(peer, kTried); wait_s > 0) {
      reactor.Finish({grpc::StatusCode::UNAVAILABLE, wait_text(wait_s)});
      return false;
    }
    if (!token_.empty() && same_token(token, token_)) return true;
    tries_.note_wrong(peer, kTried);
    reactor.Finish({grpc::StatusCode::UNAUTHENTICATED, "token: not the supervisor's token"});
    return false;
  }

  template <class Task>
  grpc::ServerUnaryReactor* serve(grpc::CallbackServerContext* context,
                                  const v1::SupervisorRequest& request, Task task,
                                  bool needs_running = false) {
    auto* reactor = context->DefaultReactor();
    if (!authorised(*context, request.token(), *reactor)) return reactor;
    control_.post([task, reactor, needs_running](bool running) {
      task(running);
      if (needs_running && !running)
        reactor->Finish({grpc::StatusCode::FAILED_PRECONDITION, "the run is over"});
      else
        reactor->Finish(grpc::Status::OK);
    });
    return reactor;
  }

  void fill(v1::Status& status) const {
    status.set_time_ns(control_.time().ns());
    status.set_paused(control_.paused());
    status.set_ended(control_.stop_requested());
    for (const HubRobotStatus& robot : hub_.status()) {
      v1::RobotStatus& out = *status.add_robots();
      out.set_robot(robot.id);
      out.set_connected(robot.connected);
      out.set_frozen(robot.frozen);
      out.set_owes_decision(robot.owes_decision);
      out.set_client(robot.client);
    }
    status.set_frames(control_.frames());
    status.set_decisions(hub_.decisions());
  }

  void fill(v1::GroundTruth& truth) const {
    const SimTime time = std::clamp(control_.time(), world_.start(), world_.end());
    truth.set_time_ns(time.ns());
    for (size_t i = 0; i < world_.scenario().robots.size(); ++i) {
      const RobotSpec& spec = world_.scenario().robots[i];
      const RobotTruth robot = world_.robot(i, time);
      v1::RobotTruth& out = *truth.add_robots();
      out.set_robot(spec.id);
      out.set_team(spec.team == Team::red ? "red" : "blue");
      out.mutable_body()->set_x_m(robot.pose.x_m);
      out.mutable_body()->set_y_m(robot.pose.y_m);
      out.mutable_body()->set_heading_rad(robot.pose.theta_rad);
      if (spec.body.tree.present()) {
        for (size_t j = 0; j < spec.body.joint_count(); ++j)
          out.add_joints_rad(robot.joints_rad[j]);
        continue;
      }
      out.set_tilt_rad(robot.joints_rad[kTilt]);
      out.set_pan_rad(robot.joints_rad[kPan]);
      out.set_roll_rad(robot.joints_rad[kRoll]);
    }
    const BallTruth ball = world_.ball(time);
    const auto set = [](const Vec3& from, v1::Vector3& to) {
      to.set_x(from.x);
      to.set_y(from.y);
      to.set_z(from.z);
    };
    set(ball.p_W, *truth.mutable_ball_position_m());
    set(ball.v_W, *truth.mutable_ball_velocity_m_s());
  }

  const World& world_;
  std::string token_;
  ClientHub& hub_;
  RunControl& control_;
  TokenTries& tries_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_supervisor_service(const World& world, std::string token,
                                                       ClientHub& hub, RunControl& control,
                                                       TokenTries& tries) {
  return std::make_unique<SupervisorService>(world, std::move(token), hub, control, tries);
}

}  // namespace seam::scheduler
