// What a subject's observers are kept in: OSubject's begin() and end() go through it. Programs also
// have their observers by this name.
#ifndef SEAM_OPEN_R_OOBSERVER_VECTOR_H
#define SEAM_OPEN_R_OOBSERVER_VECTOR_H

#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>

typedef OObserver OObserverVector;

#endif
