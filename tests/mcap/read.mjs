// Reads an .mcap with the makers' library and prints a JSON line for each message in the order of the log, then one of the rest.
import { createHash } from "node:crypto";
import { open } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";

const file = await open(process.argv[2]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    const { bytesRead } = await file.read(bytes, 0, bytes.length, Number(offset));
    if (bytesRead !== bytes.length) throw new Error(`${length} bytes wanted at ${offset}, ${bytesRead} are there`);
    return bytes;
  },
};
const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };
const say = (value) => console.log(JSON.stringify(value, (_, v) => (typeof v === "bigint" ? String(v) : v)));

const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  const json = channel.messageEncoding === "json";
  say({
    topic: channel.topic, schema: schema.name, sequence: message.sequence, time_ns: message.logTime,
    ...(json ? { message: JSON.parse(new TextDecoder().decode(message.data)) }
             : { sha256: createHash("sha256").update(message.data).digest("hex") }),
  });
}

// The same file as a stream, for its attachments and its checksums.
const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
const chunk = new Uint8Array(1 << 16);
const kinds = {}, attachments = {};
for (let bytes; (bytes = (await file.read(chunk, 0, chunk.length)).bytesRead) > 0; ) {
  stream.append(chunk.slice(0, bytes));
  for (let record; (record = stream.nextRecord()); ) {
    kinds[record.type] = (kinds[record.type] ?? 0) + 1;
    if (record.type === "Attachment") attachments[record.name] = new TextDecoder().decode(record.data);
  }
}
say({ profile: reader.header.profile, done: stream.done(), kinds, attachments, statistics: reader.statistics.messageCount });
