// How threads are started.
#pragma once

#include <functional>
#include <thread>

namespace seam {

// A thread that takes no signals, so that those reach who waits for them; it is joined when the
// object goes. Throws InputError where the operating system grants no thread.
std::jthread start_thread(std::function<void()> work);

}  // namespace seam
