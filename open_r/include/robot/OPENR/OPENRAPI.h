// The calls to the robot.
#ifndef SEAM_OPEN_R_OPENRAPI_H
#define SEAM_OPEN_R_OPENRAPI_H

#include <OPENR/ODataFormats.h>
#include <OPENR/OPENR.h>
#include <OPENR/OPower.h>
#include <OPENR/OPrimitiveControl.h>
#include <OPENR/OSyslog.h>

namespace OPENR {

// ---- Primitives, by locators such as "PRM:/r1/c1-Joint2:j1" ----
OStatus OpenPrimitive(const char* locator, OPrimitiveID* id);
OStatus ClosePrimitive(OPrimitiveID id);
OStatus ControlPrimitive(OPrimitiveID id, OPrimitiveRequest request, void* param, size_t param_size,
                         void* result, size_t result_size);

// ---- Memory for data ----
OStatus NewCommandVectorData(size_t commands, MemoryRegionID* id, OCommandVectorData** data);
OStatus DeleteCommandVectorData(MemoryRegionID id);
OStatus NewSoundVectorData(size_t sounds, size_t size, MemoryRegionID* id, OSoundVectorData** data);
OStatus DeleteSoundVectorData(MemoryRegionID id);
OStatus NewCdtVectorData(MemoryRegionID* id, OCdtVectorData** data);
OStatus DeleteCdtVectorData(MemoryRegionID id);
OStatus SetCdtVectorData(MemoryRegionID id);

// ---- Joints and sensors ----
// A joint follows commands while motor power is on and its gain is enabled and set.
// oprimitiveID_UNDEF: all joints that were opened.
OStatus EnableJointGain(OPrimitiveID id);
OStatus DisableJointGain(OPrimitiveID id);
OStatus SetJointGain(OPrimitiveID id, word p, word i, word d, word p_shift, word i_shift,
                     word d_shift);
OStatus GetJointGain(OPrimitiveID id, word* p, word* i, word* d, word* p_shift, word* i_shift,
                     word* d_shift);
OStatus RegisterDefaultJointGain(OPrimitiveID id, word p, word i, word d, word p_shift,
                                 word i_shift, word d_shift);
OStatus GetDefaultJointGain(OPrimitiveID id, word* p, word* i, word* d, word* p_shift,
                            word* i_shift, word* d_shift);
OStatus SetDefaultJointGain(OPrimitiveID id);
OStatus GetJointValue(OPrimitiveID id, OJointValue* value);
OStatus GetSensorValue(OPrimitiveID id, OSensorValue* value);

// ---- Commands and sounds that begin together ----
OStatus NewSyncKey(OVRSyncKey* key);
OStatus CancelSyncKey(OVRSyncKey key);
OStatus DivideSyncKey(OVRSyncKey key, OVRSyncKey* first, OVRSyncKey* second);

// ---- Power ----
OStatus SetMotorPower(OPower power);
OStatus Shutdown(const OBootCondition& condition);
OStatus GetBootCondition(OBootCondition* condition);
OStatus GetPowerStatus(OPowerStatus* status);
OStatus ObservePowerStatus(const OPowerStatus& changes, const OServiceEntry& entry);
OStatus UnobservePowerStatus(const OServiceEntry& entry);
OStatus Fatal(OFatal fatal);

// ---- Files of DESIGNDB.CFG, and which robot this is ----
OStatus FindDesignData(const char* keyword, ODesignDataID* id, byte** data, size_t* size);
OStatus DeleteDesignData(ODesignDataID id);
OStatus GetRobotDesign(char* design);
OStatus GetMemoryStickStatus(OMemoryStickStatus* status);

// ---- Clock and volume ----
OStatus SetTime(const OTime& time);
OStatus GetTime(OTime* time);
OStatus SetTimeDifference(sbyte hours);
OStatus GetTimeDifference(sbyte* hours);
OStatus SetVolumeSwitch(OVolumeSwitch volume);
OStatus GetVolumeSwitch(OVolumeSwitch* volume);

}  // namespace OPENR

#endif
