// Reads an MCAP file by its index with the reference reader: read.mjs FILE prints one JSON object about it, and a line for each message.
import { McapIndexedReader } from "@mcap/core";
import { execFileSync } from "node:child_process";
import { open } from "node:fs/promises";

const file = await open(process.argv[2]);
const size = BigInt((await file.stat()).size);
const readable = {
  size: async () => size,
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, Number(length), Number(offset));
    return bytes;
  },
};
const decompressHandlers = {
  zstd: (bytes, size) => execFileSync("zstd", ["--decompress", "--stdout"], { input: bytes, maxBuffer: Number(size) }),
};
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const channels = [...reader.channelsById.values()].map((channel) => {
  const schema = reader.schemasById.get(channel.schemaId);
  return { topic: channel.topic, encoding: channel.messageEncoding, schema: schema.name, schema_encoding: schema.encoding,
           descriptors: Buffer.from(schema.data).toString("base64") };
});
const lines = [JSON.stringify({ channels, compressions: [...new Set(reader.chunkIndexes.map((chunk) => chunk.compression))],
  chunks: reader.chunkIndexes.length, messages: Number(reader.statistics.messageCount) })];
for await (const message of reader.readMessages({ validateCrcs: true }))
  lines.push(`${reader.channelsById.get(message.channelId).topic} ${message.logTime} ${Buffer.from(message.data).toString("base64")}`);
process.stdout.write(lines.join("\n") + "\n");
