// Whatever a client sends, it is a valid decision or refused with the field named; whatever stands
// in a log's turn, it is a valid turn or an InputError. What is accepted survives the way back.
#include "scheduler/wire/wire.h"

#include <google/protobuf/stubs/logging.h>

#include <cstdlib>

#include "seam/v1/simulation.pb.h"
#include "sim_core/base/error.h"
#include "sim_core/body/command.h"

using namespace seam;

// Protocol Buffers would complain of every second input.
static const bool kQuiet = (google::protobuf::SetLogHandler(nullptr), true);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  v1::ClientMessage message;
  if (message.ParseFromArray(data, static_cast<int>(size)) && message.has_decision()) {
    const auto decision = scheduler::decision_from_wire(message.decision(), 1024);
    if (const auto* good = std::get_if<scheduler::Decision>(&decision)) {
      if (invalid_field(good->command)) std::abort();
      v1::Decision again;
      scheduler::decision_to_wire(*good, 1, again);
      if (std::holds_alternative<scheduler::FieldError>(
              scheduler::decision_from_wire(again, 1024))) {
        std::abort();
      }
    } else if (std::get<scheduler::FieldError>(decision).field.empty()) {
      std::abort();
    }
  }
  v1::ActRequest request;
  const std::vector<std::string> robots = {"red1", "blue1"};
  if (request.ParseFromArray(data, static_cast<int>(size))) {
    for (const v1::SupervisorAction& action : request.actions()) {
      scheduler::action_from_wire(action, robots);
    }
  }
  try {
    scheduler::decode_turn({reinterpret_cast<const char*>(data), size}, robots);
  } catch (const InputError&) {
  }
  return 0;
}
