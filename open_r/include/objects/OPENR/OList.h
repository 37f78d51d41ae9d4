// A list of at most MaxSize elements.
#ifndef SEAM_OPEN_R_OLIST_H
#define SEAM_OPEN_R_OLIST_H

#include <OPENR/OTLStatus.h>

#include <list>

template <class T, int MaxSize>
class OList {
 public:
  class Iterator {
   public:
    Iterator() {}
    bool operator==(const Iterator& other) const { return at_ == other.at_; }
    bool operator!=(const Iterator& other) const { return at_ != other.at_; }
    T& operator*() const { return *at_; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator& operator--() {
      --at_;
      return *this;
    }
    Iterator operator++(int) { return Iterator(at_++); }
    Iterator operator--(int) { return Iterator(at_--); }

   private:
    friend class OList<T, MaxSize>;
    explicit Iterator(typename std::list<T>::iterator at) : at_(at) {}
    typename std::list<T>::iterator at_;
  };

  OTLStatus PushFront(const T& item) { return Insert(Begin(), item); }
  OTLStatus PushBack(const T& item) { return Insert(End(), item); }
  OTLStatus PopFront() { return items_.empty() ? otlUNDERFLOW : Erase(Begin()); }
  OTLStatus PopBack() { return items_.empty() ? otlUNDERFLOW : Erase(--End()); }
  // Of an empty list a value that belongs to nobody.
  T& Front() { return items_.empty() ? none_ = T() : items_.front(); }
  T& Back() { return items_.empty() ? none_ = T() : items_.back(); }
  void Clear() { items_.clear(); }
  int GetSize() const { return static_cast<int>(items_.size()); }
  int GetMaxSize() const { return MaxSize; }

  Iterator Begin() { return Iterator(items_.begin()); }
  Iterator End() { return Iterator(items_.end()); }
  OTLStatus Insert(Iterator before, const T& item) {
    if (GetSize() == MaxSize) return otlOVERFLOW;
    items_.insert(before.at_, item);
    return otlSUCCESS;
  }
  OTLStatus Erase(Iterator at) {
    if (items_.empty()) return otlUNDERFLOW;
    if (at == End()) return otlFAIL;
    items_.erase(at.at_);
    return otlSUCCESS;
  }

 private:
  std::list<T> items_;
  T none_;
};

#endif
