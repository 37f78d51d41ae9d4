// The renderer's end of the wire: takes jobs from a server, has them rendered, sends the pixels.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scheduler/loop/frame_renderer.h"
#include "scheduler/wire/render_wire.h"

namespace seam::scheduler {

struct RenderClientOptions {
  std::string address;  // "unix:/path" or "host:port".
  std::string token;
  std::string certificates;  // Folder with ca.pem, client.pem, client.key; empty: no TLS.
  std::string version;
  std::string name;
  std::vector<std::string> robots;  // Empty: all.
  int threads = 1;                  // Frames rendered at once; as many again may wait here.
  double give_up_s = 20;            // Without a server for so long, also at the start.
};

// Cameras in the setup's order; schedule() and mount() are not used.
using MakeRenderer = std::function<std::unique_ptr<FrameRenderer>(const RenderSetup& setup)>;

// Renders until the server says goodbye; its reason. Connects again when the connection breaks.
// Throws InputError when the server refuses, when there is none, and when a renderer cannot be
// made.
std::string render_for_server(const RenderClientOptions& options, const MakeRenderer& make);

}  // namespace seam::scheduler
