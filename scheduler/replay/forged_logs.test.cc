// Flip and forge: each field of each message of a log is changed alone, and `verify` notices.
#include <gmock/gmock.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <map>

#include "scheduler/replay/log_testing.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using ::testing::HasSubstr;
using namespace seam::scheduler::testing;

// Decides all that can be decided, now and then with a supervisor, a frozen robot and faults.
class BusySource final : public DecisionSource {
 public:
  std::optional<Turn> decide(
      SimTime now, std::span<const std::shared_ptr<const Observation>> observations) override {
    Turn turn;
    for (const auto& seen : observations) {
      const bool is_frozen = seen->robot == 1 && seen->sequence == 6;
      Answer answer{seen->robot, seen->sequence};
      if (is_frozen) {
        answer.outcome = Outcome::frozen;
        answer.reason = "it did not answer";
      } else {
        answer.decision = decision(*seen);
        if (seen->robot == 1 && seen->sequence == 7) answer.outcome = Outcome::resumed;
      }
      turn.answers.push_back(std::move(answer));
      if (seen->robot == 0 && seen->sequence == 3) turn.actions = actions();
      if (seen->robot == 0 && seen->sequence == 4) {
        faults_.push_back({now, EventKind::fault, "r0", "refused", "walk.vx_m_s: found nan"});
      }
    }
    return turn;
  }
  std::vector<SimulationEvent> take_faults() override { return std::exchange(faults_, {}); }

 private:
  static Decision decision(const Observation& seen) {
    Decision decision = busy_behaviour(seen);
    decision.command.walk = BodyVelocity{0.1, 0.02, 0.3};
    if (seen.sequence == 5) decision.command.kick = Kick::leg_forward;
    if (seen.sequence % 4 == 0) decision.messages = {"a message"};
    decision.frame_requests = {
        {.which = FrameRequest::Which::next, .count = 2, .after = SimTime::from_s(0.1)}};
    decision.debug = {{.kind = DebugItem::Kind::value, .name = "x_m", .value = 0.5},
                      {.kind = DebugItem::Kind::text, .name = "role", .text = "striker"},
                      {.kind = DebugItem::Kind::drawing,
                       .name = "ball",
                       .points = {1, 2, 3, 4},
                       .in_image = true}};
    return decision;
  }
  static std::vector<SupervisorAction> actions() {
    using Kind = SupervisorAction::Kind;
    return {{.kind = Kind::place_ball, .position_m = {0.2, 0.1, 0}, .velocity_m_s = {0.1, 0.2, 0}},
            {.kind = Kind::place_robot, .robot = 1, .position_m = {1, 0.5, 0}, .heading_rad = 1},
            {.kind = Kind::set_game_state, .game_state = 3}};
  }
  std::vector<SimulationEvent> faults_;
};

const std::string& whole_log() {
  static const std::string bytes = [] {
    BusySource source;
    return record(scenario_text(SEAM_SOURCE_DIR, 2, 0.6), source,
                  {.snapshot_period = SimDuration::from_ns(200'000'000),
                   .pictures = true,
                   .transforms = true,
                   .scene = true})
        .bytes;
  }();
  return bytes;
}

// What `verify` says of these bytes; empty where it says that all is the same.
std::string complaint(const std::string& bytes) {
  try {
    const Verification found = verify(log_of(bytes, LogAccess::scanned));
    if (found.divergence) {
      return found.divergence->section + " " + found.divergence->field + ": " +
             found.divergence->detail;
    }
    std::string text = found.has_end ? "" : "no end";
    for (const std::string& what : found.not_compared) text += what + "; ";
    return text;
  } catch (const InputError& error) {
    return error.what();
  }
}

// One change of one value.
struct Change {
  std::string path;  // "Turn.answers.decision.walk.vx_m_s"
  std::function<void(Message&)> apply;
};

