// How far a long computation is, for a person who waits: the threads that work count, one that
// shows it reads. Nothing that is computed reads a tally, and none knows the time.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>

namespace seam {

class WorkTally {
 public:
  struct Seen {
    std::string label;          // What goes on: "step 2: trying effects".
    std::string part;           // The part of it that is counted; empty: none.
    uint64_t number = 0;        // Of the part: another one counts from 0.
    uint64_t done = 0, of = 0;  // Of the part.
    bool at_most = false;       // It may end before.
    uint64_t steps = 0;         // Of all fits.
  };
  Seen seen() const;

 private:
  friend class Work;
  friend void say_work(const std::string& label);
  friend void count_fit_step();

  std::atomic<bool> taken_{false};
  std::atomic<uint64_t> done_{0}, steps_{0};
  mutable std::mutex mutex_;
  Seen seen_;  // But for what is atomic.
};

// From now on the computations of this process are counted there; null: nobody watches. Only while
// nothing is computed.
void watch_work(WorkTally* tally);

void say_work(const std::string& label);
void count_fit_step();

// A part of so many like pieces, as long as it lives. Of parts inside of parts the outermost is
// counted.
class Work {
 public:
  enum class Of { exactly, at_most };

  Work(const char* part, size_t of, Of how = Of::exactly);
  ~Work();
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  // One piece more is done.
  void done() const;
  // So many are, of pieces too small to be counted one by one.
  void done_so_far(uint64_t pieces) const;

 private:
  WorkTally* tally_;  // Null where nobody watches, or another part is counted.
};

}  // namespace seam
