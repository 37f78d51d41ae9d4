// Numbers of fixed size by OPEN-R's names. A `longword` has 32 bits, whatever the machine.
#ifndef SEAM_OPEN_R_TYPES_H
#define SEAM_OPEN_R_TYPES_H

#include <stddef.h>
#include <sys/types.h>

typedef unsigned char byte;
typedef signed char sbyte;
typedef unsigned short word;
typedef signed short sword;
typedef unsigned int longword;
typedef signed int slongword;

typedef longword MemoryRegionID;
typedef unsigned int offset_t;

// Numbers an entry point of an object.
typedef longword Selector;
const Selector UNDEF = 0xffffffff;

// An entry point: called with the message that it is sent.
typedef void (*Entry)(void*);

#endif
