// The receiving end of a connection.
#ifndef SEAM_OPEN_R_OOBSERVER_H
#define SEAM_OPEN_R_OOBSERVER_H

#include <OPENR/ObjcommEvent.h>

typedef std::list<OSubjectInfo>::iterator SubjectIterator;
typedef std::list<OSubjectInfo>::const_iterator SubjectConstIterator;

class OObserver {
 public:
  OObserver();
  virtual ~OObserver();

  OStatus SetNotifyEntry(const OServiceEntry& entry);
  const ObserverID& GetID() const { return id_; }
  const ObserverID& GetObserverID() const { return id_; }
  // For DoInit. `skip` data are left out between two that are sent; `min` units make a
  // notification; at most `max` units wait, so that 1 means the newest alone.
  void SetBufCtrlParam(size_t skip, size_t min, size_t max);
  void SetSkip(size_t skip) { SetBufCtrlParam(skip, 1, 1); }

  // To all subjects, or one. Data of the last notification are given back.
  OStatus AssertReady();
  OStatus AssertReady(const SubjectID& subject);
  OStatus AssertReady(const OSubjectInfo& subject) { return AssertReady(subject.GetSubjectID()); }
  OStatus DeassertReady();
  OStatus DeassertReady(const SubjectID& subject);
  OStatus DeassertReady(const OSubjectInfo& s) { return DeassertReady(s.GetSubjectID()); }

  int NumberOfSubjects() const { return static_cast<int>(subjects_.size()); }
  SubjectConstIterator begin() const { return subjects_.begin(); }
  SubjectConstIterator end() const { return subjects_.end(); }

  // Called by stubs.
  OStatus ConnectHandler(const OConnectMessage& message, OStatus status = oSUCCESS);
  OStatus NotifyHandler(const ONotifyMessage& message, ONotifyEvent* event);

 private:
  OObserver(const OObserver&);
  OObserver& operator=(const OObserver&);
  OStatus send(ObjcommCommand command, const SubjectID& subject);
  OStatus send_all(ObjcommCommand command);

  // Data that the object may still read.
  struct Held {
    SubjectID subject;
    RCRegion* region;
  };

  ObserverID id_;
  size_t skip_, min_, max_;
  std::list<OSubjectInfo> subjects_;
  std::list<Held> held_;
};

#endif
