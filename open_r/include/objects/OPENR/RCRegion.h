// A region of memory with a count of references. Who sees a count of 1 is the only one who holds
// it, and may write.
#ifndef SEAM_OPEN_R_RCREGION_H
#define SEAM_OPEN_R_RCREGION_H

#include <OPENR/OPENR.h>

class RCRegion {
 public:
  RCRegion();
  explicit RCRegion(size_t size);
  // A region that something else reserved, such as OPENR::NewCommandVectorData; it is not freed.
  RCRegion(MemoryRegionID memID, offset_t offset, void* base = 0, size_t size = 0);

  void AddReference();
  void RemoveReference();  // The last one deletes this.
  int NumberOfReference() const { return references_; }

  char* Base() const { return base_; }
  size_t Size() const { return size_; }
  MemoryRegionID MemID() const { return id_; }
  offset_t Offset() const { return offset_; }
  void SetSize(size_t size) { size_ = size; }
  static OStatus ReserveSharedMemory(size_t) { return oSUCCESS; }

 private:
  ~RCRegion();  // RemoveReference() does it.
  RCRegion(const RCRegion&);
  RCRegion& operator=(const RCRegion&);

  int references_;
  bool owner_;
  MemoryRegionID id_;
  offset_t offset_;
  char* base_;
  size_t size_;
};

typedef RCRegion RCRegionBase;

#endif
