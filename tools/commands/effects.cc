// `seam effects [NAME]`: the catalogue, or all about one effect.
#include <fmt/ranges.h>

#include <cstdio>

#include "effects/catalogue_help.h"
#include "effects/proof/proof.h"
#include "effects/registry.h"
#include "sim_core/base/error.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

// Prints what the worked examples show; a failure where they leave something open.
void prove(const std::shared_ptr<const effects::EffectDefinition>& effect) {
  const std::vector<std::string> open = effects::open_proofs(effect);
  if (!open.empty()) {
    throw InputError(fmt::format(
        "effect '{}' is not proved:\n  {}\nExpected: examples (.proof) whose numbers were computed "
        "elsewhere; correct the hook or the numbers",
        effect->name, fmt::join(open, "\n  ")));
  }
  const std::string text = fmt::format("{}: {} worked examples are met, each parameter matters{}\n",
                                       effect->name, effect->proof.size(),
                                       effect->has_neutral && effect->base == effects::Base::none
                                           ? ", and it is absent at its neutral values"
                                           : "");
  std::fputs(text.c_str(), stdout);
}

}  // namespace

void add_effects(app::Command app) {
  app::Command command =
      app.add_subcommand("effects", "The catalogue of physical effects, with help and examples");
  auto name = std::make_shared<std::string>();
  auto markdown = std::make_shared<bool>(false);
  auto proof = std::make_shared<bool>(false);
  command.add_option("NAME", *name, "One effect");
  command.add_flag("--markdown", *markdown,
                   "The whole catalogue as a page (docs/reference/effects.md)");
  command.add_flag(
      "--prove", *proof,
      "Compare the effect NAME with its worked examples, and show that it is absent at "
      "its neutral values");
  command.footer(
      "Examples:\n  seam effects rolling_shutter\n  seam effects rolling_shutter --prove");
  command.callback([name, markdown, proof] {
    if (*proof && name->empty())
      throw UsageError("effects --prove: expected the NAME of an effect");
    if (*markdown) {
      std::fputs(effects::catalogue_markdown().c_str(), stdout);
    } else if (name->empty()) {
      std::fputs(effects::catalogue_list().c_str(), stdout);
    } else if (const auto effect = effects::find_effect(*name)) {
      if (*proof) return prove(effect);
      std::fputs(effects::effect_help(*effect).c_str(), stdout);
    } else {
      throw InputError(fmt::format("unknown effect '{}'{}", *name,
                                   suggestion_for(*name, effects::effect_names())));
    }
  });
}

}  // namespace seam::tools
