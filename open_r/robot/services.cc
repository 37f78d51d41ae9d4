// OPENR::'s functions of joints, sensors and memory.
#include <OPENR/OPENRAPI.h>

#include <algorithm>

#include "open_r/robot/virtual_robot.h"

using seam::open_r::find_primitive;
using seam::open_r::JointBoard;
using seam::open_r::JointGain;
using seam::open_r::Quantity;
using seam::open_r::System;
using seam::open_r::VirtualRobot;

namespace {

VirtualRobot& robot() {
  return VirtualRobot::current();
}

bool is_primitive(OPrimitiveID id) {
  return id < robot().design().primitives.size();
}

// Does it to one joint, or to all that were opened; the first failure counts.
template <class Action>
OStatus for_joints(OPrimitiveID id, Action action) {
  if (id != oprimitiveID_UNDEF) {
    if (!robot().joints().is_joint(static_cast<int>(id))) return oINVALID_PRIMITIVE_ID;
    return action(static_cast<int>(id));
  }
  OStatus status = oSUCCESS;
  for (const int opened : robot().opened()) {
    if (!robot().joints().is_joint(opened)) continue;
    const OStatus one = action(opened);
    if (status == oSUCCESS) status = one;
  }
  return status;
}

void write_gain(const JointGain& gain, word* p, word* i, word* d, word* ps, word* is, word* ds) {
  *p = gain.p, *i = gain.i, *d = gain.d;
  *ps = gain.p_shift, *is = gain.i_shift, *ds = gain.d_shift;
}

OStatus set_camera(OPrimitiveID id, OPrimitiveRequest request, const void* param, size_t size) {
  if (robot().design().primitives[id].quantity != Quantity::camera) return oINVALID_REQUEST;
  if (param == nullptr || size < sizeof(OPrimitiveControl_CameraParam)) return oINVALID_ARG;
  const auto* setting = static_cast<const OPrimitiveControl_CameraParam*>(param);
  return robot().camera_settings.set(request, setting->camparam) ? oSUCCESS : oINVALID_ARG;
}

template <class Vector>
OStatus reserve(const seam::open_r::VectorLayout& layout, MemoryRegionID* id, Vector** data) {
  *id = System::current().next_region();
  *data = static_cast<Vector*>(robot().memory().reserve(layout, *id));
  return oSUCCESS;
}

OStatus release(MemoryRegionID id) {
  return robot().memory().release(id) ? oSUCCESS : oINVALID_ARG;
}

}  // namespace

