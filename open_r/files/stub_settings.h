// stub.cfg: the services of an object and the functions that are called for them, and the stub that
// follows from it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace seam::open_r {

struct StubService {
  std::string name;        // "MovingHead.Move.OCommandVectorData.S"
  std::string subname;     // "Move"
  std::string connection;  // Called with the result of a connection; empty: none.
  std::string message;     // Called when ready or notified; empty: none.
};

struct StubSettings {
  std::string object;  // The class, in a header of its name.
  std::vector<StubService> subjects, observers;
  std::vector<std::string> extras;  // Functions that get an entry of their own.
};

// Throws Fault, with file and line, for what is no such file.
StubSettings read_stub_settings(std::string_view file, std::string_view text);

// The files that stand beside an object's sources.
std::string definitions_header(const StubSettings& settings);  // def.h
std::string entries_header(const StubSettings& settings);      // entry.h
std::string stub_source(const StubSettings& settings);         // <object>Stub.cc

}  // namespace seam::open_r
