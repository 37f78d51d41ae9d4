// Commands to joints and LEDs: up to 16 frames of 8 ms each.
#ifndef SEAM_OPEN_R_OCOMMAND_DATA_H
#define SEAM_OPEN_R_OCOMMAND_DATA_H

#include <OPENR/ODataVector.h>

const size_t ocommandMAX_FRAMES = 16;

// One frame of any command; cast to those below.
struct OCommandValue {
  slongword value[2];
};

struct OJointCommandValue2 {
  slongword value;  // Micro-radians.
  slongword padding;
};

// Ears: one of two positions.
typedef longword OJointValue3;
const OJointValue3 ojoint3_STATE_UNDEF = 0xffffffff;
const OJointValue3 ojoint3_STATE0 = 0;
const OJointValue3 ojoint3_STATE1 = 1;
struct OJointCommandValue3 {
  OJointValue3 value;
  word reserved;
  word padding;
};

typedef longword OJointValue4;
const OJointValue4 ojoint4_STATE_UNDEF = 0xffffffff;
const OJointValue4 ojoint4_STATE0 = 0;
const OJointValue4 ojoint4_STATE1 = 1;
struct OJointCommandValue4 {
  OJointValue4 value;
  word period;  // Frames.
  word reserved;
};

typedef longword OLEDValue;
const OLEDValue oledOFF = 0;
const OLEDValue oledON = 1;
struct OLEDCommandValue2 {
  OLEDValue led;
  word period;  // Frames.
  word reserved;
};

typedef word OLED3Mode;
const OLED3Mode oled3_MODE_UNDEF = 0xffff;
const OLED3Mode oled3_MODE_A = 0;
const OLED3Mode oled3_MODE_B = 1;
struct OLEDCommandValue3 {
  sword intensity;
  OLED3Mode mode;
  word period;  // Frames.
  word reserved;
};

struct OCommandInfo : SeamFrameInfo {};

struct OCommandData {
  OCommandValue value[ocommandMAX_FRAMES];
};

struct OCommandVectorData : SeamFrameVector<OCommandInfo, OCommandData> {};

#endif
