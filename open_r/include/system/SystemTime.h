// Simulated time since the run began: the same in each repetition of a run.
#ifndef SEAM_OPEN_R_SYSTEM_TIME_H
#define SEAM_OPEN_R_SYSTEM_TIME_H

#include <SystemError.h>

struct SystemTime {
  longword seconds;
  longword useconds;

  SystemTime() : seconds(0), useconds(0) {}
  SystemTime(longword s, longword us) : seconds(s), useconds(us) {}

  bool operator==(const SystemTime& t) const {
    return seconds == t.seconds && useconds == t.useconds;
  }
  bool operator!=(const SystemTime& t) const { return !(*this == t); }
  bool operator<(const SystemTime& t) const {
    return seconds != t.seconds ? seconds < t.seconds : useconds < t.useconds;
  }
  bool operator>(const SystemTime& t) const { return t < *this; }
  bool operator<=(const SystemTime& t) const { return !(t < *this); }
  bool operator>=(const SystemTime& t) const { return !(*this < t); }
  SystemTime& operator+=(const SystemTime& t) {
    const longword sum = useconds + t.useconds;
    seconds += t.seconds + sum / 1000000;
    useconds = sum % 1000000;
    return *this;
  }
  SystemTime& operator-=(const SystemTime& t) {
    seconds -= t.seconds + (useconds < t.useconds ? 1 : 0);
    useconds += (useconds < t.useconds ? 1000000 : 0) - t.useconds;
    return *this;
  }
  SystemTime operator+(const SystemTime& t) const { return SystemTime(*this) += t; }
  SystemTime operator-(const SystemTime& t) const { return SystemTime(*this) -= t; }
};

extern "C" sError GetSystemTime(SystemTime* time);

#endif
