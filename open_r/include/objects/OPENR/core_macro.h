// What each object does with all its subjects and observers. `entry.h` is made from its stub.cfg.
#ifndef SEAM_OPEN_R_CORE_MACRO_H
#define SEAM_OPEN_R_CORE_MACRO_H

#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>

#include "entry.h"

#define SEAM_OPEN_R_EACH(count, statement) \
  do {                                     \
    for (int i_ = 0; i_ < (count); ++i_) { \
      statement;                           \
    }                                      \
  } while (0)

#define NEW_ALL_SUBJECT_AND_OBSERVER                               \
  do {                                                             \
    SEAM_OPEN_R_EACH(numOfSubject, subject[i_] = new OSubject);    \
    SEAM_OPEN_R_EACH(numOfObserver, observer[i_] = new OObserver); \
  } while (0)

#define REGISTER_ALL_ENTRY                                                                         \
  do {                                                                                             \
    SEAM_OPEN_R_EACH(numOfSubject, RegisterServiceEntry(OServiceEntry(myOID_, Entry_Control[i_]),  \
                                                        subjectService[i_]));                      \
    SEAM_OPEN_R_EACH(numOfObserver, RegisterServiceEntry(OServiceEntry(myOID_, Entry_Connect[i_]), \
                                                         observerService[i_]));                    \
  } while (0)

#define SET_ALL_READY_AND_NOTIFY_ENTRY                                                       \
  do {                                                                                       \
    SEAM_OPEN_R_EACH(numOfSubject,                                                           \
                     subject[i_]->SetReadyEntry(OServiceEntry(myOID_, Entry_Ready[i_])));    \
    SEAM_OPEN_R_EACH(numOfObserver,                                                          \
                     observer[i_]->SetNotifyEntry(OServiceEntry(myOID_, Entry_Notify[i_]))); \
  } while (0)

#define ASSERT_READY_TO_ALL_OBSERVER SEAM_OPEN_R_EACH(numOfObserver, observer[i_]->AssertReady())
#define DEASSERT_READY_TO_ALL_OBSERVER \
  SEAM_OPEN_R_EACH(numOfObserver, observer[i_]->DeassertReady())
#define ASSERT_TO_ALL_OBSERVER ASSERT_READY_TO_ALL_OBSERVER
#define DEASSERT_TO_ALL_OBSERVER DEASSERT_READY_TO_ALL_OBSERVER

// A subject needs nothing before it sends; where it is switched off, what waits goes.
#define ENABLE_ALL_SUBJECT \
  do {                     \
  } while (0)
#define DISABLE_ALL_SUBJECT SEAM_OPEN_R_EACH(numOfSubject, subject[i_]->ClearBuffer())

// Connections are taken apart with the process.
#define DELETE_ALL_SUBJECT_AND_OBSERVER \
  do {                                  \
  } while (0)

#endif
