// Names of the network's interface. Integers have the sizes that their names say.
#ifndef SEAM_OPEN_R_ANT_TYPES_H
#define SEAM_OPEN_R_ANT_TYPES_H

#include <OID.h>

#include <iostream>

typedef int int32;
typedef unsigned int uint32;
typedef short int16;
typedef unsigned short uint16;
typedef int boolean;
#ifndef FALSE
#define FALSE 0
#define TRUE 1
#endif

enum antError {
  ANT_SUCCESS = 0,
  ANT_FAIL = 1,
  ANT_NOMEMORY = 2,
  ANT_INVALIDPTR = 3,
  ANT_ENDPOINT_NOFACTORY = 27,
  ANT_NOT_INITIALIZED = 28
};

#endif
