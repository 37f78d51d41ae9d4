#include "app/import/bags/ros_bag.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "app/import/bags/reading_progress.h"
#include "app/import/bags/ros_definition.h"
#include "mcap/reader.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_of_sqlite(const fs::path& path) {
  throw InputError(fmt::format(
      "{}: found a bag as SQLite, expected MCAP: ros2 bag convert writes it", path.string()));
}

[[noreturn]] void fail_of_packed(const fs::path& path) {
  throw InputError(fmt::format(
      "{}: found a file that is packed as a whole, expected a bag: unpack it (unzstd, gunzip)",
      path.string()));
}

// The parts of a bag in their order: a folder's, or the file.
std::vector<fs::path> parts_of(const fs::path& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(path)) {
    const auto extension = entry.path().extension();
    if (extension == ".mcap" || extension == ".bag") found.push_back(entry.path());
    if (extension == ".db3") fail_of_sqlite(entry.path());
    if (extension == ".zstd" || extension == ".zst") fail_of_packed(entry.path());
  }
  if (found.empty()) throw InputError(fmt::format("{}: found no bag (.mcap, .bag)", path.string()));
  // A long recording is split: run_0.mcap, run_1.mcap.
  const auto stem = [](const fs::path& part) {
    const std::string name = part.stem().string();
    const size_t last = name.find_last_not_of("0123456789");
    return last == std::string::npos ? "" : name.substr(0, last + 1);
  };
  for (const fs::path& part : found) {
    if (stem(part) != stem(found.front()) || part.extension() != found.front().extension())
      throw InputError(
          fmt::format("{}: found {} bags (.mcap, .bag), expected one, or the parts of one: {} and "
                      "{}",
                      path.string(), found.size(), found.front().filename().string(),
                      part.filename().string()));
  }
  std::sort(found.begin(), found.end(), [](const fs::path& a, const fs::path& b) {
    const std::string x = a.filename().string(), y = b.filename().string();
    return std::pair(x.size(), x) < std::pair(y.size(), y);  // 10 behind 9.
  });
  return found;
}

// A file that reports how far its reading is.
class WatchedInput : public mcap::Input {
 public:
  // `before`: bytes of the parts that were read before it.
  WatchedInput(const fs::path& path, uint64_t before, ReadingProgress& progress)
      : input_(mcap::open_file(path)), before_(before), progress_(progress) {}

  uint64_t size() const override { return input_->size(); }
  std::string read(uint64_t offset, uint64_t size) const override {
    progress_.at(before_ + offset);
    return input_->read(offset, size);
  }
  const std::string& name() const override { return input_->name(); }

 private:
  std::unique_ptr<mcap::Input> input_;
  uint64_t before_;
  ReadingProgress& progress_;
};

// What a topic's messages are, in the words of errors.
std::string encodings_in(const mcap::Contents& contents) {
  std::set<std::string> encodings;
  for (const auto& [id, channel] : contents.channels) encodings.insert(channel.message_encoding);
  return fmt::format("{}", fmt::join(encodings, ", "));
}

