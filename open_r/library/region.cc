// RCRegion: memory with a count of references.
#include <OPENR/RCRegion.h>

#include "open_r/library/system.h"

using seam::open_r::System;

RCRegion::RCRegion()
    : references_(1), owner_(false), id_(UNDEF), offset_(0), base_(nullptr), size_(0) {}

RCRegion::RCRegion(size_t size)
    : references_(1),
      owner_(true),
      id_(System::current().next_region()),
      offset_(0),
      base_(static_cast<char*>(::operator new(size))),
      size_(size) {
  memset(base_, 0, size);
}

RCRegion::RCRegion(MemoryRegionID id, offset_t offset, void* base, size_t size)
    : references_(1),
      owner_(false),
      id_(id),
      offset_(offset),
      base_(static_cast<char*>(base)),
      size_(size) {}

RCRegion::~RCRegion() {
  if (owner_) ::operator delete(base_);
}

void RCRegion::AddReference() {
  ++references_;
}

void RCRegion::RemoveReference() {
  if (--references_ == 0) delete this;
}