void change_scalar(Message& message, const FieldDescriptor& field, int index) {
  const Reflection& access = *message.GetReflection();
  const bool repeated = field.is_repeated();
#define SEAM_CHANGE(Type, changed)                                               \
  {                                                                              \
    const auto old = repeated ? access.GetRepeated##Type(message, &field, index) \
                              : access.Get##Type(message, &field);               \
    repeated ? access.SetRepeated##Type(&message, &field, index, changed)        \
             : access.Set##Type(&message, &field, changed);                      \
  }
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      SEAM_CHANGE(Int32, old + 1) break;
    case FieldDescriptor::CPPTYPE_INT64:
      SEAM_CHANGE(Int64, old + 1) break;
    case FieldDescriptor::CPPTYPE_UINT32:
      SEAM_CHANGE(UInt32, old + 1) break;
    case FieldDescriptor::CPPTYPE_UINT64:
      SEAM_CHANGE(UInt64, old + 1) break;
    case FieldDescriptor::CPPTYPE_DOUBLE:
      SEAM_CHANGE(Double, old == 0 ? 0.125 : old * 1.0625) break;
    case FieldDescriptor::CPPTYPE_FLOAT:
      SEAM_CHANGE(Float, old == 0 ? 0.125F : old * 1.0625F) break;
    case FieldDescriptor::CPPTYPE_BOOL:
      SEAM_CHANGE(Bool, !old) break;
    case FieldDescriptor::CPPTYPE_ENUM:
      SEAM_CHANGE(EnumValue, old == 0 ? 1 : 0) break;
    case FieldDescriptor::CPPTYPE_STRING: {
      // The last byte, so that a number in a text stays one.
      SEAM_CHANGE(String, old.empty()
                              ? std::string("x")
                              : old.substr(0, old.size() - 1) + static_cast<char>(old.back() ^ 1))
      break;
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      break;
  }
#undef SEAM_CHANGE
}

using Finder = std::function<Message*(Message&)>;

// Changes of all fields of a message and of those inside, set or not; of a list its last item.
void collect(const Message& message, const std::string& path, const Finder& find,
             std::vector<Change>& changes) {
  const auto& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const Reflection& access = *message.GetReflection();
    const std::string name = path + "." + field.name();
    const int size = field.is_repeated() ? access.FieldSize(message, &field) : 0;
    const bool is_message = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (field.is_repeated() && size > 0) {
      changes.push_back({name + " (shorter)", [=, &field](Message& root) {
                           Message& parent = *find(root);
                           parent.GetReflection()->RemoveLast(&parent, &field);
                         }});
      for (int item = 0; is_message && item < size; ++item) {
        collect(
            access.GetRepeatedMessage(message, &field, item), name,
            [=, &field](Message& root) {
              Message& parent = *find(root);
              return parent.GetReflection()->MutableRepeatedMessage(&parent, &field, item);
            },
            changes);
      }
    }
    if (is_message && !field.is_repeated() && access.HasField(message, &field)) {
      changes.push_back({name + " (removed)", [=, &field](Message& root) {
                           Message& parent = *find(root);
                           parent.GetReflection()->ClearField(&parent, &field);
                         }});
      collect(
          access.GetMessage(message, &field), name,
          [=, &field](Message& root) {
            Message& parent = *find(root);
            return parent.GetReflection()->MutableMessage(&parent, &field);
          },
          changes);
    }
    // What stands in a oneof is changed where it is set: setting another clears it, which
    // `removed` and its neighbours do.
    const bool other_choice = field.containing_oneof() && !access.HasField(message, &field);
    if (!is_message && !other_choice && (!field.is_repeated() || size > 0)) {
      changes.push_back(
          {name, [=, &field](Message& root) { change_scalar(*find(root), field, size - 1); }});
    }
  }
}

std::unique_ptr<Message> parsed(const std::string& schema, const std::string& bytes) {
  const auto* type =
      google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(schema);
  SEAM_CHECK(type != nullptr, "{}", schema);
  std::unique_ptr<Message> message(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(type)->New());
  SEAM_CHECK(message->ParseFromString(bytes), "{}", schema);
  return message;
}

// A change of one message of the log, by its place among all.
struct Forgery {
  size_t message = 0;
  Change change;
  std::string schema;
};

