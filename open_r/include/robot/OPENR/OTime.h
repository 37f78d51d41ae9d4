// The robot's clock. It begins at 2000-01-01 00:00 with the run, and goes with simulated time.
#ifndef SEAM_OPEN_R_OTIME_H
#define SEAM_OPEN_R_OTIME_H

#include <OPENR/OStatus.h>
#include <time.h>

const sbyte otimeTIME_DIF_UNDEF = 0x7F;
const int otimeSTART_YEAR = 2000;

// Seconds since 2000-01-01 00:00 UTC, and the hours by which local time differs.
class OTime {
 public:
  OTime() : clock_(0), difference_(otimeTIME_DIF_UNDEF) {}
  OTime(time_t clock, sbyte difference) : clock_(clock), difference_(difference) {}

  OStatus Set(time_t clock, sbyte difference) {
    *this = OTime(clock, difference);
    return oSUCCESS;
  }
  OStatus SetClock(time_t clock) { return Set(clock, difference_); }
  OStatus SetLocalTime(time_t local) { return Set(local - shift(), difference_); }
  OStatus SetTimeDif(sbyte difference) { return Set(clock_, difference); }
  time_t GetClock() const { return clock_; }
  time_t GetLocalTime() const { return clock_ + shift(); }
  sbyte GetTimeDif() const { return difference_; }

  bool operator<(const OTime& t) const { return clock_ < t.clock_; }
  bool operator<=(const OTime& t) const { return clock_ <= t.clock_; }
  bool operator>(const OTime& t) const { return clock_ > t.clock_; }
  bool operator>=(const OTime& t) const { return clock_ >= t.clock_; }
  bool operator==(const OTime& t) const { return clock_ == t.clock_; }

 private:
  time_t shift() const { return difference_ == otimeTIME_DIF_UNDEF ? 0 : 3600 * difference_; }

  time_t clock_;
  sbyte difference_;
};

#endif
