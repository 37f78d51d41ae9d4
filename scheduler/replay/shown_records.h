// What a log holds for people to look at, pictures and Foxglove's poses and scenes, made again from
// the re-run and compared.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "scheduler/log/log.h"
#include "scheduler/replay/divergence.h"
#include "sim_core/scene/frame.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

class ShownRecords {
 public:
  // Both must outlive this.
  ShownRecords(const Log& log, const World& world);

  // With the world standing at a step.
  std::optional<Divergence> compare_step(SimTime time);
  // A frame that is the same as the log's, which ended at this time.
  std::optional<Divergence> compare_frame(SimTime time, const Frame& frame);
  // What the re-run did not make; call behind the last step and frame. Without frames, pictures
  // are left out.
  std::optional<Divergence> rest(bool frames);

 private:
  struct Shown {
    uint64_t time_ns = 0;
    std::string bytes;
  };
  // The messages of some channels, one after another.
  class Messages {
   public:
    Messages(const Log& log, std::string_view topic);
    const Shown* next();
    std::string topic_of_next() const { return topic_; }
    void pass() { waiting_.reset(); }

   private:
    MessageCursor cursor_;
    std::map<uint16_t, std::string> channels_;
    std::optional<Shown> waiting_;
    std::string topic_;
    bool over_ = false;
  };
  std::optional<Divergence> compare(Messages& messages, SimTime time,
                                    const std::function<std::string()>& made);
  void read_pictures_until(SimTime time);

  const World& world_;
  Messages transforms_, scenes_, pictures_;
  bool scene_begun_ = false;
  std::multimap<std::pair<std::string, uint64_t>, std::string> waiting_pictures_;
};

}  // namespace seam::scheduler
