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

extern "C" {
sError NewRegion(size_t size, void** base);
sError DeleteRegion(void* base);
sError WhoAmI(OID* oid);
}

#endif