// Of each field the first and the last place at which a message has it.
std::map<std::string, std::vector<Forgery>> forgeries(const std::string& bytes) {
  std::map<std::string, std::string> schemas;
  const Log log = log_of(bytes);
  for (const auto& [id, channel] : log.file().contents().channels) {
    schemas[channel.topic] = log.file().contents().schemas.at(channel.schema_id).name;
  }
  std::map<std::string, std::vector<Forgery>> found;
  size_t number = 0;
  edited(bytes, {.message = [&](CopiedMessage& copy) {
           const std::string& schema = schemas.at(copy.topic);
           std::vector<Change> changes;
           collect(
               *parsed(schema, copy.data), schema, [](Message& root) { return &root; }, changes);
           for (Change& change : changes) {
             std::vector<Forgery>& places = found[change.path];
             if (places.size() == 2) places.pop_back();
             places.push_back({number, std::move(change), schema});
           }
           ++number;
           return true;
         }});
  return found;
}

std::string forged(const std::string& bytes, const Forgery& forgery) {
  size_t number = 0;
  return edited(bytes, {.message = [&](CopiedMessage& copy) {
                  if (number++ != forgery.message) return true;
                  const auto message = parsed(forgery.schema, copy.data);
                  forgery.change.apply(*message);
                  copy.data = message->SerializeAsString();
                  return true;
                }});
}

TEST(ForgedLogs, AWholeLogIsTheSameAndAllOfItIsCompared) {
  EXPECT_EQ(complaint(whole_log()), "");
  EXPECT_EQ(complaint(edited(whole_log(), {})), "");
}

TEST(ForgedLogs, AChangeOfAnyFieldOfAnyMessageIsNoticed) {
  const auto all = forgeries(whole_log());
  EXPECT_GT(all.size(), 120u);
  std::vector<std::string> unnoticed;
  for (const auto& [path, places] : all) {
    for (const Forgery& forgery : places) {
      const std::string bytes = forged(whole_log(), forgery);
      if (complaint(bytes).empty()) unnoticed.push_back(path);
    }
  }
  EXPECT_THAT(unnoticed, ::testing::IsEmpty());
}

TEST(ForgedLogs, AMessageMoreOrLessIsNoticed) {
  for (const Topic topic : kTopics) {
    const bool copies_and_snapshots = topic == Topic::header || topic == Topic::snapshot;
    for (const bool doubled : {false, true}) {
      if (copies_and_snapshots && !doubled) continue;  // Readers go on without one of them.
      if (topic == Topic::header) continue;
      std::optional<CopiedMessage> last;
      edited(whole_log(), {.message = [&](CopiedMessage& copy) {
               if (copy.topic == topic_name(topic)) last = copy;
               return true;
             }});
      ASSERT_TRUE(last) << topic_name(topic);
      const Log log = log_of(whole_log());
      const mcap::Contents& contents = log.file().contents();
      mcap::MemoryOutput output;
      mcap::Writer writer(output, {.profile = std::string(kLogFormat)});
      for (const auto& [id, schema] : contents.schemas)
        writer.add_schema(schema.name, schema.encoding, schema.data);
      for (const auto& [id, channel] : contents.channels)
        writer.add_channel(channel.schema_id, channel.topic, channel.message_encoding);
      for (const mcap::ChunkPlace& chunk : contents.chunks) {
        log.file().for_each_message(chunk, [&](const mcap::Message& message) {
          const bool is_it =
              log.topic_of(message.channel_id) == topic && message.data == last->data;
          const int times = !is_it ? 1 : doubled ? 2 : 0;
          for (int i = 0; i < times; ++i)
            writer.write(message.channel_id, message.log_time_ns, message.data);
        });
      }
      writer.finish();
      EXPECT_NE(complaint(output.bytes()), "")
          << topic_name(topic) << (doubled ? " doubled" : " removed");
    }
  }
}

TEST(ForgedLogs, TimesInTheFileAreThoseOfTheMessages) {
  for (const Topic topic : {Topic::step, Topic::event, Topic::snapshot}) {
    bool changed = false;
    const std::string bytes = edited(whole_log(), {.message = [&](CopiedMessage& copy) {
                                       if (copy.topic == topic_name(topic) && !changed) {
                                         copy.log_time_ns += 1'000'000;
                                         changed = true;
                                       }
                                       return true;
                                     }});
    EXPECT_THAT(complaint(bytes), HasSubstr("stands at")) << topic_name(topic);
  }
}

