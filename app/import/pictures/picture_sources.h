// What an import of pictures was given: pictures by camera, the target, times.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"
#include "app/import/draft/target.h"
#include "app/import/files/text_table.h"
#include "app/import/pictures/bag_pictures.h"
#include "app/scratch_folder.h"

namespace seam::app {

// What one camera took.
struct CameraPictures {
  std::string name;  // Empty where none was asked for.
  std::vector<std::filesystem::path> pictures;
  BagPictures of_bag;  // By whose stamps they are timed, where they come from one.
  // Before what is reported of it, where there are several.
  std::string said;
};

struct Sources {
  std::vector<CameraPictures> cameras;
  std::optional<TargetSpec> target;
  std::optional<TextTable> times;
  std::unique_ptr<ScratchFolder> unpacked;  // Where pictures of a bag are meanwhile.
};

// Reads the request's sources, each camera's pictures in the order of their numbers. Throws
// InputError or UsageError, naming the source that does not serve.
Sources sources_of(const ImportRequest& request, SetDraft& draft);

}  // namespace seam::app
