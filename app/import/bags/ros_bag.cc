#include "app/import/bags/ros_bag.h"

#include <map>

#include "mcap/reader.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

// ROS 2 says "sensor_msgs/msg/JointState".
std::string plain_type(const std::string& type) {
  const size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.substr(0, middle) + type.substr(middle + 4);
}

fs::path bag_in(const fs::path& path) {
  if (!fs::is_directory(path)) return path;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(path)) {
    const auto extension = entry.path().extension();
    if (extension == ".mcap" || extension == ".bag") found.push_back(entry.path());
    if (extension == ".db3")
      throw InputError(
          fmt::format("{}: found a bag as SQLite, expected MCAP: ros2 bag convert writes it",
                      entry.path().string()));
  }
  if (found.size() != 1)
    throw InputError(
        fmt::format("{}: found {} bags (.mcap, .bag), expected one", path.string(), found.size()));
  return found.front();
}

std::vector<std::string> read_mcap(std::unique_ptr<mcap::Input> input,
                                   std::vector<BagTopic>& topics, const BagVisit& visit) {
  // Black pictures pack well; what a chunk may hold bounds the memory all the same.
  constexpr mcap::Limits kOfBags{.chunk_bytes = uint64_t{256} << 20, .expansion = 100'000};
  const auto reader = mcap::Reader::open(std::move(input), kOfBags);
  const mcap::Contents& contents = reader.contents();
  std::map<uint16_t, size_t> place;
  for (const auto& [id, channel] : contents.channels) {
    const auto schema = contents.schemas.find(channel.schema_id);
    if (channel.message_encoding != "cdr" && channel.message_encoding != "ros1") continue;
    place[id] = topics.size();
    topics.push_back(
        {.name = channel.topic,
         .type = schema == contents.schemas.end() ? "" : plain_type(schema->second.name)});
  }
  std::vector<std::string> losses;
  for (const mcap::Loss& loss : contents.losses) {
    if (!loss.index_only) losses.push_back(loss.what);
  }
  for (const mcap::ChunkPlace& chunk : contents.chunks) {
    reader.for_each_message(chunk, [&](const mcap::Message& message) {
      const auto found = place.find(message.channel_id);
      if (found == place.end()) return;
      const bool ros1 = contents.channels.at(message.channel_id).message_encoding == "ros1";
      ++topics[found->second].messages;
      visit(found->second, static_cast<int64_t>(message.log_time_ns), message.data,
            ros1 ? RosForm::ros1 : RosForm::cdr);
    });
  }
  return losses;
}

}  // namespace

std::vector<std::string> read_bag(const fs::path& source, std::vector<BagTopic>& topics,
                                  const BagVisit& visit) {
  const fs::path path = bag_in(source);
  auto input = mcap::open_file(path);
  const std::string name = path.string();
  const std::string start = input->read(0, std::min<uint64_t>(input->size(), 32));
  if (start.starts_with("version https://git-lfs"))
    throw InputError(
        fmt::format("{}:1: found a pointer of Git LFS: fetch the bag, git lfs pull", name));
  if (start.starts_with("SQLite format"))
    throw InputError(
        fmt::format("{}: found a bag as SQLite, expected MCAP: ros2 bag convert writes it", name));
  std::vector<std::string> losses;
  if (start.starts_with("#ROSBAG V2.0\n")) {
    losses = read_ros1_bag(*input, topics, visit);
  } else if (start.starts_with("#ROSBAG")) {
    throw InputError(fmt::format("{}: found {}, expected version 2.0: rosbag migrates it", name,
                                 start.substr(0, start.find('\n'))));
  } else {
    losses = read_mcap(std::move(input), topics, visit);
  }
  if (topics.empty())
    throw InputError(fmt::format("{}: holds no topic with messages of ROS{}", name,
                                 losses.empty() ? "" : ": " + losses.front()));
  return losses;
}

}  // namespace seam::app
