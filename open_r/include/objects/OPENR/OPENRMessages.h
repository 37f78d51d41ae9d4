// All messages that an object may be sent.
#ifndef SEAM_OPEN_R_OPENRMESSAGES_H
#define SEAM_OPEN_R_OPENRMESSAGES_H

#include <OPENR/ODataFormats.h>
#include <OPENR/OPower.h>
#include <OPENR/ObjcommMessages.h>

#endif
