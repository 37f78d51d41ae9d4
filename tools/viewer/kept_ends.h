// The first and the last of a list that may be too long to keep: how it began, and how it ended.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

namespace seam::tools {

template <class T>
class KeptEnds {
 public:
  // `most`: so many in all, half of them from each end.
  explicit KeptEnds(size_t most) : half_(most / 2) {}

  void push(T item) {
    if (first_.size() < half_) {
      first_.push_back(std::move(item));
      return;
    }
    last_.push_back(std::move(item));
    if (last_.size() <= half_) return;
    last_.pop_front();
    ++left_out_;
  }
  // How many lie between the two ends.
  uint64_t left_out() const { return left_out_; }
  // Both ends in their order, emptied. Where something lies between, `between` stands there: it is
  // made of the item before it and the number that is left out.
  template <class Between>
  std::vector<T> take(const Between& between) {
    std::vector<T> all = std::exchange(first_, {});
    if (left_out_ > 0) all.push_back(between(all.back(), left_out_));
    for (T& item : last_) all.push_back(std::move(item));
    last_.clear();
    return all;
  }

 private:
  size_t half_;
  std::vector<T> first_;
  std::deque<T> last_;
  uint64_t left_out_ = 0;
};

}  // namespace seam::tools
