// What objects are sent when they are connected, notified, or hear who is ready.
#ifndef SEAM_OPEN_R_OBJCOMM_MESSAGES_H
#define SEAM_OPEN_R_OBJCOMM_MESSAGES_H

#include <OPENR/ObjcommTypes.h>
#include <OPENR/RCRegion.h>

// At init, start, stop and destroy.
struct OReasonMessage {
  OReason reason;
  size_t paramSize;
  byte param[oreasonPARAM_MAX_SIZE];

  explicit OReasonMessage(OReason r) : reason(r), paramSize(0) { param[0] = 0; }
};

// To a subject: an observer is to be added. The subject answers with its own identity.
struct OControlMessage {
  ObjcommCommand command;
  ObserverID observerID;
  size_t skip, min, max;  // As OObserver::SetBufCtrlParam.
  char subName[oserviceNAME_MAX + 1];
  mutable SubjectID answer;

  OControlMessage() : command(objcommCMD_ADDOBSERVER), skip(0), min(1), max(1) { subName[0] = 0; }
};

// To an observer: the control entry of the subject that it is connected to.
struct OConnectMessage {
  OConnectCmd command;
  OServiceEntry entry;
  char subName[oserviceNAME_MAX + 1];

  OConnectMessage() : command(oconnectcmdCONNECT) { subName[0] = 0; }
};

// To a subject: whether an observer is ready.
struct OReadyMessage {
  ObjcommCommand command;
  ObserverID observerID;

  OReadyMessage(ObjcommCommand c, const ObserverID& id) : command(c), observerID(id) {}
};

// To an observer: data. The message holds a reference to each region while it is on its way.
struct ONotifyMessage {
  SubjectID subjectID;
  int numOfData, numOfNotify;
  RCRegion* data[MAX_NUM_DATA];

  ONotifyMessage() : numOfData(0), numOfNotify(0) {}
};

#endif
