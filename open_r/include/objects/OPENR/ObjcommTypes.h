// Identities of those who talk to each other.
#ifndef SEAM_OPEN_R_OBJCOMM_TYPES_H
#define SEAM_OPEN_R_OBJCOMM_TYPES_H

#include <OPENR/OPENR.h>

#include <iostream>
#include <list>

// Programs of OPEN-R's time count on these names.
using std::cout;
using std::endl;
using std::list;
using std::ostream;

// The entry for ready messages of a subject, for notifications of an observer.
typedef OServiceEntry SubjectID;
typedef OServiceEntry ObserverID;

typedef int ObjcommCommand;
const ObjcommCommand objcommCMD_UNDEF = 0;
const ObjcommCommand objcommCMD_ADDOBSERVER = 1;
const ObjcommCommand objcommCMD_REMOVEOBSERVER = 2;
const ObjcommCommand objcommCMD_ASSERT_READY = 3;
const ObjcommCommand objcommCMD_DEASSERT_READY = 4;

typedef longword OConnectCmd;
const OConnectCmd oconnectcmdCONNECT = 0;
const OConnectCmd oconnectcmdDISCONNECT = 1;
const OConnectCmd oconnectcmdDISCONNECTALL = 2;

// The most data that one notification brings.
#define MAX_NUM_DATA 13

#endif
