// The sending end of a connection. Data wait in a buffer for each observer until it is ready.
#ifndef SEAM_OPEN_R_OSUBJECT_H
#define SEAM_OPEN_R_OSUBJECT_H

#include <OPENR/OShmPtr.h>
#include <OPENR/ObjcommEvent.h>

// An observer as its subject knows it.
class OObserverInfo {
 public:
  OObserverInfo() : skip_(0), min_(1), max_(1), ready_(0), skipped_(0), notified_(0) {}
  const ObserverID& GetObserverID() const { return id_; }

 private:
  friend class OSubject;
  ObserverID id_;
  size_t skip_, min_, max_;
  int ready_;        // How often it asserted since it was notified; -1: it deasserted.
  size_t skipped_;   // Data left out since one was kept.
  size_t notified_;  // Calls of Notify whose data still wait.
  std::list<RCRegion*> waiting_;
};
typedef OObserverInfo ObserverInfo;
typedef std::list<OObserverInfo>::iterator ObserverIterator;
typedef std::list<OObserverInfo>::const_iterator ObserverConstIterator;

class OSubject {
 public:
  OSubject();
  ~OSubject();

  OStatus SetReadyEntry(const OServiceEntry& entry);
  const SubjectID& GetID() const { return id_; }
  OStatus SetBufferSize(size_t size);
  size_t GetBufferSize() const { return buffer_size_; }
  // How many SetData make a whole: a header and a body are two.
  OStatus SetNotifyUnitSize(size_t size);
  size_t GetNotifyUnitSize() const { return unit_; }

  // For all observers, or one. Where a buffer is full, its oldest data go.
  OStatus SetData(RCRegion* region);
  OStatus SetData(const OObserverInfo& observer, RCRegion* region);
  OStatus SetData(const ObserverID& observer, RCRegion* region);
  OStatus SetData(const void* buffer, size_t size);
  OStatus SetData(const OObserverInfo& observer, const void* buffer, size_t size);
  OStatus SetData(const ObserverID& observer, const void* buffer, size_t size);
  OStatus SetData(const OShmPtrBase& p) { return SetData(p.RCRPtr()); }
  OStatus SetData(const OObserverInfo& o, const OShmPtrBase& p) { return SetData(o, p.RCRPtr()); }
  OStatus SetData(const ObserverID& o, const OShmPtrBase& p) { return SetData(o, p.RCRPtr()); }

  // Sends what waits to observers that are ready, drops it for those that deasserted, and keeps it
  // for others until they are ready.
  OStatus NotifyObservers();
  OStatus NotifyObserver(const OObserverInfo& observer);
  OStatus NotifyObserver(const ObserverID& observer);

  size_t RemainBuffer() const;
  size_t RemainBuffer(const OObserverInfo& observer) const;
  size_t RemainBuffer(const ObserverID& observer) const;
  OStatus ClearBuffer();
  OStatus ClearBuffer(const OObserverInfo& observer);
  OStatus ClearBuffer(const ObserverID& observer);

  int NumberOfObservers() const { return static_cast<int>(observers_.size()); }
  ObserverConstIterator begin() const { return observers_.begin(); }
  ObserverConstIterator end() const { return observers_.end(); }
  ObserverConstIterator FindObserver(const ObserverID& id) const;

  int IsAllReady() const;
  int IsAnyReady() const;
  int IsReady() const { return IsAnyReady(); }
  int IsReady(const OObserverInfo& observer) const { return observer.ready_ > 0; }
  int IsReady(const ObserverID& observer) const;
  int ReadyStatus(const OObserverInfo& observer) const { return observer.ready_; }
  int ReadyStatus(const ObserverID& observer) const;

  // Called by stubs.
  OStatus ControlHandler(const OControlMessage& message, OStatus status = oSUCCESS);
  OStatus ReadyHandler(const OReadyMessage& message);

 private:
  OSubject(const OSubject&);
  OSubject& operator=(const OSubject&);
  ObserverIterator find(const ObserverID& id);
  OStatus keep(OObserverInfo& observer, RCRegion* region);
  void clear(OObserverInfo& observer);
  void send_if_ready(OObserverInfo& observer);
  OStatus notify(OObserverInfo& observer);

  SubjectID id_;
  size_t buffer_size_, unit_;
  std::list<OObserverInfo> observers_;
};

#endif
