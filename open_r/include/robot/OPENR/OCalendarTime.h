// The robot's clock as a date.
#ifndef SEAM_OPEN_R_OCALENDAR_TIME_H
#define SEAM_OPEN_R_OCALENDAR_TIME_H

#include <OPENR/OTime.h>

class OCalendarTime {
 public:
  OCalendarTime() { SetTime(0, 0); }
  OCalendarTime(time_t clock, sbyte difference) { SetTime(clock, difference); }
  OCalendarTime(const OTime& time) { SetTime(time); }

  OStatus SetTime(time_t clock, sbyte difference) { return SetTime(OTime(clock, difference)); }
  OStatus SetTime(const OTime& time);
  OStatus GetTime(OTime* time) const;
  OStatus GetTime(time_t* clock, sbyte* difference) const;
  void Print() const;
  void Sprint(char* text) const;  // "2000/01/01 00:00:00", 20 bytes.

  int year_, month_, day_, hour_, min_, sec_;
  int dow_;  // The day of the week; 0 is a Sunday.
  sbyte timeDif_;
};

#endif
