// File descriptors for connections. gRPC stops accepting for good where a process has none left, so
// a server asks for as many as it may have.
#pragma once

namespace seam::scheduler {

// Raises the soft limit to the hard one, at most to 65,536. Does nothing where that fails.
void raise_descriptor_limit();

}  // namespace seam::scheduler
