// Pointers to regions of memory that count their references.
#ifndef SEAM_OPEN_R_OSHMPTR_H
#define SEAM_OPEN_R_OSHMPTR_H

#include <OPENR/RCRegion.h>

class OShmPtrBase {
 public:
  OShmPtrBase() : region_(0) {}
  OShmPtrBase(const OShmPtrBase& p) : region_(p.region_) { Take(); }
  explicit OShmPtrBase(RCRegion* region) : region_(region) { Take(); }
  ~OShmPtrBase() { Deallocate(); }
  OShmPtrBase& operator=(const OShmPtrBase& p) {
    OShmPtrBase old(*this);
    Deallocate();
    region_ = p.region_;
    Take();
    return *this;
  }

  void Deallocate() {
    if (region_ != 0) region_->RemoveReference();
    region_ = 0;
  }
  char* Base() const { return region_ == 0 ? 0 : region_->Base(); }
  size_t Size() const { return region_ == 0 ? 0 : region_->Size(); }
  MemoryRegionID MemID() const { return region_ == 0 ? UNDEF : region_->MemID(); }
  offset_t Offset() const { return region_ == 0 ? 0 : region_->Offset(); }
  RCRegion* RCRPtr() const { return region_; }

 protected:
  void Take() {
    if (region_ != 0) region_->AddReference();
  }
  // Makes the region this pointer's own before it is written.
  void MakeOwn() {
    if (region_ == 0 || region_->NumberOfReference() == 1) return;
    RCRegion* copy = new RCRegion(region_->Size());
    memcpy(copy->Base(), region_->Base(), region_->Size());
    region_->RemoveReference();
    region_ = copy;
  }

  RCRegion* region_;
};

template <class T>
class OShmPtr : public OShmPtrBase {
 public:
  // What an element is assigned through: a region that others hold is copied first.
  class Proxy {
   public:
    Proxy(OShmPtr<T>& pointer, int index) : pointer_(pointer), index_(index) {}
    Proxy& operator=(const T& value) {
      pointer_.MakeOwn();
      reinterpret_cast<T*>(pointer_.Base())[index_] = value;
      return *this;
    }
    operator T() const { return reinterpret_cast<const T*>(pointer_.Base())[index_]; }

   private:
    OShmPtr<T>& pointer_;
    int index_;
  };

  OShmPtr() {}
  OShmPtr(const OShmPtr<T>& p) : OShmPtrBase(p) {}
  OShmPtr(const OShmPtrBase& p) : OShmPtrBase(p) {}
  explicit OShmPtr(RCRegion* region) : OShmPtrBase(region) {}
  explicit OShmPtr(size_t count) { Allocate(static_cast<int>(count)); }
  OShmPtr<T>& operator=(const OShmPtr<T>& p) {
    OShmPtrBase::operator=(p);
    return *this;
  }
  OShmPtr<T>& operator=(const OShmPtrBase& p) {
    OShmPtrBase::operator=(p);
    return *this;
  }

  void Allocate(int count) {
    Deallocate();
    region_ = new RCRegion(static_cast<size_t>(count) * sizeof(T));
  }
  size_t NumOfElement() const { return OShmPtrBase::Size() / sizeof(T); }
  const T& operator*() const { return (*this)[0]; }
  Proxy operator*() { return Proxy(*this, 0); }
  const T& operator[](int i) const { return reinterpret_cast<const T*>(Base())[i]; }
  Proxy operator[](int i) { return Proxy(*this, i); }
  const T* operator->() const { return reinterpret_cast<const T*>(Base()); }
};

#endif
