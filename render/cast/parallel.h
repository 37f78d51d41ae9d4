// Work on parts of one frame by several threads.
#pragma once

#include <algorithm>
#include <thread>
#include <vector>

#include "sim_core/system/thread.h"

namespace seam::render {

// Runs work(begin, end) over parts of [0, count), each on its own thread; throws InputError where
// the operating system grants none. What a part computes must not depend on how the parts are cut.
template <typename Work>
void split_over_threads(int threads, int count, const Work& work) {
  threads = std::clamp(threads, 1, std::max(count, 1));
  std::vector<std::jthread> helpers;
  for (int part = 1; part < threads; ++part) {
    helpers.push_back(start_thread([&work, part, threads, count] {
      work(count * part / threads, count * (part + 1) / threads);
    }));
  }
  work(0, count / threads);
}

}  // namespace seam::render
