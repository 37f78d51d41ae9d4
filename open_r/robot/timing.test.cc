// Frames of 8 ms: when commands are put out, READY comes, and sensors and images are sent.
#include <OPENR/OCalendarTime.h>
#include <OPENR/OFbkImage.h>
#include <OPENR/OObserver.h>
#include <gtest/gtest.h>

#include "open_r/robot/virtual_robot.h"

namespace seam::open_r {
namespace {

constexpr Selector kReady = 4, kControl = 5, kConnect = 6, kNotify = 7;
const char* const kPan = "PRM:/r1/c1/c2-Joint2:j2";

// 178 x 144 pixels: the left half reddish, the right half grey; rows begin at 16 ms, 0.1 ms apart.
sdk::Frame two_halves() {
  sdk::Frame image;
  image.width_px = 178;
  image.height_px = 144;
  for (int i = 0; i < 178 * 144; ++i) {
    image.ycrcb += static_cast<char>(100);
    image.ycrcb += static_cast<char>(i % 178 < 89 ? 220 : 128);
    image.ycrcb += static_cast<char>(128);
  }
  for (int v = 0; v < 144; ++v) image.row_start_ns.push_back(16'000'000 + v * 100'000);
  for (int v = 0; v < 144; ++v) image.row_end_ns.push_back(image.row_start_ns[v] + 2'000'000);
  return image;
}

// A program of one object with a subject for commands and an observer of `service`.
class Timing : public ::testing::Test {
 protected:
  void start(const std::string& service) {
    object = system.add("Object", [this](Selector s, void* message) {
      if (s == kControl) commands.ControlHandler(*static_cast<OControlMessage*>(message));
      if (s == kReady) {
        commands.ReadyHandler(*static_cast<OReadyMessage*>(message));
        ready_at.push_back(frame);
      }
      if (s == kConnect) observer.ConnectHandler(*static_cast<OConnectMessage*>(message));
      if (s != kNotify) return;
      ONotifyEvent event;
      observer.NotifyHandler(*static_cast<ONotifyMessage*>(message), &event);
      notified_at.push_back(frame);
      newest.assign(event.RCData(0)->Base(), event.RCData(0)->Size());
      observer.AssertReady();
    });
    commands.SetReadyEntry({object, kReady});
    observer.SetNotifyEntry({object, kNotify});
    system.register_service({object, kControl}, "Object.Move.OCommandVectorData.S");
    system.register_service({object, kConnect}, "Object.In." + service + ".O");
    ASSERT_TRUE(system.connect("Object.Move.OCommandVectorData.S",
                               "OVirtualRobotComm.Effector.OCommandVectorData.O"));
    const std::string name = service == "OSensorFrameVectorData" ? "Sensor" : "FbkImageSensor";
    ASSERT_TRUE(system.connect("OVirtualRobotComm." + name + "." + service + ".S",
                               "Object.In." + service + ".O"));
    robot.start();
    observer.AssertReady();
    system.deliver();
  }

  TurnOrders turn(std::vector<sdk::Frame> images = {}) {
    sdk::Observation seen;
    seen.time_ns = frame * kFrameNs;
    seen.sensors.joints.time_ns = seen.time_ns;
    seen.sensors.joints.angles_rad.assign(15, 1e-3 * static_cast<double>(frame));
    seen.frames = std::move(images);
    TurnOrders orders = robot.turn(seen);
    ++frame;
    return orders;
  }

  // `count` frames of the pan joint, each 0.01 rad further.
  RCRegion* command(size_t count) {
    OPENR::OpenPrimitive(kPan, &pan);
    OPENR::SetMotorPower(opowerON);
    OPENR::EnableJointGain(pan);
    OPENR::SetDefaultJointGain(pan);
    MemoryRegionID id;
    OCommandVectorData* data;
    OPENR::NewCommandVectorData(1, &id, &data);
    data->SetNumData(1);
    data->GetInfo(0)->Set(odataJOINT_COMMAND2, pan, count);
    for (size_t k = 0; k < count; ++k)
      data->GetData(0)->value[k].value[0] = static_cast<slongword>(10'000 * (k + 1));
    made.push_back(new RCRegion(id, 0, data, data->vectorInfo.totalSize));
    return made.back();
  }
  ~Timing() override {
    for (RCRegion* region : made) region->RemoveReference();
  }

  System system;
  VirtualRobot robot{system, {}};
  OSubject commands;
  OObserver observer;
  OID object;
  OPrimitiveID pan = oprimitiveID_UNDEF;
  int64_t frame = 0;
  std::vector<int64_t> ready_at, notified_at;
  std::vector<RCRegion*> made;
  std::string newest;
};

TEST_F(Timing, ReadyComesWhenACommandIsPutOut) {
  start("OSensorFrameVectorData");
  EXPECT_EQ(ready_at.size(), 1u);  // Before the first command.
  RCRegion* first = command(16);
  RCRegion* second = command(4);
  commands.SetData(first);
  commands.SetData(second);
  commands.NotifyObservers();
  for (int k = 0; k < 16; ++k) {
    const TurnOrders orders = turn();
    ASSERT_EQ(orders.joints.targets.size(), 1u) << k;
    EXPECT_EQ(orders.joints.targets[0].joint, 1);
    EXPECT_NEAR(orders.joints.targets[0].angle_rad, 0.01 * (k + 1), 1e-12);
    EXPECT_EQ(first->NumberOfReference() > 1, true) << k;
  }
  // The second follows without a gap, and the first is free when READY comes.
  EXPECT_NEAR(turn().joints.targets.at(0).angle_rad, 0.01, 1e-12);
  EXPECT_EQ(ready_at, (std::vector<int64_t>{0, 16}));
  EXPECT_EQ(first->NumberOfReference(), 1);
  for (int k = 0; k < 4; ++k) turn();
  EXPECT_EQ(ready_at, (std::vector<int64_t>{0, 16, 20}));
}

// Two objects divide a key: neither command begins before the other one is there, then both do.
TEST_F(Timing, CommandsThatShareAKeyBeginTogether) {
  OSubject others;
  const OID second = system.add("Second", [&](Selector s, void* message) {
    if (s == kControl) others.ControlHandler(*static_cast<OControlMessage*>(message));
    if (s == kReady) others.ReadyHandler(*static_cast<OReadyMessage*>(message));
  });
  others.SetReadyEntry({second, kReady});
  system.register_service({second, kControl}, "Second.Move.OCommandVectorData.S");
  ASSERT_TRUE(system.connect("Second.Move.OCommandVectorData.S",
                             "OVirtualRobotComm.Effector.OCommandVectorData.O"));
  start("OSensorFrameVectorData");
  const auto send = [](OSubject& subject, RCRegion* region, OVRSyncKey key) {
    reinterpret_cast<OCommandVectorData*>(region->Base())->vectorInfo.syncKey = key;
    subject.SetData(region);
    subject.NotifyObservers();
  };
  OVRSyncKey key = ovrsynckeyUNDEF, one = key, other = key;
  ASSERT_EQ(OPENR::NewSyncKey(&key), oSUCCESS);
  ASSERT_EQ(OPENR::DivideSyncKey(key, &one, &other), oSUCCESS);
  EXPECT_NE(OPENR::DivideSyncKey(key, &one, &other), oSUCCESS);  // It was divided.
  send(commands, command(4), one);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(turn().joints.targets.empty()) << k;
  send(others, command(4), other);
  EXPECT_NEAR(turn().joints.targets.at(0).angle_rad, 0.01, 1e-12);
  for (int k = 1; k < 4; ++k) turn();
  EXPECT_TRUE(turn().joints.targets.empty());
  EXPECT_EQ(ready_at.size(), 2u);

  // A part that was taken back holds nothing up.
  ASSERT_EQ(OPENR::NewSyncKey(&key), oSUCCESS);
  ASSERT_EQ(OPENR::DivideSyncKey(key, &one, &other), oSUCCESS);
  send(commands, command(4), one);
  EXPECT_TRUE(turn().joints.targets.empty());
  EXPECT_EQ(OPENR::CancelSyncKey(other), oSUCCESS);
  EXPECT_NEAR(turn().joints.targets.at(0).angle_rad, 0.01, 1e-12);
  EXPECT_NE(OPENR::CancelSyncKey(other), oSUCCESS);
}

TEST_F(Timing, TheClockAndTheVolumeAreTheRobots) {
  start("OSensorFrameVectorData");
  OTime time;
  turn();
  ASSERT_EQ(OPENR::GetTime(&time), oSUCCESS);
  EXPECT_EQ(time.GetClock(), 0);
  // 2000-02-29, a Tuesday; local time is nine hours ahead.
  ASSERT_EQ(OPENR::SetTime(OTime(59 * 86400, 9)), oSUCCESS);
  for (int k = 0; k < 125; ++k) turn();
  OPENR::GetTime(&time);
  EXPECT_EQ(time.GetClock(), 59 * 86400 + 1);
  sbyte hours = 0;
  OPENR::GetTimeDifference(&hours);
  EXPECT_EQ(hours, 9);
  const OCalendarTime date(time);
  char text[20];
  date.Sprint(text);
  EXPECT_STREQ(text, "2000/02/29 09:00:01");
  EXPECT_EQ(date.dow_, 2);
  OTime back;
  ASSERT_EQ(date.GetTime(&back), oSUCCESS);
  EXPECT_TRUE(back == time);
  OVolumeSwitch volume = ovolumeSW0;
  ASSERT_EQ(OPENR::SetVolumeSwitch(ovolumeSW2), oSUCCESS);
  ASSERT_EQ(OPENR::GetVolumeSwitch(&volume), oSUCCESS);
  EXPECT_EQ(volume, ovolumeSW2);
}

TEST_F(Timing, SensorsComeInVectorsOfFourFrames) {
  start("OSensorFrameVectorData");
  for (int k = 0; k < 12; ++k) turn();
  EXPECT_EQ(notified_at, (std::vector<int64_t>{3, 7, 11}));
  auto* vector = reinterpret_cast<OSensorFrameVectorData*>(newest.data());
  ASSERT_EQ(vector->vectorInfo.numData, 31u);
  const OSensorFrameInfo* tilt = vector->GetInfo(0);
  EXPECT_EQ(tilt->frameNumber, 8u);
  EXPECT_EQ(tilt->numFrames, 4u);
  EXPECT_EQ(tilt->type, odataJOINT_VALUE);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(vector->GetData(0)->frame[k].value, 1000 * (8 + k));
  EXPECT_EQ(vector->GetInfo(30)->type, odataACCELERATION);
}

TEST_F(Timing, NothingMovesWithoutPowerAndGain) {
  start("OSensorFrameVectorData");
  RCRegion* first = command(4);
  OPENR::SetMotorPower(opowerOFF);
  commands.SetData(first);
  commands.NotifyObservers();
  const TurnOrders orders = turn();
  EXPECT_TRUE(orders.joints.targets.empty());
  ASSERT_EQ(orders.warnings.size(), 1u);
  EXPECT_NE(orders.warnings[0].find("motor power is off"), std::string::npos);
  OPENR::DisableJointGain(pan);
  EXPECT_EQ(OPENR::SetDefaultJointGain(pan), oGAIN_DISABLED);
}

TEST_F(Timing, TurnsAreFrames) {
  start("OSensorFrameVectorData");
  turn();
  frame = 4;
  EXPECT_THROW(turn(), Fault);
}

// An image of two halves, and the sensor frame at its middle row.
TEST_F(Timing, ImagesHaveLayersCountersAndTheirSensorFrame) {
  start("OFbkImageVectorData");
  OPENR::OpenPrimitive("PRM:/r1/c1/c2/c3/i1-FbkImageSensor:F1", &pan);
  MemoryRegionID id;
  OCdtVectorData* table;
  OPENR::NewCdtVectorData(&id, &table);
  table->SetNumData(1);
  table->GetInfo(0)->Init(pan, ocdtCHANNEL2);
  for (int y = 0; y < ocdtMAX_Y_SEGMENT; ++y) table->GetInfo(0)->Set(y, 255, 200, 255, 0);
  ASSERT_EQ(OPENR::SetCdtVectorData(id), oSUCCESS);

  const sdk::Frame image = two_halves();
  turn();
  turn({image});
  turn({image});
  EXPECT_EQ(notified_at, (std::vector<int64_t>{1, 2}));
  auto* vector = reinterpret_cast<OFbkImageVectorData*>(newest.data());
  EXPECT_EQ(vector->GetInfo(ofbkimageLAYER_H)->width, 176u);
  EXPECT_EQ(vector->GetInfo(ofbkimageLAYER_H)->frameNumber, 3u);  // 24.2 ms
  OFbkImage cr(vector->GetInfo(ofbkimageLAYER_H), vector->GetData(ofbkimageLAYER_H),
               ofbkimageBAND_Cr);
  EXPECT_EQ(cr.Pixel(0, 5), 220);
  EXPECT_EQ(cr.Pixel(175, 5), 128);
  OFbkImage colours(vector->GetInfo(ofbkimageLAYER_C), vector->GetData(ofbkimageLAYER_C),
                    ofbkimageBAND_CDT);
  ASSERT_TRUE(colours.IsValid());
  EXPECT_EQ(colours.Width(), 88);
  EXPECT_EQ(colours.Pixel(3, 3), ocdtCHANNEL2);
  EXPECT_EQ(colours.Pixel(80, 3), 0);
  EXPECT_EQ(colours.FieldCounter(), 1);
  EXPECT_EQ(colours.ColorFrequency(ocdtCHANNEL2), 44 * 71 / 16);
  EXPECT_EQ(colours.ColorFrequency(ocdtCHANNEL0), 0);
  EXPECT_FALSE(OFbkImage(vector->GetInfo(0), vector->GetData(0), ofbkimageBAND_CDT).IsValid());
}

TEST_F(Timing, TheCameraTakesRequests) {
  start("OFbkImageVectorData");
  OPrimitiveID camera = oprimitiveID_UNDEF;
  OPENR::OpenPrimitive("PRM:/r1/c1/c2/c3/i1-FbkImageSensor:F1", &camera);
  OPENR::OpenPrimitive(kPan, &pan);
  const auto ask = [](OPrimitiveID id, OPrimitiveRequest request, longword parameter) {
    OPrimitiveControl_CameraParam param(parameter);
    return OPENR::ControlPrimitive(id, request, &param, sizeof param, nullptr, 0);
  };
  const auto brightness = [&] {
    auto* vector = reinterpret_cast<OFbkImageVectorData*>(newest.data());
    return OFbkImage(vector->GetInfo(ofbkimageLAYER_H), vector->GetData(ofbkimageLAYER_H),
                     ofbkimageBAND_Y)
        .Pixel(170, 5);
  };
  turn();
  turn({two_halves()});
  EXPECT_EQ(brightness(), 100);
  EXPECT_EQ(ask(camera, oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_FAST), oSUCCESS);
  turn({two_halves()});
  EXPECT_EQ(brightness(), 50);
  EXPECT_EQ(ask(camera, oprmreqCAM_SET_SHUTTER_SPEED, 7), oINVALID_ARG);
  EXPECT_EQ(ask(pan, oprmreqCAM_SET_GAIN, ocamparamGAIN_LOW), oINVALID_REQUEST);
}

TEST(LegMotion, PawsThatStandPushTheBody) {
  LegAngles before{}, after{};
  for (size_t leg = 0; leg < 4; ++leg) {
    before[3 * leg] = leg < 2 ? 0.01 : -0.01;
    after[3 * leg] = -before[3 * leg];
  }
  // All four paws go backward by the same way: the body goes forward.
  const double way = paw_places(before)[0].x - paw_places(after)[0].x;
  const BodyMotion motion = motion_of_legs(before, after, 0.008);
  EXPECT_NEAR(motion.vx_m_s, way / 0.008, 0.05 * way / 0.008);
  EXPECT_NEAR(motion.vy_m_s, 0, 1e-9);
  EXPECT_NEAR(motion.omega_rad_s, 0, 1e-9);
}

}  // namespace
}  // namespace seam::open_r
