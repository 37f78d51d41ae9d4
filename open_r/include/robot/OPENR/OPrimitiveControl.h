// Requests to single primitives: the speaker's kind of sound, the camera's settings.
#ifndef SEAM_OPEN_R_OPRIMITIVE_CONTROL_H
#define SEAM_OPEN_R_OPRIMITIVE_CONTROL_H

#include <OPENR/ODataFormats.h>

// ---- Speaker ----
const OPrimitiveRequest oprmreqSPEAKER_MUTE_ON = 128;
const OPrimitiveRequest oprmreqSPEAKER_MUTE_OFF = 129;
const OPrimitiveRequest oprmreqSPEAKER_SET_VOLUME = 130;
const OPrimitiveRequest oprmreqSPEAKER_SET_SOUND_TYPE = 131;
const OPrimitiveRequest oprmreqSPEAKER_GET_SOUND_TYPE = 132;
const OPrimitiveRequest oprmreqSPEAKER_SET_VOLUME_MIDI = 133;
const OPrimitiveRequest oprmreqSPEAKER_MASTER_TUNING_MIDI = 134;

typedef longword OSpeakerSoundType;
const OSpeakerSoundType ospksndMONO8K8B = 0;
const OSpeakerSoundType ospksndMONO11K8B = 1;
const OSpeakerSoundType ospksndMONO16K8B = 2;
const OSpeakerSoundType ospksndMONO16K16B = 3;
const OSpeakerSoundType ospksndSTEREO16K16B = 4;

typedef longword OSpeakerVolume;
const OSpeakerVolume ospkvolinfdB = 0x8000;
const OSpeakerVolume ospkvol25dB = 0xe700;
const OSpeakerVolume ospkvol18dB = 0xee00;
const OSpeakerVolume ospkvol10dB = 0xf600;

struct OPrimitiveControl_SpeakerVolume {
  longword volume;
  OPrimitiveControl_SpeakerVolume(longword v) : volume(v) {}
};
struct OPrimitiveControl_SpeakerSoundType {
  OSpeakerSoundType type;
  OPrimitiveControl_SpeakerSoundType(OSpeakerSoundType t = ospksndMONO8K8B) : type(t) {}
};

// ---- Microphone ----
const OPrimitiveRequest oprmreqMIC_UNI = 256;
const OPrimitiveRequest oprmreqMIC_OMNI = 257;
const OPrimitiveRequest oprmreqMIC_ALC_ON = 258;
const OPrimitiveRequest oprmreqMIC_ALC_OFF = 259;

// ---- Camera ----
const OPrimitiveRequest oprmreqCAM_SET_WHITE_BALANCE = 384;
const OPrimitiveRequest oprmreqCAM_SET_GAIN = 385;
const OPrimitiveRequest oprmreqCAM_SET_SHUTTER_SPEED = 386;
const OPrimitiveRequest oprmreqCAM_AE_ON = 388;
const OPrimitiveRequest oprmreqCAM_AE_OFF = 389;
const OPrimitiveRequest oprmreqCAM_AWB_ON = 390;
const OPrimitiveRequest oprmreqCAM_AWB_OFF = 391;

const longword ocamparamUNDEF = 0;
const longword ocamparamWB_INDOOR_MODE = 1;
const longword ocamparamWB_OUTDOOR_MODE = 2;
const longword ocamparamWB_FL_MODE = 3;
const longword ocamparamGAIN_LOW = 1;
const longword ocamparamGAIN_MID = 2;
const longword ocamparamGAIN_HIGH = 3;
const longword ocamparamSHUTTER_SLOW = 1;  // 1/50 s
const longword ocamparamSHUTTER_MID = 2;   // 1/100 s
const longword ocamparamSHUTTER_FAST = 3;  // 1/200 s

struct OPrimitiveControl_CameraParam {
  longword camparam;
  OPrimitiveControl_CameraParam(longword p = ocamparamUNDEF) : camparam(p) {}
};

// ---- Joints and LEDs ----
const OPrimitiveRequest oprmreqJOINT2_SET_COMMAND = 640;
const OPrimitiveRequest oprmreqJOINT2_GET_VALUE = 641;
const OPrimitiveRequest oprmreqLED2_SET_COMMAND = 768;
const OPrimitiveRequest oprmreqLED3_SET_COMMAND = 1024;

struct OPrimitiveControl_JointCommandValue2 {
  OJointCommandValue2 command;
  OPrimitiveControl_JointCommandValue2(slongword value) { command.value = value; }
};
struct OPrimitiveControl_JointValue {
  OJointValue jval;
};
struct OPrimitiveControl_LEDCommandValue2 {
  OLEDCommandValue2 command;
  OPrimitiveControl_LEDCommandValue2(OLEDValue value) {
    command.led = value;
    command.period = 0;
  }
};

#endif
