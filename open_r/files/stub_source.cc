// The stub that follows from a stub.cfg: numbers of subjects and observers, entries, and functions
// that hand messages to the object's own.
#include <algorithm>
#include <functional>

#include "open_r/files/stub_settings.h"

namespace seam::open_r {
namespace {

// Entries of an object's own begin behind init, start, stop and destroy.
constexpr size_t kFirstEntry = 4;

const char* const kMade = "// Made by `seam open-r` from stub.cfg.\n";

struct Entries {
  explicit Entries(const StubSettings& s)
      : control(kFirstEntry),
        ready(control + s.subjects.size()),
        connect(ready + s.subjects.size()),
        notify(connect + s.observers.size()),
        extra(notify + s.observers.size()) {}
  size_t control, ready, connect, notify, extra;
};

// An array of `count` elements; of none one that nobody reads, since C++ has no empty array.
std::string array(const std::string& head, size_t count,
                  const std::function<std::string(size_t)>& element) {
  std::string text = "static const " + head + "[] = {";
  for (size_t i = 0; i < std::max<size_t>(1, count); ++i)
    text += (i == 0 ? "" : ", ") + (i < count ? element(i) : std::string("0"));
  return text + "};\n";
}

std::string numbers(const std::string& name, size_t first, size_t count) {
  return array("Selector " + name, count, [&](size_t i) { return std::to_string(first + i); });
}

std::string services(const std::string& name, const std::vector<StubService>& list) {
  return array("char* const " + name, list.size(),
               [&](size_t i) { return "\"" + list[i].name + "\""; });
}

std::string function(const std::string& name, const std::string& body) {
  return "static void " + name + "(void* message) {\n" + body + "}\n";
}

std::string reason_function(const std::string& name) {
  return function(name + "Stub", "  OReasonMessage* m = (OReasonMessage*)message;\n  Self." + name +
                                     "(OSystemEvent(m->reason, m->param, m->paramSize));\n");
}

std::string subject_functions(const StubService& service, size_t i) {
  const std::string n = std::to_string(i), subject = "Self.subject[" + n + "]";
  const std::string status = service.connection.empty()
                                 ? ""
                                 : ", Self." + service.connection + "(OControlEvent(" + n +
                                       ", m->observerID, m->subName, m->command))";
  std::string text =
      function("Control" + n, "  OControlMessage* m = (OControlMessage*)message;\n  " + subject +
                                  "->ControlHandler(*m" + status + ");\n");
  std::string ready =
      "  OReadyMessage* m = (OReadyMessage*)message;\n  " + subject + "->ReadyHandler(*m);\n";
  if (!service.message.empty())
    ready += "  Self." + service.message + "(OReadyEvent(" + n + ", m->observerID, m->command));\n";
  return text + function("Ready" + n, ready);
}

std::string observer_functions(const StubService& service, size_t i) {
  const std::string n = std::to_string(i), observer = "Self.observer[" + n + "]";
  const std::string status =
      service.connection.empty()
          ? ""
          : ", Self." + service.connection + "(OConnectEvent(" + n + ", m->subName, m->command))";
  std::string text =
      function("Connect" + n, "  OConnectMessage* m = (OConnectMessage*)message;\n  " + observer +
                                  "->ConnectHandler(*m" + status + ");\n");
  std::string notify = "  ONotifyEvent event;\n  event.SetIndex(" + n + ");\n  " + observer +
                       "->NotifyHandler(*(ONotifyMessage*)message, &event);\n";
  if (!service.message.empty()) notify += "  Self." + service.message + "(event);\n";
  return text + function("Notify" + n, notify);
}

std::string row(size_t selector, const std::string& name) {
  return "    {" + std::to_string(selector) + ", " + name + "},\n";
}

}  // namespace

std::string definitions_header(const StubSettings& settings) {
  std::string text = std::string(kMade) + "#ifndef def_h_made\n#define def_h_made\n";
  const auto list = [&](const char* count, const char* prefix, const auto& services) {
    text += "const int " + std::string(count) + " = " + std::to_string(services.size()) + ";\n";
    for (size_t i = 0; i < services.size(); ++i)
      text += "const int " + (prefix + services[i].subname) + " = " + std::to_string(i) + ";\n";
  };
  list("numOfSubject", "sbj", settings.subjects);
  list("numOfObserver", "obs", settings.observers);
  return text + "#endif\n";
}

std::string entries_header(const StubSettings& settings) {
  const Entries entries(settings);
  const size_t subjects = settings.subjects.size(), observers = settings.observers.size();
  std::string text = std::string(kMade) +
                     "#ifndef entry_h_made\n#define entry_h_made\n#include <OPENR/OPENR.h>\n" +
                     services("subjectService", settings.subjects) +
                     services("observerService", settings.observers) +
                     numbers("Entry_Control", entries.control, subjects) +
                     numbers("Entry_Ready", entries.ready, subjects) +
                     numbers("Entry_Connect", entries.connect, observers) +
                     numbers("Entry_Notify", entries.notify, observers) +
                     numbers("Extra_Entry", entries.extra, settings.extras.size());
  for (size_t i = 0; i < settings.extras.size(); ++i)
    text += "const int entry" + settings.extras[i] + " = " + std::to_string(i) + ";\n";
  return text + "#endif\n";
}

std::string stub_source(const StubSettings& settings) {
  const Entries entries(settings);
  std::string text = std::string(kMade) +
                     "#include <ObjectEntryTable.h>\n#include <OPENR/OObject.h>\n"
                     "#include <OPENR/OSubject.h>\n#include <OPENR/OObserver.h>\n#include \"" +
                     settings.object + ".h\"\n" + settings.object + " Self;\n";
  std::string table =
      row(0, "InitStub") + row(1, "StartStub") + row(2, "StopStub") + row(3, "DestroyStub");
  for (const char* name : {"Init", "Start", "Stop", "Destroy"}) text += reason_function(name);
  for (size_t i = 0; i < settings.subjects.size(); ++i) {
    text += subject_functions(settings.subjects[i], i);
    table += row(entries.control + i, "Control" + std::to_string(i)) +
             row(entries.ready + i, "Ready" + std::to_string(i));
  }
  for (size_t i = 0; i < settings.observers.size(); ++i) {
    text += observer_functions(settings.observers[i], i);
    table += row(entries.connect + i, "Connect" + std::to_string(i)) +
             row(entries.notify + i, "Notify" + std::to_string(i));
  }
  for (size_t i = 0; i < settings.extras.size(); ++i) {
    const std::string name = "Extra" + std::to_string(i);
    text += function(name, "  Self." + settings.extras[i] + "(message);\n");
    table += row(entries.extra + i, name);
  }
  return text + "ObjectEntry ObjectEntryTable[] = {\n" + table + "    {UNDEF, ENTRY_UNDEF},\n};\n";
}

}  // namespace seam::open_r
