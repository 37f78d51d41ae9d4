// Whatever stands inside a log's attachment and in the names and texts of its header: reading,
// comparing, verifying and recovering end in results or InputErrors, names that come through can
// name files, and an attachment that differs from the header is noticed. The input has parts, with
// a zero byte between them: the attachment's name and data, the header's scenario and its name, the
// robots' names.
#include <google/protobuf/stubs/logging.h>

#include "scheduler/log/log_recovery.h"
#include "scheduler/replay/log_diff.h"
#include "scheduler/replay/log_testing.h"
#include "seam/v1/log.pb.h"
#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"

using namespace seam;
using namespace seam::scheduler;

namespace {

struct Match {
  std::string yaml = scheduler::testing::scenario_text(SEAM_SOURCE_DIR, 2, 0.1);
  std::string bytes = scheduler::testing::record(yaml, {.pictures = true}).bytes;
};

struct Parts {
  explicit Parts(std::string_view input) {
    for (std::string* part : {&attachment, &data, &text, &name}) *part = next(input);
    while (!input.empty()) robots.push_back(next(input));
  }
  static std::string next(std::string_view& input) {
    const size_t end = std::min(input.find('\0'), input.size());
    std::string part(input.substr(0, end));
    input.remove_prefix(std::min(end + 1, input.size()));
    return part;
  }
  std::string attachment, data, text, name;
  std::vector<std::string> robots;
};

// The recorded match with these texts; an empty one stays as it was.
std::string forged(const Match& match, const Parts& parts) {
  const auto header = [&](scheduler::testing::CopiedMessage& message) {
    if (message.topic != "/seam/header") return true;
    v1::LogHeader changed;
    changed.ParseFromString(message.data);
    if (!parts.text.empty()) changed.set_scenario_text(parts.text);
    if (!parts.name.empty()) changed.set_scenario_name(parts.name);
    if (!parts.robots.empty()) changed.clear_robots();
    for (const std::string& robot : parts.robots) changed.add_robots(robot);
    message.data = changed.SerializeAsString();
    return true;
  };
  const auto attachment = [&](mcap::Attachment& changed) {
    if (!parts.attachment.empty()) changed.name = parts.attachment;
    if (!parts.data.empty()) changed.data = parts.data;
    return true;
  };
  return scheduler::testing::edited(match.bytes, {.message = header, .attachment = attachment});
}

template <typename Action>
void attempt(Action action) {
  try {
    action();
  } catch (const InputError&) {
  }
}

void look_at(const Log& log) {
  for (const std::string& robot : log.header().robots)
    SEAM_CHECK(robot.find('/') == std::string::npos &&
                   why_not_inside("/tmp/folder", robot + "_000000.png").empty(),
               "'{}' names no file", robot);
  LogCursor cursor(log, kAllTopics);
  while (const auto record = cursor.next())
    if (const auto* frame = std::get_if<FrameRecord>(&*record)) log.picture(*frame);
}

void check_verdict(const Log& log, const Parts& parts) {
  const Verification result = scheduler::testing::verify(log, false);
  const bool is_ours = parts.attachment.empty() || parts.attachment == "scenario.yaml";
  const bool differs = !parts.data.empty() && parts.data != log.header().scenario_text;
  SEAM_CHECK(!is_ours || !differs || result.divergence, "another attachment was not noticed");
  SEAM_CHECK(is_ours || result.divergence || !result.not_compared.empty(),
             "an attachment of another name was not reported");
}

}  // namespace

// Protocol Buffers would complain of every second input.
static const bool kQuiet = (google::protobuf::SetLogHandler(nullptr), true);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Match match;
  const Parts parts({reinterpret_cast<const char*>(data), size});
  const std::string bytes = forged(match, parts);
  const auto open = [&] {
    return Log::open(std::make_unique<mcap::MemoryInput>(bytes), LogAccess::scanned);
  };
  attempt([&] {
    const Log log = open();
    attempt([&] { look_at(log); });
    attempt([&] { compare_logs(log, scheduler::testing::log_of(match.bytes)); });
    attempt([&] { check_verdict(log, parts); });
  });
  attempt([&] {
    mcap::MemoryOutput output;
    recover_log(std::make_unique<mcap::MemoryInput>(bytes), output);
  });
  return 0;
}
