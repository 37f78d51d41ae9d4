#include "app/import/pictures/bag_pictures.h"

#include <set>

#include "app/import/bags/ros_bag.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

// How an encoding's samples lie: channels in a pixel, their order turned, bytes in a sample.
struct Encoding {
  size_t channels = 1;
  bool blue_first = false;
  size_t bytes = 1;
  const char* mosaic = "";  // The colours of two rows of two pixels, where each has but one.
};

const std::map<std::string, Encoding>& encodings() {
  static const std::map<std::string, Encoding> known = {{"mono8", {}},
                                                        {"8UC1", {}},
                                                        {"mono16", {1, false, 2}},
                                                        {"16UC1", {1, false, 2}},
                                                        {"rgb8", {3}},
                                                        {"bgr8", {3, true}},
                                                        {"8UC3", {3, true}},
                                                        {"rgba8", {4}},
                                                        {"bgra8", {4, true}},
                                                        {"bayer_rggb8", {1, false, 1, "rggb"}},
                                                        {"bayer_rggb16", {1, false, 2, "rggb"}},
                                                        {"bayer_bggr8", {1, false, 1, "bggr"}},
                                                        {"bayer_bggr16", {1, false, 2, "bggr"}},
                                                        {"bayer_gbrg8", {1, false, 1, "gbrg"}},
                                                        {"bayer_gbrg16", {1, false, 2, "gbrg"}},
                                                        {"bayer_grbg8", {1, false, 1, "grbg"}},
                                                        {"bayer_grbg16", {1, false, 2, "grbg"}}};
  return known;
}

// As PGM or PPM: rows without gaps, samples of 16 bits with the high byte first. A mosaic says so
// in a comment, by which `seam-pictures` knows it.
std::string plain_picture(RosMessage& message, const std::string& topic) {
  const uint32_t height = message.number(), width = message.number();
  const std::string encoding = message.text();
  const bool big = message.byte() != 0;
  const size_t step = message.number();
  const std::string_view data = message.bytes();
  const auto known = encodings().find(encoding);
  if (known == encodings().end())
    throw InputError(
        fmt::format("{}: pictures are '{}', expected mono8, mono16, rgb8, bgr8 or a Bayer mosaic: "
                    "image_proc makes them",
                    topic, encoding));
  const Encoding& form = known->second;
  const size_t pixel = form.channels * form.bytes;
  if (width == 0 || height == 0 || uint64_t{width} * height > (uint64_t{1} << 26) ||
      step < width * pixel || data.size() / step < height)
    throw InputError(fmt::format("{}: a picture of {} x {} px in {} bytes does not hold", topic,
                                 width, height, data.size()));
  const size_t kept = std::min<size_t>(form.channels, 3);
  std::string picture = fmt::format("P{}\n", kept == 1 ? 5 : 6);
  if (*form.mosaic) picture += fmt::format("# bayer {}\n", form.mosaic);
  picture += fmt::format("{} {}\n{}\n", width, height, form.bytes == 1 ? 255 : 65535);
  picture.reserve(picture.size() + uint64_t{width} * height * kept * form.bytes);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const char* from = data.data() + y * step + x * pixel;
      for (size_t c = 0; c < kept; ++c) {
        const char* sample = from + (form.blue_first ? 2 - c : c) * form.bytes;
        for (size_t b = 0; b < form.bytes; ++b) picture += sample[big ? b : form.bytes - 1 - b];
      }
    }
  }
  return picture;
}

}  // namespace

BagPictures unpack_pictures(const fs::path& bag, const std::string& camera, const fs::path& into,
                            SetDraft& draft) {
  BagPictures found;
  std::vector<BagTopic> topics;
  std::set<std::string> image_topics;
  std::map<std::string, std::string> infos;  // A CameraInfo of each topic, as bytes.
  RosForm info_form = RosForm::cdr;
  const auto losses = read_bag(
      bag, topics, [&](size_t place, int64_t log_ns, std::string_view bytes, RosForm form) {
        const BagTopic& topic = topics[place];
        if (topic.type == "sensor_msgs/CameraInfo" && !infos.contains(topic.name))
          infos[topic.name] = bytes, info_form = form;
        const bool packed = topic.type == "sensor_msgs/CompressedImage";
        if (!packed && topic.type != "sensor_msgs/Image") return;
        image_topics.insert(topic.name);
        if (found.topic.empty() && topic.name.find(camera) != std::string::npos)
          found.topic = topic.name;
        if (topic.name != found.topic) return;
        RosMessage message(bytes, form, topic.name);
        const int64_t stamp_ns = message.header().stamp_ns;
        std::string picture;
        if (packed) {
          message.text();  // What its bytes say themselves.
          picture = message.bytes();
        } else {
          picture = plain_picture(message, topic.name);
        }
        found.files.push_back(into / fmt::format("{:06}", found.files.size()));
        write_file_atomically(found.files.back(), picture);
        found.stamps_ns[found.files.back().filename().string()] = stamp_ns != 0 ? stamp_ns : log_ns;
      });
  for (const std::string& loss : losses) draft.warn(loss);
  if (found.topic.empty() && !image_topics.empty())
    throw InputError(
        fmt::format("{}: --camera {}: no such topic of images{}", bag.string(), camera,
                    suggestion_for(camera, {image_topics.begin(), image_topics.end()})));
  if (image_topics.size() > 1)
    draft.did(
        fmt::format("of {} topics with pictures {} (--camera)", image_topics.size(), found.topic));
  // By habit the calibration stands beside its pictures: /left/image_raw, /left/camera_info.
  for (const auto& [name, bytes] : infos) {
    const std::string space = name.substr(0, name.rfind('/') + 1);
    if (found.topic.empty() || !found.topic.starts_with(space)) continue;
    RosMessage message(bytes, info_form, name);
    const bool rectified = found.topic.find("rect", space.size()) != std::string::npos;
    found.camera = read_camera_info(message, name, rectified, draft);
  }
  return found;
}

}  // namespace seam::app
