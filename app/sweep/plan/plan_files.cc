#include "app/sweep/plan/plan_files.h"

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::app {

const std::string& PlanFiles::text(const std::string& name) {
  const auto found = texts_.find(name);
  if (found != texts_.end()) return found->second;
  if (!folder_) throw InputError(fmt::format("file '{}' of the plan was not kept", name));
  return texts_[name] = read_file(*folder_ / name, 16 << 20);
}

}  // namespace seam::app
