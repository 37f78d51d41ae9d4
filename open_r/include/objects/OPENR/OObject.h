// The base of each object: a program of its own, which reacts to messages one after the other.
#ifndef SEAM_OPEN_R_OOBJECT_H
#define SEAM_OPEN_R_OOBJECT_H

#include <OPENR/OPENREvent.h>
#include <OPENR/OPENRMessages.h>
#include <OPENR/OSyslog.h>

class OObject {
 public:
  OObject();
  virtual ~OObject();

  // Called by the system; each calls its Do function.
  void Init(const OSystemEvent& event);
  void Start(const OSystemEvent& event);
  void Stop(const OSystemEvent& event);
  void Destroy(const OSystemEvent& event);

  // DoStart follows when each object has done DoInit, DoDestroy when each has done DoStop.
  virtual OStatus DoInit(const OSystemEvent& event);
  virtual OStatus DoStart(const OSystemEvent& event);
  virtual OStatus DoStop(const OSystemEvent& event);
  virtual OStatus DoDestroy(const OSystemEvent& event);

 protected:
  OStatus RegisterServiceEntry(const OServiceEntry& entry, const char* name);

  OID myOID_;

 private:
  OObject(const OObject&);
  OObject& operator=(const OObject&);
};

#endif