namespace OPENR {

OStatus OpenPrimitive(const char* locator, OPrimitiveID* id) {
  *id = oprimitiveID_UNDEF;
  if (locator == nullptr) return oINVALID_ARG;
  const int found = find_primitive(robot().design(), locator);
  if (found < 0) return oNOT_FOUND;
  robot().opened().insert(found);
  *id = static_cast<OPrimitiveID>(found);
  return oSUCCESS;
}

OStatus ClosePrimitive(OPrimitiveID id) {
  return robot().opened().erase(static_cast<int>(id)) == 1 ? oSUCCESS : oINVALID_PRIMITIVE_ID;
}

OStatus ControlPrimitive(OPrimitiveID id, OPrimitiveRequest request, void* param, size_t param_size,
                         void* result, size_t result_size) {
  if (!is_primitive(id)) return oINVALID_PRIMITIVE_ID;
  using Type = OPrimitiveControl_SpeakerSoundType;
  switch (request) {
    case oprmreqSPEAKER_SET_SOUND_TYPE:
      if (param == nullptr || param_size < sizeof(Type)) return oINVALID_ARG;
      robot().sound_type = static_cast<const Type*>(param)->type;
      return oSUCCESS;
    case oprmreqSPEAKER_GET_SOUND_TYPE:
      if (result == nullptr || result_size < sizeof(Type)) return oINVALID_ARG;
      static_cast<Type*>(result)->type = robot().sound_type;
      return oSUCCESS;
    case oprmreqJOINT2_SET_COMMAND:
      if (param == nullptr || !robot().joints().is_joint(static_cast<int>(id))) return oINVALID_ARG;
      robot().joints().command(
          static_cast<int>(id),
          static_cast<const OPrimitiveControl_JointCommandValue2*>(param)->command.value);
      return oSUCCESS;
    case oprmreqJOINT2_GET_VALUE:
      if (result == nullptr) return oINVALID_ARG;
      return GetJointValue(id, &static_cast<OPrimitiveControl_JointValue*>(result)->jval);
    case oprmreqCAM_SET_SHUTTER_SPEED:
    case oprmreqCAM_SET_GAIN:
    case oprmreqCAM_SET_WHITE_BALANCE:
      return set_camera(id, request, param, param_size);
    default:
      return oSUCCESS;  // Settings of microphone and speaker, and the camera's automatic ones.
  }
}

OStatus NewCommandVectorData(size_t commands, MemoryRegionID* id, OCommandVectorData** data) {
  return reserve(seam::open_r::command_layout(commands), id, data);
}
OStatus DeleteCommandVectorData(MemoryRegionID id) {
  return release(id);
}
OStatus NewSoundVectorData(size_t sounds, size_t size, MemoryRegionID* id,
                           OSoundVectorData** data) {
  return reserve(seam::open_r::sound_layout(sounds, size), id, data);
}
OStatus DeleteSoundVectorData(MemoryRegionID id) {
  return release(id);
}
OStatus NewCdtVectorData(MemoryRegionID* id, OCdtVectorData** data) {
  return reserve({odataCDT_VECTOR, sizeof(OCdtVectorData), sizeof(OCdtInfo), 0, 0}, id, data);
}
OStatus DeleteCdtVectorData(MemoryRegionID id) {
  return release(id);
}

OStatus SetCdtVectorData(MemoryRegionID id) {
  auto* vector = static_cast<OCdtVectorData*>(robot().memory().find(id));
  if (vector == nullptr) return oFAIL;
  if (vector->vectorInfo.type != odataCDT_VECTOR) return oINVALID_DATA_TYPE;
  const size_t count = std::min<size_t>(vector->vectorInfo.numData, ocdtNUM_CHANNELS);
  for (size_t i = 0; i < count; ++i) {
    const OCdtInfo& info = vector->info[i];
    if (!is_primitive(info.primitiveID) ||
        robot().design().primitives[info.primitiveID].quantity != Quantity::camera)
      return oINVALID_PRIMITIVE_ID;
    size_t channel = 0;
    while (channel < ocdtNUM_CHANNELS && info.channel != 1u << channel) ++channel;
    if (channel == ocdtNUM_CHANNELS) return oINVALID_ARG;
    std::copy_n(info.table, ocdtMAX_Y_SEGMENT, robot().colours()[channel].begin());
  }
  return oSUCCESS;
}

// ---- Joints and sensors ----

OStatus EnableJointGain(OPrimitiveID id) {
  return for_joints(id, [](int joint) {
    robot().joints().enable_gain(joint, true);
    return oSUCCESS;
  });
}

OStatus DisableJointGain(OPrimitiveID id) {
  return for_joints(id, [](int joint) {
    robot().joints().enable_gain(joint, false);
    return oSUCCESS;
  });
}

OStatus SetJointGain(OPrimitiveID id, word p, word i, word d, word ps, word is, word ds) {
  return for_joints(id, [&](int joint) {
    return robot().joints().set_gain(joint, {p, i, d, ps, is, ds}) ? oSUCCESS : oGAIN_DISABLED;
  });
}

OStatus SetDefaultJointGain(OPrimitiveID id) {
  return for_joints(id, [](int joint) {
    JointBoard& joints = robot().joints();
    return joints.set_gain(joint, joints.default_gain(joint)) ? oSUCCESS : oGAIN_DISABLED;
  });
}

OStatus RegisterDefaultJointGain(OPrimitiveID id, word p, word i, word d, word ps, word is,
                                 word ds) {
  return for_joints(id, [&](int joint) {
    robot().joints().set_default_gain(joint, {p, i, d, ps, is, ds});
    return oSUCCESS;
  });
}

OStatus GetJointGain(OPrimitiveID id, word* p, word* i, word* d, word* ps, word* is, word* ds) {
  write_gain({0, 0, 0, 0, 0, 0}, p, i, d, ps, is, ds);
  const JointBoard& joints = robot().joints();
  if (!joints.is_joint(static_cast<int>(id))) return oINVALID_PRIMITIVE_ID;
  if (!joints.gain_enabled(static_cast<int>(id))) return oGAIN_DISABLED;
  write_gain(joints.gain(static_cast<int>(id)), p, i, d, ps, is, ds);
  return oSUCCESS;
}

OStatus GetDefaultJointGain(OPrimitiveID id, word* p, word* i, word* d, word* ps, word* is,
                            word* ds) {
  write_gain({0, 0, 0, 0, 0, 0}, p, i, d, ps, is, ds);
  const JointBoard& joints = robot().joints();
  if (!joints.is_joint(static_cast<int>(id))) return oINVALID_PRIMITIVE_ID;
  write_gain(joints.default_gain(static_cast<int>(id)), p, i, d, ps, is, ds);
  return oSUCCESS;
}

OStatus GetJointValue(OPrimitiveID id, OJointValue* value) {
  if (!robot().joints().is_joint(static_cast<int>(id))) return oINVALID_PRIMITIVE_ID;
  *value = robot().joints().value(static_cast<int>(id));
  return oSUCCESS;
}

OStatus GetSensorValue(OPrimitiveID id, OSensorValue* value) {
  if (!is_primitive(id)) return oINVALID_PRIMITIVE_ID;
  *value = seam::open_r::read_sensor(robot().design(), robot().joints(), robot().sensors(),
                                     static_cast<int>(id));
  return oSUCCESS;
}

// ---- Synchronisation ----

OStatus NewSyncKey(OVRSyncKey* key) {
  const auto made = robot().keys().make();
  *key = made.value_or(ovrsynckeyUNDEF);
  return made ? oSUCCESS : oNO_SYNC_KEY;
}

OStatus CancelSyncKey(OVRSyncKey key) {
  return robot().keys().cancel(key) ? oSUCCESS : oINVALID_SYNC_KEY;
}

OStatus DivideSyncKey(OVRSyncKey key, OVRSyncKey* first, OVRSyncKey* second) {
  const auto parts = robot().keys().divide(key);
  if (!parts) return oFAIL;
  *first = parts->first;
  *second = parts->second;
  return oSUCCESS;
}

}  // namespace OPENR
