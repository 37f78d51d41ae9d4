// What a subject's observers are kept in: OSubject's begin() and end() go through it.
#ifndef SEAM_OPEN_R_OOBSERVER_VECTOR_H
#define SEAM_OPEN_R_OOBSERVER_VECTOR_H

#include <OPENR/OSubject.h>

#endif
