// Effects outside the tree: a shared object built against these headers, loaded with
// `seam --plugin FILE ...`. It exports one function:
//
//   #include <seam/effects/plugin.h>
//   SEAM_PLUGIN(effects) { effects.push_back(my_effect()); }
//
// The object must be built with the same compiler and the same version of SEAM: the interface is
// the C++ struct EffectDefinition, and SEAM_PLUGIN_VERSION guards it.
#pragma once

#include <vector>

#include "effects/effect.h"

#define SEAM_PLUGIN_VERSION 4

#define SEAM_PLUGIN(effects)             \
  extern "C" int seam_plugin_version() { \
    return SEAM_PLUGIN_VERSION;          \
  }                                      \
  extern "C" void seam_plugin_effects(std::vector<seam::effects::EffectDefinition>& effects)
