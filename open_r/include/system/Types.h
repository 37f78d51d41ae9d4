// Numbers of fixed size by OPEN-R's names. A `longword` has 32 bits, whatever the machine.
#ifndef SEAM_OPEN_R_TYPES_H
#define SEAM_OPEN_R_TYPES_H

// Programs of that time count on these without including them.
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/types.h>

typedef unsigned char byte;
typedef signed char sbyte;
typedef unsigned short word;
typedef signed short sword;
typedef unsigned int longword;
typedef signed int slongword;

typedef int int32;
typedef unsigned int uint32;
typedef short int16;
typedef unsigned short uint16;
typedef signed char int8;
typedef unsigned char uint8;

typedef longword MemoryRegionID;
typedef unsigned int offset_t;

// Numbers an entry point of an object.
typedef longword Selector;
const Selector UNDEF = 0xffffffff;

// An entry point: called with the message that it is sent.
typedef void (*Entry)(void*);

// Names that the robot's C library has for functions of POSIX.
inline int stricmp(const char* a, const char* b) {
  return strcasecmp(a, b);
}
inline int strnicmp(const char* a, const char* b, size_t most) {
  return strncasecmp(a, b, most);
}

// A function that is declared but refused: the compiler says why where it is called.
#define SEAM_OPEN_R_REFUSED(why) __attribute__((error(why)))

#endif
