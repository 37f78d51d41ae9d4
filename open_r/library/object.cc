// OObject, and the system calls that belong to no robot.
#include <OPENR/OObject.h>
#include <OPENR/OSyslog.h>

#include <cstdarg>
#include <cstdio>

#include "open_r/library/system.h"

using seam::open_r::System;

namespace {

void report(OStatus status, const char* function) {
  if (status == oSUCCESS) return;
  const System& system = System::current();
  std::printf("%s::%s() returned %u, expected oSUCCESS\n", system.name(system.running()).c_str(),
              function, status);
}

OStatus print(const char* format, va_list arguments) {
  char text[osyslogMAX_SIZE + 1];
  std::vsnprintf(text, sizeof text, format, arguments);
  std::fputs(text, stdout);
  return oSUCCESS;
}

}  // namespace

OObject::OObject() : myOID_(System::current().running()) {}
OObject::~OObject() = default;

void OObject::Init(const OSystemEvent& event) {
  report(DoInit(event), "DoInit");
}
void OObject::Start(const OSystemEvent& event) {
  report(DoStart(event), "DoStart");
}
void OObject::Stop(const OSystemEvent& event) {
  report(DoStop(event), "DoStop");
}
void OObject::Destroy(const OSystemEvent& event) {
  report(DoDestroy(event), "DoDestroy");
}

OStatus OObject::DoInit(const OSystemEvent&) {
  return oSUCCESS;
}
OStatus OObject::DoStart(const OSystemEvent&) {
  return oSUCCESS;
}
OStatus OObject::DoStop(const OSystemEvent&) {
  return oSUCCESS;
}
OStatus OObject::DoDestroy(const OSystemEvent&) {
  return oSUCCESS;
}

OStatus OObject::RegisterServiceEntry(const OServiceEntry& entry, const char* name) {
  return System::current().register_service(entry, name);
}

OStatus osysprint(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const OStatus status = print(format, arguments);
  va_end(arguments);
  return status;
}

OStatus osyslog(OSyslogPriority priority, const char* format, ...) {
  std::printf("[oid:%08x,prio:%u] ", System::current().running().Value(), priority);
  va_list arguments;
  va_start(arguments, format);
  const OStatus status = print(format, arguments);
  va_end(arguments);
  std::fputc('\n', stdout);
  return status;
}

// ---- The system's calls ----

sError GetSystemTime(SystemTime* time) {
  const int64_t us = System::current().now_ns() / 1000;
  *time = SystemTime(static_cast<longword>(us / 1'000'000), static_cast<longword>(us % 1'000'000));
  return sSUCCESS;
}

sError NewRegion(size_t size, void** base) {
  *base = ::operator new(size);
  return sSUCCESS;
}

sError DeleteRegion(void* base) {
  ::operator delete(base);
  return sSUCCESS;
}

sError NewSharedMemoryRegion(size_t size, MemoryProtectionInfo, MemoryRegionID* id, void** base) {
  auto* region = new RCRegion(size);
  *id = region->MemID();
  *base = region->Base();
  System::current().shared_regions()[*id] = region;
  return sSUCCESS;
}

sError DeleteSharedMemoryRegion(MemoryRegionID id) {
  auto& regions = System::current().shared_regions();
  const auto found = regions.find(id);
  if (found == regions.end()) return sINVALIDARG;
  found->second->RemoveReference();
  regions.erase(found);
  return sSUCCESS;
}

sError WhoAmI(OID* oid) {
  *oid = System::current().running();
  return sSUCCESS;
}

extern "C" void Prologue(void*) {}
