// The network's interface.
#ifndef SEAM_OPEN_R_ANT_H
#define SEAM_OPEN_R_ANT_H

#include <antEnvMsg.h>

#endif
