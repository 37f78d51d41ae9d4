// Printing for debugging.
#ifndef SEAM_OPEN_R_ODEBUG_H
#define SEAM_OPEN_R_ODEBUG_H

#include <stdio.h>

#define PRINTF(x) (printf x)
#ifdef OPENR_DEBUG
#define ODEBUG(x) (x)
#define DPRINTF(x) (printf x)
#else
#define ODEBUG(x)
#define DPRINTF(x)
#endif

#endif
