// What the functions of an object are called with.
#ifndef SEAM_OPEN_R_OBJCOMM_EVENT_H
#define SEAM_OPEN_R_OBJCOMM_EVENT_H

#include <OPENR/ObjcommMessages.h>

// The subject behind a notification.
class OSubjectInfo : public SubjectID {
 public:
  OSubjectInfo() {}
  OSubjectInfo(const SubjectID& id) : SubjectID(id) {}
  const SubjectID& GetSubjectID() const { return *this; }
};
typedef OSubjectInfo SubjectInfo;

class OConnectEvent {
 public:
  OConnectEvent(int index, const char* name, OConnectCmd command)
      : index_(index), name_(name), command_(command) {}
  int ObsIndex() const { return index_; }
  const char* SubName() const { return name_; }
  bool IsConnect() const { return command_ == oconnectcmdCONNECT; }
  bool IsDisconnect() const { return !IsConnect(); }

 private:
  int index_;
  const char* name_;
  OConnectCmd command_;
};

class OControlEvent {
 public:
  OControlEvent(int index, const ObserverID& id, const char* name, ObjcommCommand command)
      : index_(index), id_(id), name_(name), command_(command) {}
  int SbjIndex() const { return index_; }
  const ObserverID& SenderID() const { return id_; }
  const char* SubName() const { return name_; }
  bool IsAddObserver() const { return command_ == objcommCMD_ADDOBSERVER; }
  bool IsRemoveObserver() const { return command_ == objcommCMD_REMOVEOBSERVER; }

 private:
  int index_;
  ObserverID id_;
  const char* name_;
  ObjcommCommand command_;
};

class OReadyEvent {
 public:
  OReadyEvent(int index, const ObserverID& id, ObjcommCommand command)
      : index_(index), id_(id), command_(command) {}
  int SbjIndex() const { return index_; }
  const ObserverID& SenderID() const { return id_; }
  bool IsAssert() const { return command_ == objcommCMD_ASSERT_READY; }
  bool IsDeassert() const { return command_ == objcommCMD_DEASSERT_READY; }

 private:
  int index_;
  ObserverID id_;
  ObjcommCommand command_;
};

class ONotifyEvent {
 public:
  ONotifyEvent() : index_(0), data_count_(0), notify_count_(0) {}
  void SetIndex(int index) { index_ = index; }
  void Set(const SubjectID& subject, int data_count, int notify_count, RCRegion* const* data) {
    subject_ = OSubjectInfo(subject);
    data_count_ = data_count;
    notify_count_ = notify_count;
    for (int i = 0; i < data_count; ++i) {
      regions_[i] = data[i];
      bases_[i] = data[i]->Base();
    }
  }

  int ObsIndex() const { return index_; }
  const OSubjectInfo& SenderID() const { return subject_; }
  int NumOfData() const { return data_count_; }
  int NumOfNotify() const { return notify_count_; }
  const void* Data(int i) const { return bases_[i]; }
  const void** Data() const { return const_cast<const void**>(bases_); }
  RCRegion* RCData(int i) const { return regions_[i]; }

 private:
  int index_;
  OSubjectInfo subject_;
  int data_count_, notify_count_;
  RCRegion* regions_[MAX_NUM_DATA];
  const void* bases_[MAX_NUM_DATA];
};

#endif
