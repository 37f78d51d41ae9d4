// OPENR::'s functions of power, files, clock and volume.
#include <OPENR/OCalendarTime.h>
#include <OPENR/OPENRAPI.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "open_r/robot/virtual_robot.h"

using seam::open_r::System;
using seam::open_r::VirtualRobot;

namespace {

VirtualRobot& this_robot() {
  return VirtualRobot::current();
}

void copy_text(std::string_view text, char* to, size_t most) {
  const size_t size = std::min(text.size(), most);
  text.copy(to, size);
  to[size] = '\0';
}

// What the CPU of an ERS-210 reports.
OCPUInfo cpu() {
  OCPUInfo info{};
  info.sclk = 97'000'000;
  info.pclk = 194'000'000;
  return info;
}

}  // namespace

namespace OPENR {

// ---- Power ----

OStatus SetMotorPower(OPower power) {
  const OPowerStatus before = this_robot().power_status();
  this_robot().joints().set_power(power);
  this_robot().report_power(before);
  return oSUCCESS;
}

OStatus Shutdown(const OBootCondition&) {
  std::printf("%s shut the robot down\n",
              System::current().name(System::current().running()).c_str());
  this_robot().shut_down();
  return oSUCCESS;
}

OStatus Fatal(OFatal fatal) {
  std::printf("%s ended with a fatal error, %u\n",
              System::current().name(System::current().running()).c_str(), fatal);
  this_robot().shut_down();
  return oSUCCESS;
}

OStatus GetBootCondition(OBootCondition* condition) {
  *condition = OBootCondition(obcbPAUSE_SW);
  return oSUCCESS;
}

OStatus GetPowerStatus(OPowerStatus* status) {
  *status = this_robot().power_status();
  return oSUCCESS;
}

OStatus ObservePowerStatus(const OPowerStatus& changes, const OServiceEntry& entry) {
  this_robot().watches().push_back({changes, entry});
  return oSUCCESS;
}

OStatus UnobservePowerStatus(const OServiceEntry& entry) {
  return std::erase_if(this_robot().watches(), [&](const auto& w) { return w.entry == entry; }) > 0
             ? oSUCCESS
             : oINVALID_ARG;
}

// ---- Files ----

OStatus FindDesignData(const char* keyword, ODesignDataID* id, byte** data, size_t* size) {
  *id = odesigndataID_UNDEF;
  std::string content;
  if (std::string_view(keyword) == odesignkeywordCPUINFO) {
    const OCPUInfo info = cpu();
    content.assign(reinterpret_cast<const char*>(&info), sizeof info);
  } else {
    const auto named = this_robot().options().design_data.find(keyword);
    if (named == this_robot().options().design_data.end()) return oNOT_FOUND;
    std::ifstream file(this_robot().options().stick.find(named->second), std::ios::binary);
    if (!file) return oNOT_FOUND;
    std::ostringstream text;
    text << file.rdbuf();
    content = text.str();
  }
  if (content.empty()) return oDESIGNDATA_SIZE_ZERO;
  *id = System::current().next_region();
  std::string& kept = this_robot().loaded_files[*id] = std::move(content);
  *data = reinterpret_cast<byte*>(kept.data());
  *size = kept.size();
  return oSUCCESS;
}

OStatus DeleteDesignData(ODesignDataID id) {
  return this_robot().loaded_files.erase(id) == 1 ? oSUCCESS : oINVALID_ARG;
}

OStatus GetRobotDesign(char* design) {
  copy_text(this_robot().design().name, design, orobotdesignNAME_MAX);
  return oSUCCESS;
}

OStatus GetMemoryStickStatus(OMemoryStickStatus* status) {
  *status = omemorystickWRITABLE;
  return oSUCCESS;
}

// ---- Clock and volume ----

OStatus SetTime(const OTime& time) {
  this_robot().clock_shift_s = time.GetClock() - System::current().now_ns() / 1'000'000'000;
  if (time.GetTimeDif() != otimeTIME_DIF_UNDEF) SetTimeDifference(time.GetTimeDif());
  return oSUCCESS;
}

OStatus GetTime(OTime* time) {
  *time = OTime(this_robot().clock_shift_s + System::current().now_ns() / 1'000'000'000,
                this_robot().time_difference);
  return oSUCCESS;
}

OStatus SetTimeDifference(sbyte hours) {
  const OPowerStatus before = this_robot().power_status();
  this_robot().time_difference = hours;
  this_robot().report_power(before);
  return oSUCCESS;
}

OStatus GetTimeDifference(sbyte* hours) {
  *hours = this_robot().time_difference;
  return oSUCCESS;
}

OStatus SetVolumeSwitch(OVolumeSwitch volume) {
  const OPowerStatus before = this_robot().power_status();
  this_robot().volume = volume;
  this_robot().report_power(before);
  return oSUCCESS;
}

OStatus GetVolumeSwitch(OVolumeSwitch* volume) {
  *volume = this_robot().volume;
  return oSUCCESS;
}

}  // namespace OPENR

// ---- The clock as a date ----

namespace {

constexpr std::chrono::sys_days kStart = std::chrono::year(2000) / 1 / 1;

}  // namespace

OStatus OCalendarTime::SetTime(const OTime& time) {
  const std::chrono::sys_seconds local = kStart + std::chrono::seconds(time.GetLocalTime());
  const auto day = std::chrono::floor<std::chrono::days>(local);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(local - day);
  year_ = static_cast<int>(date.year());
  month_ = static_cast<int>(static_cast<unsigned>(date.month()));
  day_ = static_cast<int>(static_cast<unsigned>(date.day()));
  hour_ = static_cast<int>(clock.hours().count());
  min_ = static_cast<int>(clock.minutes().count());
  sec_ = static_cast<int>(clock.seconds().count());
  dow_ = static_cast<int>(std::chrono::weekday(day).c_encoding());
  timeDif_ = time.GetTimeDif();
  return oSUCCESS;
}

OStatus OCalendarTime::GetTime(OTime* time) const {
  const std::chrono::sys_days day = std::chrono::year(year_) /
                                    std::chrono::month(static_cast<unsigned>(month_)) /
                                    std::chrono::day(static_cast<unsigned>(day_));
  *time = OTime(0, timeDif_);
  time->SetLocalTime(std::chrono::duration_cast<std::chrono::seconds>(day - kStart).count() +
                     3600 * hour_ + 60 * min_ + sec_);
  return oSUCCESS;
}

OStatus OCalendarTime::GetTime(time_t* clock, sbyte* difference) const {
  OTime time;
  GetTime(&time);
  *clock = time.GetClock();
  *difference = time.GetTimeDif();
  return oSUCCESS;
}

void OCalendarTime::Sprint(char* text) const {
  std::ostringstream stream;
  stream << std::setfill('0') << std::setw(4) << year_;
  const std::pair<char, int> parts[] = {
      {'/', month_}, {'/', day_}, {' ', hour_}, {':', min_}, {':', sec_}};
  for (const auto& [between, value] : parts) stream << between << std::setw(2) << value;
  copy_text(stream.str(), text, 19);
}

void OCalendarTime::Print() const {
  char text[20];
  Sprint(text);
  std::puts(text);
}
