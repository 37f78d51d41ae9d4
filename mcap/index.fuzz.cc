// Whatever records the index of a file holds, with its CRC right: what they point to is read,
// refused, or the file is scanned instead. The input is the summary section.
#include "mcap/reader.h"
#include "mcap/writer.h"
#include "sim_core/base/error.h"

using namespace seam::mcap;

namespace {

// A data section with a chunk and an attachment.
std::string data_section() {
  MemoryOutput output;
  Writer writer(output, {.profile = "fuzz"});
  const uint16_t channel = writer.add_channel(0, "/topic", "json");
  writer.attach({.name = "a.txt", .media_type = "text/plain", .data = "hello"});
  writer.write(channel, 1, "{}");
  writer.add_metadata({"facts", {{"seed", "7"}}});
  writer.flush();
  ByteSink end;
  append(end, DataEnd{});
  return output.bytes() + end.bytes();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string start = data_section();
  const std::string summary(reinterpret_cast<const char*>(data), size);
  Footer footer{start.size(), 0, 0};
  ByteSink record;
  append(record, footer);
  footer.summary_crc =
      crc32(std::string_view(record.bytes()).substr(0, record.size() - 4), crc32(summary));
  ByteSink file;
  file.raw(start);
  file.raw(summary);
  append(file, footer);
  file.raw(kMagic);
  const Reader reader = Reader::open(std::make_unique<MemoryInput>(file.bytes()));
  for (const ChunkPlace& chunk : reader.contents().chunks) {
    try {
      reader.for_each_message(chunk, [](const Message&) {});
    } catch (const seam::InputError&) {
    }
  }
  for (const AttachmentIndex& attachment : reader.contents().attachments) {
    try {
      reader.read_attachment(attachment);
    } catch (const seam::InputError&) {
    }
  }
  return 0;
}
