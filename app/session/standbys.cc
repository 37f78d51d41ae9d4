#include "app/session/standbys.h"

#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <optional>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr int kFork_ms =
    10'000;  // A busy machine's; without an answer the program is started anew.

bool is_our_child(pid_t process) {
  siginfo_t state{};
  return process > 0 &&
         waitid(P_PID, static_cast<id_t>(process), &state, WEXITED | WNOHANG | WNOWAIT) == 0;
}

// The client that a program announced.
std::optional<pid_t> client_told(int socket) {
  pid_t client = -1;
  if (recv(socket, &client, sizeof client, MSG_DONTWAIT) != sizeof client) return std::nullopt;
  if (!is_our_child(client)) return std::nullopt;
  return client;
}

// The environment of a run, and with it the descriptor that the client is to print to.
bool send_settings(int socket, const BehaviourProcess& process) {
  std::string settings;
  for (const auto& [name, value] : process.environment)
    settings.append(name + "=" + value).push_back('\0');
  iovec content{settings.data(), settings.size()};
  msghdr message{};
  message.msg_iov = &content, message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> beside{};
  if (process.output >= 0) {
    message.msg_control = beside.data(), message.msg_controllen = beside.size();
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET, header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &process.output, sizeof(int));
  }
  return sendmsg(socket, &message, MSG_NOSIGNAL) >= 0;
}

std::optional<pid_t> new_client(int socket, const BehaviourProcess& process) {
  if (!send_settings(socket, process)) return std::nullopt;
  pollfd waiting{socket, POLLIN, 0};
  if (poll(&waiting, 1, kFork_ms) != 1) return std::nullopt;
  return client_told(socket);
}

}  // namespace

Standbys::~Standbys() {
  for (const auto& [command, standby] : by_command_)
    if (standby.stands_by) end(standby);
}

// A program that does not stand by yet is a behaviour like any other, and ended as such.
void Standbys::end(const Standby& standby) {
  close(standby.socket);
  kill(standby.process, SIGKILL);
  waitpid(standby.process, nullptr, 0);
}

Standbys::Standby Standbys::open(const BehaviourProcess& process) {
  // Clients are grandchildren, and are to fall to this process.
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    throw InputError(fmt::format("robot '{}': no sockets for its behaviour", process.robot));
  BehaviourProcess asked = process;
  asked.environment["SEAM_STANDBY"] = std::to_string(ends[1]);
  const pid_t started = start_program(asked, ends[1]);
  close(ends[1]);
  return {started, ends[0]};
}

pid_t Standbys::start(const BehaviourProcess& process) {
  const auto found = by_command_.find(process.command);
  if (found != by_command_.end() && !found->second.stands_by) return start_program(process);
  if (found != by_command_.end()) {
    if (const auto client = new_client(found->second.socket, process)) return *client;
    end(found->second);
    by_command_.erase(found);
  }
  return by_command_.emplace(process.command, open(process)).first->second.process;
}

std::map<pid_t, pid_t> Standbys::take_first_clients() {
  std::map<pid_t, pid_t> clients;
  for (auto& [command, standby] : by_command_) {
    if (standby.stands_by) continue;
    const auto client = client_told(standby.socket);
    if (!client) continue;
    standby.stands_by = true;
    clients[standby.process] = *client;
  }
  return clients;
}

}  // namespace seam::app