TEST(ForgedLogs, AttachmentsAreTheHeadersTexts) {
  const std::string bytes = edited(whole_log(), {.attachment = [&](mcap::Attachment& one) {
                                     one.data += "# more\n";
                                     return true;
                                   }});
  EXPECT_THAT(complaint(bytes), HasSubstr("another text than the header's"));
  const std::string more = edited(whole_log(), {.attachment = [&](mcap::Attachment& one) {
                                    one.name = "notes.txt";
                                    return true;
                                  }});
  EXPECT_THAT(complaint(more), HasSubstr("the attachment 'notes.txt'"));
}

TEST(ForgedLogs, OfAStoppedRunTheEndIsProvedToo) {
  BusySource source;
  const std::string yaml = scenario_text(SEAM_SOURCE_DIR, 2, 0.6);
  const Scenario scenario = Scenario::from_text(yaml, "test.yaml");
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario);
  mcap::MemoryOutput output;
  Recorder recorder(output, world);
  Simulation simulation(
      {scenario, world, source, control, &renderer, {&recorder}, header_of(scenario, yaml)});
  simulation.run_to(SimTime::from_s(0.45));
  control.stop();
  simulation.run();
  ASSERT_EQ(complaint(output.bytes()), "");
  ASSERT_EQ(log_of(output.bytes()).end()->reason, EndReason::stopped);
  for (const auto& [path, places] : forgeries(output.bytes())) {
    if (!path.starts_with("seam.v1.LogEnd.") && !path.starts_with("seam.v1.LogFrame")) continue;
    EXPECT_NE(complaint(forged(output.bytes(), places.back())), "") << path;
  }
}

TEST(ForgedLogs, OfAKilledRunItIsSaidThatTheEndIsMissing) {
  BusySource source;
  const std::string yaml = scenario_text(SEAM_SOURCE_DIR, 2, 2);
  const std::string bytes = record(yaml, source, {}, SimTime::from_s(1.7)).bytes;
  EXPECT_EQ(complaint(bytes), "no end");
}

TEST(ForgedLogs, AnIndexThatTellsOtherwiseIsNoticed) {
  // A whole index, of another log of the same length of data: the last chunk's record is passed
  // over by readers of the index.
  const std::string bytes = whole_log();
  const Log log = log_of(bytes);
  const mcap::ChunkPlace last = log.file().contents().chunks.back();
  mcap::ByteSink summary;
  for (const auto& [id, schema] : log.file().contents().schemas) append(summary, schema);
  for (const auto& [id, channel] : log.file().contents().channels) append(summary, channel);
  for (const mcap::ChunkPlace& chunk : log.file().contents().chunks) {
    if (chunk.offset == last.offset) continue;
    mcap::ChunkIndex index{.start_time_ns = chunk.start_time_ns,
                           .end_time_ns = chunk.end_time_ns,
                           .chunk_offset = chunk.offset,
                           .chunk_length = chunk.length};
    for (const uint16_t channel : chunk.channels) index.message_index_offsets[channel] = 0;
    append(summary, index);
  }
  // Where the data end: found by walking, as the scan does.
  size_t at = mcap::kMagic.size();
  while (static_cast<mcap::Opcode>(bytes[at]) != mcap::Opcode::data_end) {
    mcap::ByteSource source(std::string_view(bytes).substr(at + 1));
    at += 9 + source.number<uint64_t>();
  }
  const size_t start = at + 9 + 4;
  mcap::ByteSink footer;
  append(footer, mcap::Footer{start, 0, 0});
  const std::string head = footer.bytes().substr(0, footer.bytes().size() - 4);
  footer = {};
  append(footer, mcap::Footer{start, 0, mcap::crc32(head, mcap::crc32(summary.bytes()))});
  const std::string forged =
      bytes.substr(0, start) + summary.bytes() + footer.bytes() + std::string(mcap::kMagic);
  ASSERT_LT(log_of(forged).file().contents().chunks.size(),
            log_of(bytes).file().contents().chunks.size());
  EXPECT_THAT(complaint(forged), HasSubstr("index differs from its data"));
}

}  // namespace
}  // namespace seam::scheduler
