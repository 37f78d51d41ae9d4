// Names of the network's interface.
#ifndef SEAM_OPEN_R_ANT_TYPES_H
#define SEAM_OPEN_R_ANT_TYPES_H

#include <OID.h>

#include <iostream>

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
