#include "app/session/memory_watch.h"

#include <unistd.h>

#include <cstdio>
#include <memory>

namespace seam::app {

namespace {

constexpr SimDuration kPeriod = SimDuration::from_ns(10'000'000'000);

}  // namespace

uint64_t resident_bytes() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/proc/self/statm", "r"),
                                                             std::fclose);
  unsigned long long total = 0, resident = 0;
  if (!file || std::fscanf(file.get(), "%llu %llu", &total, &resident) != 2) return 0;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void MemoryWatch::on_step(SimTime time, uint64_t, const StateDigest&) {
  if (time < next_) return;
  samples_.push_back({time.s(), resident_bytes()});
  next_ = next_ + kPeriod;
}

}  // namespace seam::app
