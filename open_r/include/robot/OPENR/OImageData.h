// Images in layers of three sizes, and the colour detection table's layer.
#ifndef SEAM_OPEN_R_OIMAGE_DATA_H
#define SEAM_OPEN_R_OIMAGE_DATA_H

#include <OPENR/ODataVector.h>

typedef int OFbkImageLayer;
const OFbkImageLayer ofbkimageLAYER_H = 0;
const OFbkImageLayer ofbkimageLAYER_M = 1;
const OFbkImageLayer ofbkimageLAYER_L = 2;
const OFbkImageLayer ofbkimageLAYER_C = 3;  // Colours detected.

struct OFbkImageInfo {
  ODataType type;
  OPrimitiveID primitiveID;
  longword frameNumber;
  size_t dataOffset;
  size_t dataSize;
  size_t width;
  size_t height;
  size_t padding[1];
};

struct OFbkImageVectorData {
  ODataVectorInfo vectorInfo;
  OFbkImageInfo info[1];

  void SetPrimitiveID(OPrimitiveID id) {
    for (size_t i = 0; i < vectorInfo.numData; ++i) info[i].primitiveID = id;
  }
  OFbkImageInfo* GetInfo(int i) { return info + i; }
  byte* GetData(int i) { return reinterpret_cast<byte*>(this) + info[i].dataOffset; }
};

// ---- Colour detection table: for each of 32 ranges of Y a rectangle of Cr and Cb ----
const int ocdtNUM_CHANNELS = 8;
const int ocdtMAX_Y_SEGMENT = 32;
typedef longword OCdtChannel;  // The bit that a channel has in the colour layer.
const OCdtChannel ocdtCHANNEL_UNDEF = 0x00;
const OCdtChannel ocdtCHANNEL0 = 0x01;
const OCdtChannel ocdtCHANNEL1 = 0x02;
const OCdtChannel ocdtCHANNEL2 = 0x04;
const OCdtChannel ocdtCHANNEL3 = 0x08;
const OCdtChannel ocdtCHANNEL4 = 0x10;
const OCdtChannel ocdtCHANNEL5 = 0x20;
const OCdtChannel ocdtCHANNEL6 = 0x40;
const OCdtChannel ocdtCHANNEL7 = 0x80;

// A word of the table, from its highest byte: Cb max, Cb min, Cr max, Cr min.
const longword ocdtCb_MAX_MASK = 0xff000000;
const longword ocdtCb_MIN_MASK = 0x00ff0000;
const longword ocdtCr_MAX_MASK = 0x0000ff00;
const longword ocdtCr_MIN_MASK = 0x000000ff;
const longword ocdtINIT = 0x80808080;

struct OCdtInfo {
  ODataType type;
  OPrimitiveID primitiveID;
  OCdtChannel channel;
  longword table[ocdtMAX_Y_SEGMENT];
  longword padding;

  void Init(OPrimitiveID camera, OCdtChannel bit) {
    type = odataCDT;
    primitiveID = camera;
    channel = bit;
    for (int y = 0; y < ocdtMAX_Y_SEGMENT; ++y) table[y] = ocdtINIT;
  }
  void Set(int y, byte cr_max, byte cr_min, byte cb_max, byte cb_min) {
    table[y] = static_cast<longword>(cb_max) << 24 | static_cast<longword>(cb_min) << 16 |
               static_cast<longword>(cr_max) << 8 | cr_min;
  }
};

struct OCdtVectorData {
  ODataVectorInfo vectorInfo;
  OCdtInfo info[ocdtNUM_CHANNELS];

  void SetNumData(size_t count) { vectorInfo.numData = count; }
  OCdtInfo* GetInfo(int i) { return info + i; }
};

#endif
