// Reads a log with the independent MCAP reader (@mcap/core) and says what it found: the file's
// order, its CRCs, counts by channel through index and stream, and whether each message decodes by
// the schema that stands in the file.
import { readFileSync } from "node:fs";
import { open } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { FileHandleReadable } from "./readable.mjs";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };

// The message type of a channel from the FileDescriptorSet in its schema.
function typeOf(schema) {
  if (schema.encoding !== "protobuf") throw new Error(`schema ${schema.name}: ${schema.encoding}`);
  const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
  return root.lookupType(schema.name);
}

async function readIndexed(path) {
  const handle = await open(path);
  try {
    const reader = await McapIndexedReader.Initialize({
      readable: new FileHandleReadable(handle), decompressHandlers });
    const types = new Map();
    for (const [id, schema] of reader.schemasById) types.set(id, typeOf(schema));
    const counts = {};
    let last = -1n;
    let ordered = true;
    for await (const message of reader.readMessages()) {
      const channel = reader.channelsById.get(message.channelId);
      counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
      const type = types.get(channel.schemaId);
      const decoded = type.decode(message.data);
      const again = type.encode(decoded).finish();
      if (again.length !== message.data.length) throw new Error(`${channel.topic}: fields are lost`);
      ordered &&= message.logTime >= last;
      last = message.logTime;
    }
    const attachments = [];
    for await (const attachment of reader.readAttachments()) attachments.push(attachment.name);
    return {
      counts, ordered, attachments, end_ns: String(last),
      statistics: Number(reader.statistics.messageCount),
      chunks: reader.chunkIndexes.length,
      schemas: [...reader.schemasById.values()].map((schema) => schema.name).sort(),
      profile: reader.header.profile, library: reader.header.library,
    };
  } finally {
    await handle.close();
  }
}

// From the first byte to the last, with every CRC checked.
function readStream(path) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true, includeChunks: true });
  reader.append(readFileSync(path));
  const records = {};
  for (let record; (record = reader.nextRecord());) {
    records[record.type] = (records[record.type] ?? 0) + 1;
  }
  if (!reader.done()) throw new Error("the stream ends before the closing magic");
  return records;
}

const path = process.argv[2];
const indexed = await readIndexed(path);
const stream = readStream(path);
const total = Object.values(indexed.counts).reduce((a, b) => a + b, 0);
if (total !== indexed.statistics) throw new Error(`${total} messages by index, ${indexed.statistics} by statistics`);
if (total !== stream.Message) throw new Error(`${total} messages by index, ${stream.Message} by stream`);
if (indexed.chunks !== stream.Chunk) throw new Error(`${indexed.chunks} chunks by index, ${stream.Chunk} by stream`);
if (!indexed.ordered) throw new Error("messages out of the order of time");
console.log(JSON.stringify({ ...indexed, stream }));
