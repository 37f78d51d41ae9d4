#include "app/plugins.h"

#include <dlfcn.h>

#include <filesystem>

#include "effects/plugin.h"
#include "effects/proof/proof.h"
#include "effects/registry.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

void load(const std::string& file) {
  if (!std::filesystem::exists(file))
    throw InputError(fmt::format("{}: no such file, expected a plugin", file));
  // Never closed: the effects' functions live in it.
  void* object = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (object == nullptr) throw InputError(fmt::format("{}: {}", file, dlerror()));
  const auto version = reinterpret_cast<int (*)()>(dlsym(object, "seam_plugin_version"));
  const auto effects = reinterpret_cast<void (*)(std::vector<effects::EffectDefinition>&)>(
      dlsym(object, "seam_plugin_effects"));
  if (version == nullptr || effects == nullptr) {
    throw InputError(
        fmt::format("{}: exports no SEAM_PLUGIN, expected a plugin (effects/plugin.h)", file));
  }
  if (version() != SEAM_PLUGIN_VERSION) {
    throw InputError(
        fmt::format("{}: plugin interface {}, expected {}", file, version(), SEAM_PLUGIN_VERSION));
  }
  std::vector<effects::EffectDefinition> found;
  effects(found);
  for (effects::EffectDefinition& effect : found) {
    const std::string name = effect.name;
    effects::register_effect(std::move(effect));
    if (const std::string failed = effects::failed_proof(effects::find_effect(name));
        !failed.empty()) {
      throw InputError(fmt::format("effect '{}' does not meet its own example: {}", name, failed));
    }
  }
}

}  // namespace

std::vector<std::string> load_plugins(const std::vector<std::string>& arguments) {
  std::vector<std::string> others;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument.starts_with("--plugin=")) {
      load(argument.substr(9));
    } else if (argument == "--plugin") {
      if (i + 1 >= arguments.size()) throw UsageError("--plugin: no file given");
      load(arguments[++i]);
    } else {
      others.push_back(argument);
    }
  }
  return others;
}

}  // namespace seam::app
