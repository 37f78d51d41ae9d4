// Bags of ROS 1, version 2.0 (wiki.ros.org/Bags/Format/2.0). A reader of our own, since ROS's
// brings half of ROS along and trusts its files.
#include <bzlib.h>

#include <map>

#include "app/import/bags/ros_bag.h"
#include "mcap/chunk.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr uint64_t kMaxChunkBytes = uint64_t{256} << 20;
constexpr uint32_t kMaxRecordHead = 1 << 20;
enum : uint8_t { kMessageRecord = 0x02, kChunkRecord = 0x05, kConnectionRecord = 0x07 };

uint32_t little(std::string_view bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 4; i-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// name=value fields, each behind its length.
std::map<std::string, std::string> fields_of(std::string_view bytes, const std::string& name) {
  std::map<std::string, std::string> fields;
  for (size_t at = 0; at + 4 <= bytes.size();) {
    const size_t size = little(bytes, at);
    if (size > bytes.size() - at - 4)
      throw InputError(fmt::format("{}: a field of a record is longer than it: damaged", name));
    const std::string_view field = bytes.substr(at + 4, size);
    const size_t equals = field.find('=');
    if (equals == std::string_view::npos)
      throw InputError(fmt::format("{}: a field of a record has no value: damaged", name));
    fields.emplace(field.substr(0, equals), field.substr(equals + 1));
    at += 4 + size;
  }
  return fields;
}

uint32_t number_in(const std::map<std::string, std::string>& fields, const char* key,
                   const std::string& name) {
  const auto found = fields.find(key);
  if (found == fields.end() || found->second.size() < 4)
    throw InputError(fmt::format("{}: a record has no '{}': damaged", name, key));
  return little(found->second, 0);
}

std::string unpacked_bz2(const std::string& packed, uint32_t size, const std::string& name) {
  std::string out(size, '\0');
  unsigned length = size;
  const int status =
      BZ2_bzBuffToBuffDecompress(out.data(), &length, const_cast<char*>(packed.data()),
                                 static_cast<unsigned>(packed.size()), 0, 0);
  if (status != BZ_OK || length != size)
    throw InputError(fmt::format("{}: a chunk's bz2 bytes are damaged", name));
  return out;
}

std::string unpacked_lz4(const std::string& packed, uint32_t size, const std::string& name) {
  try {
    return mcap::unpack_lz4(packed, size);
  } catch (const mcap::Malformed& error) {
    throw InputError(fmt::format("{}: a chunk's LZ4 bytes are damaged: {}", name, error.what()));
  }
}

class Ros1Bag {
 public:
  Ros1Bag(const mcap::Input& input, std::vector<BagTopic>& topics, const BagVisit& visit,
          UnpackBudget& budget)
      : input_(input), name_(input.name()), topics_(topics), visit_(visit), budget_(budget) {}

  void read() {
    constexpr uint64_t kStart = 13;  // "#ROSBAG V2.0\n".
    uint64_t at = kStart;
    while (at + 8 <= input_.size()) {
      const uint32_t head = little(read_at(at, 4), 0);
      if (head > kMaxRecordHead)
        throw InputError(
            fmt::format("{}: byte {}: a record's head of {} bytes: damaged", name_, at, head));
      where_ = fmt::format("{}: byte {}", name_, at);
      const auto fields = fields_of(read_at(at + 4, head), where_);
      const uint32_t size = little(read_at(at + 4 + head, 4), 0);
      const uint64_t data = at + 8 + head;
      if (size > input_.size() - data)
        throw InputError(fmt::format(
            "{}: byte {}: a record of {} bytes where {} are left: the bag is cut (rosbag reindex)",
            name_, at, size, input_.size() - data));
      const uint8_t op = op_of(fields);
      if (op == kChunkRecord) {
        take_chunk(fields, read_at(data, size));
      } else if (op == kConnectionRecord) {
        take_connection(fields, read_at(data, size));
      } else if (op == kMessageRecord) {
        take_message(fields, read_at(data, size));
      }
      at = data + size;
    }
  }

 private:
  std::string read_at(uint64_t at, uint64_t size) const {
    if (size > kMaxChunkBytes || at > input_.size() || size > input_.size() - at)
      throw InputError(fmt::format("{}: byte {}: the bag is cut or damaged", name_, at));
    return input_.read(at, size);
  }

  uint8_t op_of(const std::map<std::string, std::string>& fields) const {
    const auto found = fields.find("op");
    if (found == fields.end() || found->second.empty())
      throw InputError(fmt::format("{}: a record does not say what it is: damaged", where_));
    return static_cast<uint8_t>(found->second[0]);
  }

  void take_connection(const std::map<std::string, std::string>& fields, std::string_view data) {
    const uint32_t id = number_in(fields, "conn", where_);
    if (place_.contains(id)) return;
    const auto facts = fields_of(data, where_);
    const auto topic = fields.find("topic"), type = facts.find("type");
    // Several publishers of a topic have a connection each.
    const std::string name = topic == fields.end() ? "" : topic->second;
    for (size_t i = 0; i < topics_.size(); ++i) {
      if (topics_[i].name == name) {
        place_[id] = i;
        return;
      }
    }
    place_[id] = topics_.size();
    const auto definition = facts.find("message_definition");
    topics_.push_back({.name = name,
                       .type = type == facts.end() ? "" : type->second,
                       .definition = definition == facts.end() ? "" : definition->second});
  }

  void take_message(const std::map<std::string, std::string>& fields, std::string_view data) {
    const auto found = place_.find(number_in(fields, "conn", where_));
    const auto time = fields.find("time");
    if (found == place_.end() || time == fields.end() || time->second.size() < 8)
      throw InputError(
          fmt::format("{}: a message without its connection or time: damaged", where_));
    ++topics_[found->second].messages;
    visit_(found->second,
           int64_t{little(time->second, 0)} * 1'000'000'000 + little(time->second, 4), data,
           RosForm::ros1);
  }

  void take_chunk(const std::map<std::string, std::string>& fields, std::string packed) {
    const uint32_t size = number_in(fields, "size", where_);
    if (size > kMaxChunkBytes)
      throw InputError(fmt::format("{}: a chunk unpacks to {} bytes, expected at most {}", where_,
                                   size, kMaxChunkBytes));
    const auto found = fields.find("compression");
    const std::string how = found == fields.end() ? "none" : found->second;
    if (how == "bz2" || how == "lz4") budget_.take(size);
    if (how == "bz2") {
      packed = unpacked_bz2(packed, size, where_);
    } else if (how == "lz4") {
      packed = unpacked_lz4(packed, size, where_);
    } else if (how != "none") {
      throw InputError(
          fmt::format("{}: found compression '{}', expected none, bz2 or lz4", where_, how));
    }
    const std::string_view records = packed;
    for (size_t at = 0; at + 8 <= records.size();) {
      const size_t head = little(records, at);
      if (head > records.size() - at - 8)
        throw InputError(fmt::format("{}: a record of a chunk is longer than it: damaged", where_));
      const auto inner = fields_of(records.substr(at + 4, head), where_);
      const size_t length = little(records, at + 4 + head);
      if (length > records.size() - at - 8 - head)
        throw InputError(fmt::format("{}: a record of a chunk is longer than it: damaged", where_));
      const std::string_view data = records.substr(at + 8 + head, length);
      if (op_of(inner) == kConnectionRecord) take_connection(inner, data);
      if (op_of(inner) == kMessageRecord) take_message(inner, data);
      at += 8 + head + length;
    }
  }

  const mcap::Input& input_;
  const std::string& name_;
  std::string where_;  // The file and the byte of the record that is read, for errors.
  std::vector<BagTopic>& topics_;
  const BagVisit& visit_;
  UnpackBudget& budget_;
  std::map<uint32_t, size_t> place_;  // Of a connection's topic.
};

}  // namespace

std::vector<std::string> read_ros1_bag(const mcap::Input& input, std::vector<BagTopic>& topics,
                                       const BagVisit& visit, UnpackBudget& budget) {
  Ros1Bag(input, topics, visit, budget).read();
  return {};
}

}  // namespace seam::app
