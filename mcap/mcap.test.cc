// What was written is read back, and what is damaged is said and never more than that is lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include "mcap/reader.h"
#include "mcap/writer.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::mcap {
namespace {

using ::testing::HasSubstr;

std::unique_ptr<Input> memory(std::string bytes) {
  return std::make_unique<MemoryInput>(std::move(bytes));
}

// Eight chunks of ten messages on two channels; message k has the text "message k".
std::string sample_file(int zstd_level = 3, bool finish = true) {
  MemoryOutput output;
  Writer writer(output, {.profile = "test", .zstd_level = zstd_level});
  const uint16_t schema = writer.add_schema("a.Schema", "jsonschema", "{}");
  const uint16_t even = writer.add_channel(schema, "/even", "json", {{"unit", "none"}});
  const uint16_t odd = writer.add_channel(0, "/odd", "json");
  writer.attach({.log_time_ns = 5, .name = "a.txt", .media_type = "text/plain", .data = "hello"});
  for (int k = 0; k < 80; ++k) {
    writer.write(k % 2 ? odd : even, 1000 + k, "message " + std::to_string(k));
    if (k % 10 == 9) writer.flush();
  }
  writer.add_metadata({"facts", {{"seed", "7"}}});
  if (finish) writer.finish();
  return output.bytes();
}

std::vector<std::string> all_messages(const Reader& reader) {
  std::vector<std::string> texts;
  for (const ChunkPlace& chunk : reader.contents().chunks) {
    reader.for_each_message(chunk,
                            [&](const Message& message) { texts.emplace_back(message.data); });
  }
  return texts;
}

std::vector<std::string> visited(const std::string& file, Contents* contents = nullptr) {
  std::vector<std::string> texts;
  const Contents found =
      scan_messages(*memory(file), {}, [&](const Contents& so_far, const Message& message) {
        texts.push_back(so_far.channels.at(message.channel_id).topic + " " +
                        std::string(message.data));
      });
  if (contents != nullptr) *contents = found;
  return texts;
}

TEST(Mcap, MessagesOfOtherWritersNeedNoChunks) {
  ByteSink sink;
  sink.raw(kMagic);
  append(sink, Header{.profile = "ros2", .library = "other"});
  append(sink, Schema{.id = 1, .name = "a/msg/B", .encoding = "ros2msg", .data = ""});
  append(sink, Channel{.id = 0, .schema_id = 1, .topic = "/a", .message_encoding = "cdr"});
  for (uint64_t k = 0; k < 20; ++k)
    append(sink,
           Message{.channel_id = 0, .log_time_ns = k, .publish_time_ns = k, .data = "twelve"});
  ByteSink end;
  append(end, DataEnd{});
  append(end, Footer{});
  const std::string whole = sink.bytes() + end.bytes() + std::string(kMagic);
  Contents contents;
  EXPECT_EQ(visited(whole, &contents), std::vector<std::string>(20, "/a twelve"));
  EXPECT_TRUE(contents.complete);
  // Cut, all that stands before is there and the cut is reported.
  EXPECT_EQ(visited(sink.bytes().substr(0, sink.bytes().size() - 3), &contents).size(), 19u);
  ASSERT_EQ(contents.losses.size(), 1u);
  EXPECT_THAT(contents.losses[0].what, HasSubstr("ends in the middle of a record"));
  // Chunks are visited once they are whole; our own files hold nothing beside them.
  EXPECT_EQ(visited(sample_file()).size(), 80u);
  EXPECT_EQ(visited(sample_file(3, false)).size(), 80u);
  EXPECT_FALSE(Reader::scan(memory(whole)).contents().losses.empty());
}

TEST(Mcap, ReadsBackWhatWasWritten) {
  for (const int level : {0, 3}) {
    for (const bool scan : {false, true}) {
      const std::string file = sample_file(level);
      const Reader reader = scan ? Reader::scan(memory(file)) : Reader::open(memory(file));
      const Contents& contents = reader.contents();
      EXPECT_TRUE(contents.losses.empty());
      EXPECT_TRUE(contents.complete);
      EXPECT_EQ(contents.header.profile, "test");
      EXPECT_EQ(contents.schemas.at(1).name, "a.Schema");
      EXPECT_EQ(contents.channels.at(1).metadata.at("unit"), "none");
      EXPECT_EQ(contents.channels.at(2).topic, "/odd");
      ASSERT_EQ(contents.chunks.size(), 8u);
      EXPECT_EQ(contents.chunks[3].start_time_ns, 1030u);
      EXPECT_EQ(contents.chunks[3].end_time_ns, 1039u);
      EXPECT_EQ(contents.chunks[3].channels, (std::vector<uint16_t>{1, 2}));
      ASSERT_EQ(contents.attachments.size(), 1u);
      EXPECT_EQ(reader.read_attachment(contents.attachments[0]).data, "hello");
      ASSERT_EQ(contents.metadata.size(), 1u);
      EXPECT_EQ(contents.metadata[0].values.at("seed"), "7");
      const std::vector<std::string> texts = all_messages(reader);
      ASSERT_EQ(texts.size(), 80u);
      for (int k = 0; k < 80; ++k) EXPECT_EQ(texts[k], "message " + std::to_string(k));
    }
  }
}

TEST(Mcap, WithoutAnEndTheScanFindsEverythingThatWasFlushed) {
  const Reader reader = Reader::open(memory(sample_file(3, false)));
  EXPECT_FALSE(reader.contents().complete);
  EXPECT_EQ(reader.contents().losses.size(), 1u);
  EXPECT_EQ(all_messages(reader).size(), 80u);
}

TEST(Mcap, CutAnywhereEverythingBeforeIsRead) {
  const std::string file = sample_file();
  const Contents whole = Reader::scan(memory(file)).contents();
  for (size_t cut = kMagic.size(); cut < file.size(); ++cut) {
    size_t whole_chunks = 0;
    for (const ChunkPlace& chunk : whole.chunks) {
      whole_chunks += chunk.offset + chunk.length <= cut;
    }
    if (whole_chunks == 0) continue;  // May be an error: nothing is left.
    const Reader reader = Reader::open(memory(file.substr(0, cut)));
    EXPECT_EQ(reader.contents().chunks.size(), whole_chunks) << cut;
    EXPECT_FALSE(reader.contents().losses.empty()) << cut;
    EXPECT_EQ(all_messages(reader).size(), 10 * whole_chunks) << cut;
  }
}

TEST(Mcap, OneWrongByteCostsOneChunkAtMost) {
  const std::string file = sample_file();
  for (size_t at = 0; at < file.size(); ++at) {
    std::string damaged = file;
    damaged[at] ^= 0x41;
    const Reader reader = Reader::scan(memory(damaged));
    EXPECT_GE(all_messages(reader).size(), 70u) << at;
    if (all_messages(reader).size() < 80u) {
      EXPECT_FALSE(reader.contents().losses.empty()) << at;
    }
  }
}

TEST(Mcap, DefinitionsAreFoundAgainBehindADamagedStart) {
  MemoryOutput output;
  Writer writer(output, {});
  const uint16_t channel = writer.add_channel(0, "/late", "json");
  writer.write(channel, 1, "one");
  writer.flush();
  writer.repeat_definitions();
  writer.write(channel, 2, "two");
  writer.flush();
  std::string file = output.bytes();
  std::fill(file.begin(), file.begin() + 60, '\xEE');
  const Reader reader = Reader::open(memory(file));
  EXPECT_EQ(reader.contents().channels.at(channel).topic, "/late");
}

TEST(Mcap, RandomDamageNeverDoesMoreThanThrow) {
  const std::string file = sample_file();
  const RandomStream stream{7, 1};
  for (uint64_t round = 0; round < 3000; ++round) {
    std::string damaged = file;
    auto draw = [&, index = uint64_t{0}](uint64_t below) mutable {
      return random_bits(stream.child(round), index++)[0] % below;
    };
    for (uint64_t hits = 1 + draw(20); hits > 0; --hits) {
      damaged[draw(damaged.size())] = static_cast<char>(draw(256));
    }
    if (draw(3) == 0) damaged.resize(draw(damaged.size()));
    try {
      const Reader reader = Reader::open(memory(damaged));
      for (const ChunkPlace& chunk : reader.contents().chunks) {
        try {
          reader.for_each_message(chunk, [](const Message&) {});
        } catch (const InputError&) {
        }
      }
    } catch (const InputError&) {
    }
  }
}

TEST(Mcap, HostileLengthsAreRefusedBeforeMemoryIsTaken) {
  // A record that claims 2^63 bytes.
  ByteSink sink;
  sink.raw(kMagic);
  sink.number(static_cast<uint8_t>(Opcode::header));
  sink.number(uint64_t{1} << 63);
  EXPECT_THROW(Reader::open(memory(sink.bytes())), InputError);

  // A chunk that claims to unpack to far more than its bytes can hold.
  ByteSink bomb;
  bomb.raw(kMagic);
  append(bomb, Header{});
  append(bomb, Chunk{0, 0, uint64_t{1} << 40, 1, "zstd", "tiny"});
  const Reader reader = Reader::open(memory(bomb.bytes()));
  EXPECT_TRUE(reader.contents().chunks.empty());
  ASSERT_FALSE(reader.contents().losses.empty());
  EXPECT_THAT(reader.contents().losses[0].what, HasSubstr("claims to unpack"));
}

// As other writers pack their chunks.
TEST(Mcap, ChunksOfLz4AreReadAndDamagedOnesRefused) {
  ByteSink inside;
  append(inside, Message{0, 0, 7, 7, "a message that is long enough to be packed, packed, packed"});
  std::string packed(LZ4F_compressFrameBound(inside.size(), nullptr), '\0');
  packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), inside.bytes().data(),
                                   inside.size(), nullptr));
  const uint32_t crc = crc32(inside.bytes());
  const Chunk whole{7, 7, inside.size(), crc, "lz4", packed};
  EXPECT_EQ(unpack(whole, {}), inside.bytes());
  for (const size_t cut : {packed.size() - 1, packed.size() / 2, size_t{3}, size_t{0}}) {
    const Chunk damaged{7, 7, inside.size(), crc, "lz4", std::string_view(packed).substr(0, cut)};
    EXPECT_THROW(unpack(damaged, {}), Malformed);
  }
  for (const uint64_t size :
       {uint64_t{1}, inside.size() - 1, inside.size() + 1, uint64_t{1} << 40}) {
    const Chunk lies{7, 7, size, 0, "lz4", packed};
    EXPECT_THROW(unpack(lies, {}), Malformed);
  }
}

