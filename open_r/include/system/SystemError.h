// Results of calls to the system.
#ifndef SEAM_OPEN_R_SYSTEM_ERROR_H
#define SEAM_OPEN_R_SYSTEM_ERROR_H

#include <Types.h>

typedef longword sError;
const sError sSUCCESS = 0;
const sError sUNDEF = 1;
const sError sFAIL = 2;
const sError sINVALIDARG = 3;
const sError sNOMEMORY = 4;

#endif
