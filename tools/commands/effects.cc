// `seam effects [NAME]`: the catalogue, or all about one effect.
#include <cstdio>

#include "effects/catalogue_help.h"
#include "effects/registry.h"
#include "sim_core/base/error.h"
#include "tools/command.h"

namespace seam::tools {

void add_effects(app::Command app) {
  app::Command command =
      app.add_subcommand("effects", "The catalogue of physical effects, with help and examples");
  auto name = std::make_shared<std::string>();
  auto markdown = std::make_shared<bool>(false);
  command.add_option("NAME", *name, "One effect");
  command.add_flag("--markdown", *markdown,
                   "The whole catalogue as a page (docs/reference/effects.md)");
  command.footer("Example: seam effects rolling_shutter");
  command.callback([name, markdown] {
    if (*markdown) {
      std::fputs(effects::catalogue_markdown().c_str(), stdout);
    } else if (name->empty()) {
      std::fputs(effects::catalogue_list().c_str(), stdout);
    } else if (const auto effect = effects::find_effect(*name)) {
      std::fputs(effects::effect_help(*effect).c_str(), stdout);
    } else {
      throw InputError(fmt::format("unknown effect '{}'{}", *name,
                                   suggestion_for(*name, effects::effect_names())));
    }
  });
}

}  // namespace seam::tools
