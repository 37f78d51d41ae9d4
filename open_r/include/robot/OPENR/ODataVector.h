// The header that all data for and from the robot begin with.
#ifndef SEAM_OPEN_R_ODATA_VECTOR_H
#define SEAM_OPEN_R_ODATA_VECTOR_H

#include <OPENR/OPENR.h>
#include <OPENR/OUnits.h>

typedef longword ODataType;
const ODataType odataUNDEF = 0;
const ODataType odataLENGTH = 2;
const ODataType odataFORCE = 8;
const ODataType odataACCELERATION = 9;
const ODataType odataANGULAR_VELOCITY = 10;
const ODataType odataTEMPERATURE = 11;
const ODataType odataPRESSURE = 12;
const ODataType odataSWITCH = 14;
const ODataType odataLED = 15;
const ODataType odataSOUND = 16;
const ODataType odataIMAGE = 17;
const ODataType odataJOINT_VALUE = 18;
const ODataType odataFBK_YCrCb = 19;
const ODataType odataFBK_CDT = 20;
const ODataType odataCDT = 21;
const ODataType odataFBK_YCrCb_HPF = 24;
const ODataType odataJOINT_COMMAND2 = 259;
const ODataType odataLED_COMMAND2 = 260;
const ODataType odataJOINT_COMMAND3 = 261;
const ODataType odataJOINT_COMMAND4 = 262;
const ODataType odataLED_COMMAND3 = 263;
const ODataType odataCOMMAND_VECTOR = 1024;
const ODataType odataSENSOR_FRAME_VECTOR = 1025;
const ODataType odataSOUND_VECTOR = 1026;
const ODataType odataFBKIMAGE_VECTOR = 1027;
const ODataType odataCDT_VECTOR = 1028;

const size_t odataOPTIONAL_MAX = 128;

struct ODataVectorInfo {
  MemoryRegionID memRegionID;
  void* physAddr;
  size_t offset;
  size_t totalSize;
  ODataType type;
  size_t infoOffset;
  size_t infoSize;
  size_t maxNumData;
  size_t numData;
  OVRSyncKey syncKey;
  longword wait;  // Frames before a command or a sound begins.
  size_t optOffset;
  size_t optSize;
  longword padding[3];
  byte optional[odataOPTIONAL_MAX];
};

// A block of information for each primitive that commands or sensor values are of.
struct SeamFrameInfo {
  ODataType type;
  OPrimitiveID primitiveID;
  longword frameNumber;
  size_t numFrames;
  size_t frameSize;
  size_t dataOffset;
  size_t dataSize;
  longword padding[1];

  void Set(ODataType t, OPrimitiveID id, size_t frames) {
    type = t;
    primitiveID = id;
    numFrames = frames;
  }
};

// The blocks, and behind them the frames of each.
template <class Info, class Data>
struct SeamFrameVector {
  ODataVectorInfo vectorInfo;
  Info info[1];

  void SetNumData(size_t count) { vectorInfo.numData = count; }
  Info* GetInfo(int i) { return info + i; }
  Data* GetData(int i) {
    return reinterpret_cast<Data*>(reinterpret_cast<byte*>(this) + info[i].dataOffset);
  }
};

#endif
