// Archives of sounds and motions: the marks of their parts. The functions that read one are
// refused: programs that have an archive read it by code of their own.
#ifndef SEAM_OPEN_R_ODATA_ARCHIVE_H
#define SEAM_OPEN_R_ODATA_ARCHIVE_H

#include <OPENR/OPENR.h>

const size_t odaMAX_SIZE = 32;

// Four letters, the first in the lowest byte.
typedef longword ODataArchiveMagic;
const ODataArchiveMagic odamagicUNDEF = 0xffffffff;
const ODataArchiveMagic odamagicODAR = 0x5241444f;
const ODataArchiveMagic odamagicOSND = 0x444e534f;
const ODataArchiveMagic odamagicOMTN = 0x4e544d4f;
const ODataArchiveMagic odamagicWAVE = 0x45564157;
const ODataArchiveMagic odamagicMIDI = 0x4944494d;
const ODataArchiveMagic odamagicLED = 0x0044454c;
const ODataArchiveMagic odamagicSYN = 0x004e5953;
const ODataArchiveMagic odamagicSTT = 0x00545453;

typedef longword ODataArchiveID;
const ODataArchiveID odaID_UNDEF = 0xffffffff;

namespace ODataArchive {
SEAM_OPEN_R_REFUSED("ODataArchive::New is refused: read the file of the archive")
OStatus New(MemoryRegionID region, void* archive, ODataArchiveID* id);
SEAM_OPEN_R_REFUSED("ODataArchive::Load is refused: read the file of the archive")
OStatus Load(char* path, ODataArchiveID* id);
}  // namespace ODataArchive

#endif
