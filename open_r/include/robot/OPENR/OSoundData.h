// Sound for the speaker and from the microphone. Nothing is heard in a simulation: a sound takes
// its time, and the microphone brings silence.
#ifndef SEAM_OPEN_R_OSOUND_DATA_H
#define SEAM_OPEN_R_OSOUND_DATA_H

#include <OPENR/ODataVector.h>

typedef word OSoundFormat;
const OSoundFormat osoundformatUNDEF = 0;
const OSoundFormat osoundformatPCM = 1;
const OSoundFormat osoundformatUSB_MIDI = 2;
const OSoundFormat osoundformatSMF = 3;

typedef word OSoundChannel;
const OSoundChannel osoundchannelUNDEF = 0;
const OSoundChannel osoundchannelMONO = 1;
const OSoundChannel osoundchannelSTEREO = 2;

struct OSoundInfo {
  ODataType type;
  OPrimitiveID primitiveID;
  longword frameNumber;
  size_t frameSize;
  size_t dataOffset;
  size_t maxDataSize;
  size_t dataSize;
  OSoundFormat format;
  OSoundChannel channel;
  word samplingRate;
  word bitsPerSample;
  size_t actualDataSize;
  longword padding[6];

  void Set(ODataType t, OPrimitiveID id, size_t size) {
    type = t;
    primitiveID = id;
    dataSize = size;
  }
};

struct OSoundSampleStereo16 {
  sword L;
  sword R;
};

struct OSoundVectorData {
  ODataVectorInfo vectorInfo;
  OSoundInfo info[1];

  void SetNumData(size_t count) { vectorInfo.numData = count; }
  OSoundInfo* GetInfo(int i) { return info + i; }
  byte* GetData(int i) { return reinterpret_cast<byte*>(this) + info[i].dataOffset; }
};

#endif
