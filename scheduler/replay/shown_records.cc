#include "scheduler/replay/shown_records.h"

#include <fmt/format.h>

#include <algorithm>

#include "scheduler/log/foxglove.h"
#include "scheduler/log/recorder.h"
#include "sim_core/base/error.h"
#include "sim_core/base/image.h"

namespace seam::scheduler {
namespace {

SimTime sim_time(uint64_t time_ns) {
  return SimTime::from_ns(static_cast<int64_t>(std::min<uint64_t>(time_ns, INT64_MAX)));
}

Divergence other(SimTime time, const std::string& topic, const std::string& detail) {
  return {time, topic, "message", detail};
}

}  // namespace

ShownRecords::Messages::Messages(const Log& log, std::string_view topic) : cursor_(log) {
  for (const auto& [id, channel] : log.file().contents().channels) {
    const bool is_family = topic.ends_with('/');
    if (channel.topic == topic || (is_family && channel.topic.starts_with(topic))) {
      channels_[id] = channel.topic;
    }
  }
  over_ = channels_.empty();
}

const ShownRecords::Shown* ShownRecords::Messages::next() {
  while (!waiting_ && !over_) {
    const std::optional<mcap::Message> message = cursor_.next();
    if (!message) {
      over_ = true;
    } else if (const auto channel = channels_.find(message->channel_id);
               channel != channels_.end()) {
      waiting_ = {message->log_time_ns, std::string(message->data)};
      topic_ = channel->second;
    }
  }
  return waiting_ ? &*waiting_ : nullptr;
}

ShownRecords::ShownRecords(const Log& log, const World& world)
    : world_(world),
      transforms_(log, kTransforms.topic),
      scenes_(log, kSceneUpdates.topic),
      pictures_(log, kPictures.topic) {}

std::optional<Divergence> ShownRecords::compare(Messages& messages, SimTime time,
                                                const std::function<std::string()>& made) {
  const Shown* logged = messages.next();
  if (logged == nullptr || logged->time_ns > log_time(time)) return std::nullopt;
  if (logged->time_ns != log_time(time)) {
    return other(sim_time(logged->time_ns), messages.topic_of_next(),
                 "the log has a message at a time at which the run writes none");
  }
  if (logged->bytes != made()) {
    return other(time, messages.topic_of_next(), "the log shows something else than the re-run");
  }
  messages.pass();
  return std::nullopt;
}

std::optional<Divergence> ShownRecords::compare_step(SimTime time) {
  if (auto found = compare(transforms_, time, [&] { return frame_transforms(world_, time); })) {
    return found;
  }
  return compare(scenes_, time,
                 [&] { return scene_update(world_, time, !std::exchange(scene_begun_, true)); });
}

void ShownRecords::read_pictures_until(SimTime time) {
  // A picture stands right behind its frame's record; other writers may have put a record of the
  // same time between.
  while (const Shown* picture = pictures_.next()) {
    if (picture->time_ns > log_time(time)) return;
    waiting_pictures_.emplace(std::pair(pictures_.topic_of_next(), picture->time_ns),
                              picture->bytes);
    pictures_.pass();
  }
}

std::optional<Divergence> ShownRecords::compare_frame(SimTime time, const Frame& frame) {
  read_pictures_until(time);
  const std::string topic = picture_topic(frame.robot);
  const auto found = waiting_pictures_.find({topic, log_time(time)});
  if (found == waiting_pictures_.end()) return std::nullopt;
  const std::string bytes = std::move(found->second);
  waiting_pictures_.erase(found);
  // Other versions of libpng may pack the same pixels otherwise: the picture counts, not its bytes.
  std::string png = picture_of(bytes);
  const Image image = decode_png(png, topic);
  const bool same_pixels = image.width_px == frame.width_px && image.height_px == frame.height_px &&
                           image.channels == 3 && image.bits == 8 &&
                           std::ranges::equal(image.samples, frame.rgb);
  if (!same_pixels ||
      bytes != compressed_image(frame.stamp, frame.robot + "/camera", std::move(png))) {
    return other(time, topic,
                 fmt::format("frame {}: the log's picture is another", frame.frame_index));
  }
  return std::nullopt;
}

std::optional<Divergence> ShownRecords::rest(bool frames) {
  for (Messages* messages : {&transforms_, &scenes_}) {
    if (const Shown* more = messages->next()) {
      return other(sim_time(more->time_ns), messages->topic_of_next(),
                   "the log has a message that the re-run does not make");
    }
  }
  if (!frames) return std::nullopt;
  read_pictures_until(SimTime::from_ns(INT64_MAX));
  if (waiting_pictures_.empty()) return std::nullopt;
  const auto& [topic, time_ns] = waiting_pictures_.begin()->first;
  return other(sim_time(time_ns), topic, "the log has a picture of a frame that was not made");
}

}  // namespace seam::scheduler
