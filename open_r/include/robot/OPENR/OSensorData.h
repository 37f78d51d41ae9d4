// What the robot senses: four frames of 8 ms in a vector.
#ifndef SEAM_OPEN_R_OSENSOR_DATA_H
#define SEAM_OPEN_R_OSENSOR_DATA_H

#include <OPENR/ODataVector.h>

const size_t osensorframeMAX_FRAMES = 16;
const word osensorframeINVALID_SIGNAL = 0xffff;
const slongword opsdINVALID_VALUE = 0;

typedef longword OSwitchValue;
const OSwitchValue oswitchOFF = 0;
const OSwitchValue oswitchON = 1;

// One frame of any sensor; cast to those below. Values are in millionths of their unit.
struct OSensorValue {
  slongword value;
  word signal;
  word padding[5];
};
struct OAcceleration : OSensorValue {};     // m/s^2
struct OAngularVelocity : OSensorValue {};  // rad/s
struct OTemperature : OSensorValue {};      // degrees Celsius
struct OForce : OSensorValue {};            // N
struct OPressure : OSensorValue {};         // Pa
struct OLength : OSensorValue {};           // m
struct OSwitchStatus {
  OSwitchValue value;
  word signal;
  word padding[5];
};

struct OJointValue {
  slongword value;  // Micro-radians, measured.
  word signal;
  sword pwmDuty;
  slongword refValue;  // Micro-radians, commanded.
  word refSignal;
  word padding[1];

  OJointValue() {}
  OJointValue(slongword v, word s, sword duty, slongword reference, word reference_signal)
      : value(v), signal(s), pwmDuty(duty), refValue(reference), refSignal(reference_signal) {}
};

struct OSensorFrameInfo : SeamFrameInfo {};

struct OSensorFrameData {
  OSensorValue frame[osensorframeMAX_FRAMES];
};

struct OSensorFrameVectorData : SeamFrameVector<OSensorFrameInfo, OSensorFrameData> {};

#endif
