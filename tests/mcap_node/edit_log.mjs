// Writes a changed copy of a log with the independent MCAP writer:
//   node edit_log.mjs same F G            the same messages
//   node edit_log.mjs break-command F G   one byte of one command is another
//   node edit_log.mjs older F G           without what early logs lacked
// With break-command it prints what was changed.
import { open, writeFile } from "node:fs/promises";
import { McapIndexedReader, McapWriter } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";
import { FileHandleReadable } from "./readable.mjs";

class MemoryWritable {
  parts = [];
  size = 0n;
  position() {
    return this.size;
  }
  async write(bytes) {
    this.parts.push(Buffer.from(bytes));  // A copy: the writer uses its buffer again.
    this.size += BigInt(bytes.length);
  }
}

function typeOf(schema) {
  const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
  return root.lookupType(schema.name);
}

// One bit of the fifth byte of a double: a relative change of about 2^-20.
function nudge(value) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, value);
  view.setUint8(3, view.getUint8(3) ^ 1);
  return view.getFloat64(0);
}

// Changes the first number other than 0 of a decision's command; returns its name.
function breakCommand(decision) {
  for (const part of ["head", "walk"]) {
    for (const [name, value] of Object.entries(decision?.[part] ?? {})) {
      if (typeof value !== "number" || value === 0) continue;
      decision[part][name] = nudge(value);
      return `${part}.${name}`;
    }
  }
  for (const frame of decision?.joints ?? []) {
    for (const target of frame.targets ?? []) {
      if (!target.angle_rad) continue;
      target.angle_rad = nudge(target.angle_rad);
      return "joints.targets.angle_rad";
    }
  }
  return undefined;
}

const [mode, input, output] = process.argv.slice(2);
const handle = await open(input);
const reader = await McapIndexedReader.Initialize({
  readable: new FileHandleReadable(handle),
  decompressHandlers: { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) },
});
const writable = new MemoryWritable();
const writer = new McapWriter({ writable, chunkSize: 64 * 1024 });
await writer.start({ profile: reader.header.profile, library: "edited" });
const schemaIds = new Map();
const types = new Map();
for (const [id, schema] of reader.schemasById) {
  schemaIds.set(id, await writer.registerSchema(schema));
  types.set(id, typeOf(schema));
}
const channelIds = new Map();
for (const [id, channel] of reader.channelsById) {
  channelIds.set(id, await writer.registerChannel({ ...channel, schemaId: schemaIds.get(channel.schemaId) }));
}
if (mode !== "older") {
  for await (const attachment of reader.readAttachments()) await writer.addAttachment(attachment);
}
const middle = reader.statistics.messageEndTime / 2n;
let broken;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const type = types.get(channel.schemaId);
  let data = message.data;
  if (mode === "older") {
    if (channel.topic === "/seam/snapshot") continue;
    if (channel.topic === "/seam/step") {
      const step = type.decode(data);
      step.field_sums = [];
      step.field_checks = new Uint8Array();
      step.poses = [];
      data = type.encode(step).finish();
    }
  }
  if (mode === "break-command" && !broken && channel.topic === "/seam/turn" && message.logTime >= middle) {
    const turn = type.decode(data);
    for (const answer of turn.answers) {
      const field = breakCommand(answer.decision);
      if (!field) continue;
      broken = { time_ns: Number(message.logTime), robot: answer.robot ?? 0, field };
      data = type.encode(turn).finish();
      break;
    }
  }
  await writer.addMessage({ ...message, data, channelId: channelIds.get(message.channelId) });
}
await writer.end();
await handle.close();
await writeFile(output, Buffer.concat(writable.parts));
if (mode === "break-command") console.log(JSON.stringify(broken));
