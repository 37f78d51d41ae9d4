// The messages of a log, one line each: from this list follow the kinds of records, their topics
// and schemas, how they are encoded, decoded and dispatched, and the table of replays/FORMAT.md.
#pragma once

#include <string_view>

// X(name, Record, Message): topic /seam/NAME holds messages seam.v1.MESSAGE, which are read into
// values of RECORD (log_records.h). The order is that of the channels in the file.
#define SEAM_LOG_MESSAGES(X)               \
  X(header, RunHeader, LogHeader)          \
  X(turn, TurnRecord, Turn)                \
  X(step, StepRecord, LogStep)             \
  X(snapshot, SnapshotRecord, LogSnapshot) \
  X(frame, FrameRecord, LogFrame)          \
  X(event, SimulationEvent, LogEvent)      \
  X(end, EndRecord, LogEnd)

namespace seam::scheduler {

// What is written on request, for people to look at: nothing in it is needed for a re-run.
struct ShownMessage {
  std::string_view topic;
  std::string_view schema;
};
// The topic of a robot's pictures ends with its name.
inline constexpr ShownMessage kPictures{"/camera/", "foxglove.CompressedImage"};
inline constexpr ShownMessage kTransforms{"/tf", "foxglove.FrameTransforms"};
inline constexpr ShownMessage kSceneUpdates{"/scene", "foxglove.SceneUpdate"};
// What behaviours print; written where one prints something.
inline constexpr ShownMessage kPrinted{"/printed", "foxglove.Log"};

}  // namespace seam::scheduler