TEST(Mcap, ZerosThatWouldLookLikeABombAreStoredAndReadBack) {
  MemoryOutput output;
  Writer writer(output, {.chunk_bytes = uint64_t{32} << 20});
  const uint16_t channel = writer.add_channel(0, "/zeros", "json");
  const std::string zeros(8 << 20, '\0');
  writer.write(channel, 1, zeros);
  writer.finish();
  const Reader reader = Reader::open(memory(output.bytes()));
  const std::vector<std::string> texts = all_messages(reader);
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_TRUE(texts[0] == zeros);
}

TEST(Mcap, AnIndexThatNamesOneChunkTwiceIsNotBelieved) {
  ByteSink data;
  data.raw(kMagic);
  append(data, Header{});
  const uint64_t chunk_offset = data.size();
  append(data, Chunk{0, 0, 4, crc32("abcd"), "", "abcd"});
  const uint64_t chunk_length = data.size() - chunk_offset;
  append(data, DataEnd{});
  ByteSink summary;
  for (int i = 0; i < 2; ++i) append(summary, ChunkIndex{0, 0, chunk_offset, chunk_length});
  Footer footer{data.size(), 0, 0};
  ByteSink record;
  append(record, footer);
  footer.summary_crc =
      crc32(std::string_view(record.bytes()).substr(0, record.size() - 4), crc32(summary.bytes()));
  data.raw(summary.bytes());
  append(data, footer);
  data.raw(kMagic);
  const MemoryInput input(data.bytes());
  EXPECT_THROW(read_summary(input, {}), Malformed);
}

TEST(Mcap, SaysWhatIsNoLog) {
  EXPECT_THROW(Reader::open(memory("")), InputError);
  EXPECT_THROW(Reader::open(memory("a text file that is no log at all, but long enough")),
               InputError);
  EXPECT_THROW(open_file("/nonexistent/file.mcap"), InputError);
}

}  // namespace
}  // namespace seam::mcap
