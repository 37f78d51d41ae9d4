// The identity of an object.
#ifndef SEAM_OPEN_R_OID_H
#define SEAM_OPEN_R_OID_H

#include <Types.h>

class OID {
 public:
  OID() : value_(UNDEF) {}
  explicit OID(longword value) : value_(value) {}

  bool IsValid() const { return value_ != UNDEF; }
  void MakeInvalid() { value_ = UNDEF; }
  longword Value() const { return value_; }

  bool operator==(const OID& other) const { return value_ == other.value_; }
  bool operator!=(const OID& other) const { return value_ != other.value_; }
  bool operator<(const OID& other) const { return value_ < other.value_; }

 private:
  longword value_;
};

#endif
