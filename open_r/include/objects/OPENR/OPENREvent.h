// What DoInit, DoStart, DoStop and DoDestroy are called with.
#ifndef SEAM_OPEN_R_OPENREVENT_H
#define SEAM_OPEN_R_OPENREVENT_H

#include <OPENR/ObjcommEvent.h>

class OSystemEvent {
 public:
  OSystemEvent(OReason reason, void* param, size_t size)
      : reason_(reason), param_(param), size_(size) {}
  OReason Reason() const { return reason_; }
  const void* Param() const { return param_; }
  size_t ParamSize() const { return size_; }

 private:
  OReason reason_;
  void* param_;
  size_t size_;
};

#endif
