// A header of the compiler of that time, without a namespace.
#ifndef SEAM_OPEN_R_MULTISET_H
#define SEAM_OPEN_R_MULTISET_H

#include <set>

using std::multiset;

#endif