std::vector<std::string> read_mcap(const mcap::Input& input, std::vector<BagTopic>& topics,
                                   const BagVisit& visit, UnpackBudget& budget) {
  // Black pictures pack well; what a chunk and all of them may hold bounds memory and time.
  const mcap::Limits of_bags{
      .chunk_bytes = uint64_t{256} << 20, .expansion = 100'000, .all_chunks_bytes = budget.left()};
  std::map<uint16_t, std::optional<size_t>> places;  // Of a channel; none: not of ROS.
  const auto place_of = [&](const mcap::Contents& contents, uint16_t id) -> std::optional<size_t> {
    if (const auto known = places.find(id); known != places.end()) return known->second;
    const auto channel = contents.channels.find(id);
    if (channel == contents.channels.end()) return std::nullopt;
    std::optional<size_t>& place = places[id];
    const std::string& encoding = channel->second.message_encoding;
    if (encoding != "cdr" && encoding != "ros1") return place;
    const auto schema = contents.schemas.find(channel->second.schema_id);
    BagTopic topic{.name = channel->second.topic};
    if (schema != contents.schemas.end()) {
      topic.type = plain_ros_type(schema->second.name);
      const std::string& language = schema->second.encoding;
      if (language == "ros2msg" || language == "ros1msg") topic.definition = schema->second.data;
    }
    // Parts of a bag, and several writers of a topic, have channels of their own.
    const auto known = std::find_if(topics.begin(), topics.end(), [&](const BagTopic& other) {
      return other.name == topic.name && other.type == topic.type;
    });
    place = static_cast<size_t>(known - topics.begin());
    if (known == topics.end()) topics.push_back(topic);
    return place;
  };
  const mcap::Contents contents = mcap::scan_messages(
      input, of_bags, [&](const mcap::Contents& so_far, const mcap::Message& message) {
        const auto place = place_of(so_far, message.channel_id);
        if (!place) return;
        const bool ros1 = so_far.channels.at(message.channel_id).message_encoding == "ros1";
        ++topics[*place].messages;
        visit(*place, static_cast<int64_t>(message.log_time_ns), message.data,
              ros1 ? RosForm::ros1 : RosForm::cdr);
      });
  budget.take(contents.unpacked_bytes);
  for (const auto& [id, channel] : contents.channels) place_of(contents, id);
  std::vector<std::string> losses;
  for (const mcap::Loss& loss : contents.losses) {
    if (!loss.index_only)
      losses.push_back(fmt::format("{}: byte {}: {}", input.name(), loss.offset, loss.what));
  }
  if (topics.empty() && losses.empty() && !contents.channels.empty())
    throw InputError(fmt::format("{}: its messages are {}, expected cdr (ROS 2) or ros1",
                                 input.name(), encodings_in(contents)));
  return losses;
}

std::vector<std::string> read_part(const fs::path& path, const mcap::Input& input,
                                   std::vector<BagTopic>& topics, const BagVisit& visit,
                                   UnpackBudget& budget) {
  const std::string name = path.string();
  const std::string start = input.read(0, std::min<uint64_t>(input.size(), 32));
  if (start.empty()) throw InputError(fmt::format("{}: is empty, expected a bag", name));
  if (start.starts_with("version https://git-lfs"))
    throw InputError(
        fmt::format("{}:1: found a pointer of Git LFS: fetch the bag, git lfs pull", name));
  if (start.starts_with("SQLite format")) fail_of_sqlite(path);
  if (start.starts_with("\x28\xB5\x2F\xFD") || start.starts_with("\x1F\x8B")) fail_of_packed(path);
  if (start.starts_with("#ROSBAG V2.0\n")) return read_ros1_bag(input, topics, visit, budget);
  if (start.starts_with("#ROSBAG"))
    throw InputError(fmt::format("{}: found {}, expected version 2.0: rosbag migrates it", name,
                                 start.substr(0, start.find('\n'))));
  return read_mcap(input, topics, visit, budget);
}

}  // namespace

std::vector<std::string> read_bag(const fs::path& source, std::vector<BagTopic>& topics,
                                  const BagVisit& visit) {
  const std::vector<fs::path> parts = parts_of(source);
  // Recordings pack to a half or a tenth.
  constexpr uint64_t kMostExpansion = 20;
  uint64_t bytes = 0, before = 0;
  for (const fs::path& part : parts) {
    std::error_code ignored;
    const uint64_t size = fs::file_size(part, ignored);
    if (!ignored) bytes += size;
  }
  UnpackBudget budget(source.string(), std::max(UnpackBudget::kBytes, kMostExpansion * bytes));
  ReadingProgress progress(source.filename().string(), bytes);
  std::vector<std::string> losses;
  for (const fs::path& part : parts) {
    const WatchedInput input(part, before, progress);
    const auto of_part = read_part(part, input, topics, visit, budget);
    before += input.size();
    losses.insert(losses.end(), of_part.begin(), of_part.end());
  }
  if (topics.empty())
    throw InputError(fmt::format("{}: holds no topic with messages of ROS{}", source.string(),
                                 losses.empty() ? "" : ": " + losses.front()));
  return losses;
}

}  // namespace seam::app
