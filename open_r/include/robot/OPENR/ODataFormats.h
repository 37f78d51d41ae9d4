// What travels between objects and the robot: a common header, a block of information for each
// element, then the elements.
#ifndef SEAM_OPEN_R_ODATA_FORMATS_H
#define SEAM_OPEN_R_ODATA_FORMATS_H

#include <OPENR/OCommandData.h>
#include <OPENR/OImageData.h>
#include <OPENR/OSensorData.h>
#include <OPENR/OSoundData.h>

#endif
