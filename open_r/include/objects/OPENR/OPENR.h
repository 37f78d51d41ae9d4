// Names that everything in OPEN-R shares: entries of objects, limits, identities of primitives.
#ifndef SEAM_OPEN_R_OPENR_H
#define SEAM_OPEN_R_OPENR_H

#include <MCOOP.h>
#include <OPENR/OStatus.h>

// ---- Entries ----
const Selector oentryINIT = 0;
const Selector oentrySTART = 1;
const Selector oentrySTOP = 2;
const Selector oentryDESTROY = 3;
const Selector oentryBASE = 4;  // The first that an object may use for its own entries.

// An entry of an object: where a message goes.
struct OServiceEntry {
  OID oid;
  Selector selector;

  OServiceEntry() : selector(UNDEF) {}
  OServiceEntry(OID o, Selector s) : oid(o), selector(s) {}

  void Set(OID o, Selector s) {
    oid = o;
    selector = s;
  }
  OID GetOID() const { return oid; }
  Selector GetSelector() const { return selector; }
  bool IsValid() const { return oid.IsValid() && selector != UNDEF; }
  void MakeInvalid() { *this = OServiceEntry(); }

  bool operator==(const OServiceEntry& e) const { return oid == e.oid && selector == e.selector; }
  bool operator!=(const OServiceEntry& e) const { return !(*this == e); }
  bool operator<(const OServiceEntry& e) const {
    return oid != e.oid ? oid < e.oid : selector < e.selector;
  }
};

// ---- Why an object is called at its start and end ----
typedef longword OReason;
const OReason oreasonUNDEF = 0xffffffff;
const OReason oreasonBOOT = 0;
const OReason oreasonSHUTDOWN = 1;
const int oreasonPARAM_MAX_SIZE = 128;

// ---- Limits of names, without the null at their ends ----
const int oserviceNAME_MAX = 127;
const int oobjectNAME_MAX = 63;
const int ovrNAME_MAX = 31;
const int ovrPATH_MAX = 127;
const int orobotdesignNAME_MAX = 31;
const int odesignkeywordNAME_MAX = 127;

// ---- Frames of 8 ms ----
const longword oframeMAX_NUMBER = 0x0ffffff0;
const longword oframeINVALID_NUMBER = 0xffffffff;

// ---- Primitives: joints, LEDs, sensors ----
typedef longword OPrimitiveID;
const OPrimitiveID oprimitiveID_UNDEF = 0xffffffff;
typedef longword OPrimitiveType;
typedef longword OSensorType;
typedef longword OPrimitiveRequest;
const OPrimitiveRequest oprmreqUNDEF = 0xffffffff;

// ---- Synchronised starts ----
typedef longword OVRSyncKey;
const OVRSyncKey ovrsynckeyUNDEF = 0xffffffff;
const size_t ovrsynckeyMAX_SIZE = 8;
const size_t ovrsynckeyMAX_NUM_DIVISION = 16;

// ---- The rest of the system ----
typedef longword ODesignDataID;
const ODesignDataID odesigndataID_UNDEF = 0xffffffff;
#define odesignkeywordCPUINFO "SYS_CPUINFO"
struct OCPUInfo {
  longword sclk;
  longword pclk;
  longword processorID;
  byte reserved[244];
};

typedef longword OMemoryStickStatus;
const OMemoryStickStatus omemorystickUNDEF = 0xffffffff;
const OMemoryStickStatus omemorystickNOT_EXIST = 0;
const OMemoryStickStatus omemorystickWRITE_PROTECTED = 1;
const OMemoryStickStatus omemorystickWRITABLE = 2;

typedef longword OFatal;
const OFatal ofatalUNDEF = 0xffffffff;
const OFatal ofatalMEMORY_STICK = 0;
const OFatal ofatalPAUSE_SW = 1;

typedef byte OVolumeSwitch;
const OVolumeSwitch ovolumeSW0 = 0;
const OVolumeSwitch ovolumeSW1 = 1;
const OVolumeSwitch ovolumeSW2 = 2;
const OVolumeSwitch ovolumeSW3 = 3;

#endif
