// What an object may ask of the system below OPEN-R. Each entry point ends by returning, so that
// the calls which end one on the robot do nothing here.
#ifndef SEAM_OPEN_R_MCOOP_H
#define SEAM_OPEN_R_MCOOP_H

#include <OID.h>
#include <SystemError.h>
#include <SystemTime.h>
#include <Types.h>

inline void Return() {}
inline void Exit() {}

// How a region of shared memory may be used. All objects are one process: it has no effect.
typedef longword MemoryProtectionInfo;
const MemoryProtectionInfo MEMPROTINFO_R = 1;
const MemoryProtectionInfo MEMPROTINFO_RW = 2;

extern "C" {
sError NewRegion(size_t size, void** base);
sError DeleteRegion(void* base);
sError NewSharedMemoryRegion(size_t size, MemoryProtectionInfo protection, MemoryRegionID* id,
                             void** base);
sError DeleteSharedMemoryRegion(MemoryRegionID id);
sError WhoAmI(OID* oid);
}

#endif
