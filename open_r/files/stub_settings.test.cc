#include "open_r/files/stub_settings.h"

#include <gtest/gtest.h>

#include "open_r/files/fault.h"

namespace seam::open_r {
namespace {

constexpr char kStub[] =
    "// A comment.\n"
    "ObjectName : Head\n"
    "NumOfOSubject   : 1\n"
    "NumOfOObserver  : 2\n"
    "Service : \"Head.Move.OCommandVectorData.S\", null, Ready()\n"
    "Service : \"Head.Sensor.OSensorFrameVectorData.O\", Connected(), Notify()\n"
    "Service : \"Head.Nothing.DoNotConnect.O\", null, null\n"
    "Extra : Timer()\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string fault_of(const std::string& text) {
  try {
    read_stub_settings("stub.cfg", text);
  } catch (const Fault& fault) {
    return fault.what();
  }
  return "";
}

TEST(StubSettings, AreRead) {
  const StubSettings stub = read_stub_settings("stub.cfg", kStub);
  EXPECT_EQ(stub.object, "Head");
  ASSERT_EQ(stub.subjects.size(), 1u);
  EXPECT_EQ(stub.subjects[0].subname, "Move");
  EXPECT_EQ(stub.subjects[0].connection, "");
  EXPECT_EQ(stub.subjects[0].message, "Ready");
  ASSERT_EQ(stub.observers.size(), 2u);
  EXPECT_EQ(stub.observers[0].connection, "Connected");
  EXPECT_EQ(stub.observers[0].message, "Notify");
  EXPECT_EQ(stub.extras, std::vector<std::string>{"Timer"});
}

TEST(StubSettings, FaultsNameLineAndExpectation) {
  EXPECT_EQ(fault_of(replaced(kStub, "NumOfOSubject   : 1", "NumOfOSubject   : 2")),
            "stub.cfg: found NumOfOSubject : 2, expected 1, as many as there are services of it");
  EXPECT_EQ(fault_of(replaced(kStub, "Ready()", "Ready")),
            "stub.cfg:5: found 'Ready', expected a function such as Ready(), or null");
  EXPECT_EQ(fault_of(replaced(kStub, "Data.S\"", "Data.X\"")),
            "stub.cfg:5: found 'Head.Move.OCommandVectorData.X', expected Object.Name.Data.S of a "
            "subject, .O of an observer");
  EXPECT_EQ(fault_of("ObjectName : Head\nNumOfOSubject : 0\n"),
            "stub.cfg: found no NumOfOSubject, expected at least 1; a dummy counts");
  EXPECT_EQ(fault_of("Objectname : Head\n"),
            "stub.cfg:1: found 'Objectname', expected ObjectName, NumOfOSubject, NumOfOObserver, "
            "Service or Extra");
}

// Entries are numbered behind init, start, stop and destroy: controls, readies, connects, notifies,
// extras.
TEST(StubSettings, GiveHeadersAndTable) {
  const StubSettings stub = read_stub_settings("stub.cfg", kStub);
  const std::string definitions = definitions_header(stub), entries = entries_header(stub),
                    source = stub_source(stub);
  EXPECT_NE(definitions.find("const int sbjMove = 0;"), std::string::npos);
  EXPECT_NE(definitions.find("const int obsNothing = 1;"), std::string::npos);
  EXPECT_NE(entries.find("Entry_Control[] = {4};"), std::string::npos);
  EXPECT_NE(entries.find("Entry_Notify[] = {8, 9};"), std::string::npos);
  EXPECT_NE(entries.find("Extra_Entry[] = {10};"), std::string::npos);
  EXPECT_NE(entries.find("const int entryTimer = 0;"), std::string::npos);
  EXPECT_NE(source.find("Head Self;"), std::string::npos);
  EXPECT_NE(source.find("Self.Ready(OReadyEvent(0, m->observerID, m->command));"),
            std::string::npos);
  EXPECT_NE(source.find("{10, Extra0},"), std::string::npos);
}

}  // namespace
}  // namespace seam::open_r
