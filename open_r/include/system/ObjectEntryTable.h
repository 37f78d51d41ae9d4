// The table through which an object is called: by it, a hand-written stub names its entry points.
#ifndef SEAM_OPEN_R_OBJECT_ENTRY_TABLE_H
#define SEAM_OPEN_R_OBJECT_ENTRY_TABLE_H

#include <Types.h>

struct ObjectEntry {
  Selector selector;
  Entry entry;
};

// Ends with a row of UNDEF.
extern "C" ObjectEntry ObjectEntryTable[];

// Never called: constructors of globals run when an object is loaded.
extern "C" void Prologue(void*);
#define ENTRY_UNDEF ((Entry)Prologue)

#endif
