// Entry points of a hand-written stub.
#ifndef SEAM_OPEN_R_APSYS_H
#define SEAM_OPEN_R_APSYS_H

#include <ObjectEntryTable.h>

// The name of an entry point stands for its function.
#define GEN_ENTRY(entry, function) static const Entry entry = (Entry)(function)

#endif
