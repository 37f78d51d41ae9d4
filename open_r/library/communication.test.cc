// Subjects, observers and regions: who is sent what, and when it is free again.
#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>
#include <gtest/gtest.h>

#include "open_r/library/system.h"

namespace seam::open_r {
namespace {

// A subject and an observer, each in an object of its own.
class Communication : public ::testing::Test {
 protected:
  static constexpr Selector kControl = 4, kReady = 5, kConnect = 6, kNotify = 7;

  void connect(size_t min = 1, size_t max = 1, size_t skip = 0) {
    const OID a = system.add("A", [this](Selector s, void* message) {
      if (s == kControl) subject.ControlHandler(*static_cast<OControlMessage*>(message));
      if (s == kReady) {
        ++readies;
        subject.ReadyHandler(*static_cast<OReadyMessage*>(message));
      }
    });
    const OID b = system.add("B", [this](Selector s, void* message) {
      if (s == kConnect) observer.ConnectHandler(*static_cast<OConnectMessage*>(message));
      if (s != kNotify) return;
      ONotifyEvent event;
      observer.NotifyHandler(*static_cast<ONotifyMessage*>(message), &event);
      received.push_back(event.NumOfData());
      last = *static_cast<const int*>(event.Data(event.NumOfData() - 1));
      if (answers) observer.AssertReady();
    });
    subject.SetReadyEntry({a, kReady});
    observer.SetNotifyEntry({b, kNotify});
    observer.SetBufCtrlParam(skip, min, max);
    system.register_service({a, kControl}, "A.Out.int.S");
    system.register_service({b, kConnect}, "B.In.int.O");
    ASSERT_TRUE(system.connect("A.Out.int.S", "B.In.int.O"));
  }
  void send(int value) {
    subject.SetData(&value, sizeof value);
    subject.NotifyObservers();
  }

  System system;
  OSubject subject;
  OObserver observer;
  std::vector<int> received;
  int last = 0, readies = 0;
  bool answers = false;
};

TEST_F(Communication, DataWaitUntilTheObserverIsReady) {
  connect();
  send(1);
  system.deliver();
  EXPECT_TRUE(received.empty());
  observer.AssertReady();
  system.deliver();
  EXPECT_EQ(received, std::vector<int>{1});
  EXPECT_EQ(last, 1);
  // It was ready once: the next waits.
  send(2);
  system.deliver();
  EXPECT_EQ(received.size(), 1u);
  observer.AssertReady();
  system.deliver();
  EXPECT_EQ(last, 2);
}

TEST_F(Communication, ReadinessIsCounted) {
  connect();
  observer.AssertReady();
  observer.AssertReady();
  system.deliver();
  EXPECT_EQ(readies, 2);
  EXPECT_EQ(subject.ReadyStatus(observer.GetID()), 2);
  send(1);
  EXPECT_EQ(subject.ReadyStatus(observer.GetID()), 1);
  EXPECT_TRUE(subject.IsAllReady());
}

TEST_F(Communication, AnObserverThatDeassertedIsSentNothing) {
  connect();
  observer.DeassertReady();
  system.deliver();
  EXPECT_LT(subject.ReadyStatus(observer.GetID()), 0);
  send(1);
  observer.AssertReady();
  system.deliver();
  EXPECT_TRUE(received.empty());
}

TEST_F(Communication, TheNewestStaysWhereTheBufferIsFull) {
  connect(1, 2);
  for (int i = 1; i <= 5; ++i) send(i);
  EXPECT_EQ(subject.RemainBuffer(), 0u);
  observer.AssertReady();
  system.deliver();
  EXPECT_EQ(received, std::vector<int>{2});  // Two data in one notification.
  EXPECT_EQ(last, 5);
}

TEST_F(Communication, SkippedDataAreLeftOut) {
  connect(1, 10, 2);
  for (int i = 0; i < 6; ++i) send(i);
  observer.AssertReady();
  system.deliver();
  EXPECT_EQ(received, std::vector<int>{2});  // 0 and 3.
  EXPECT_EQ(last, 3);
}

TEST_F(Communication, ARegionIsFreeWhenTheObserverIsReadyAgain) {
  connect();
  auto* region = new RCRegion(sizeof(int));
  observer.AssertReady();
  system.deliver();
  subject.SetData(region);
  EXPECT_EQ(region->NumberOfReference(), 2);
  subject.NotifyObservers();
  system.deliver();
  EXPECT_EQ(region->NumberOfReference(), 2);  // The observer may still read it.
  observer.AssertReady();
  system.deliver();
  EXPECT_EQ(region->NumberOfReference(), 1);
  region->RemoveReference();
}

TEST_F(Communication, ServicesOfOtherDataAreNotConnected) {
  connect();
  system.register_service({system.add("C", [](Selector, void*) {}), 4}, "C.In.float.O");
  EXPECT_FALSE(system.connect("A.Out.int.S", "C.In.float.O"));
  EXPECT_FALSE(system.connect("A.Out.int.S", "D.In.int.O"));
}

TEST_F(Communication, MessagesWithoutEndAreAFault) {
  connect();
  answers = true;
  const OID again = system.add("Again", [this](Selector s, void*) {
    system.post({system.running(), s}, nullptr);
  });
  system.post({again, 4}, nullptr);
  EXPECT_THROW(system.deliver(), Fault);
}

}  // namespace
}  // namespace seam::open_r
