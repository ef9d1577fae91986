// Checks an MCAP file with the reference reader: node check_mcap.mjs FILE
// Modules (@mcap/core, @foxglove/rosmsg, @foxglove/rosmsg2-serialization, fzstd) are looked up in the folder
// $OMNIFLIGHT_NODE_MODULES. All CRCs are validated, twice: as a stream and through the indexes; the bytes of each
// PoseStamped must come out the same when they are decoded and encoded again.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(join(process.env.OMNIFLIGHT_NODE_MODULES ?? ".", "_.js"));
const { McapStreamReader, McapIndexedReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { decompress } = require("fzstd");

const fail = (text) => {
  console.error(text);
  process.exit(1);
};
const bytes = readFileSync(process.argv[2]);
const decompressHandlers = { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) };

const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
stream.append(bytes);
const streamed = new Map();
for (let record; (record = stream.nextRecord()); ) streamed.set(record.type, (streamed.get(record.type) ?? 0) + 1);
if (!stream.done()) fail("the stream reader did not reach the end");

const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
};
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
if (reader.header.profile !== "ros2") fail(`profile is ${reader.header.profile}`);
let messages = 0, poses = 0, last = -1n;
for await (const message of reader.readMessages({ validateCrcs: true })) {
  ++messages;
  if (message.logTime < last) fail("messages are not ordered by log time");
  last = message.logTime;
  const channel = reader.channelsById.get(message.channelId);
  if (!channel.metadata.has("offered_qos_profiles")) fail(`${channel.topic} has no offered_qos_profiles`);
  const schema = reader.schemasById.get(channel.schemaId);
  const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
  const decoded = new MessageReader(definitions).readMessage(message.data);
  if (schema.name !== "geometry_msgs/msg/PoseStamped") continue;
  const again = new MessageWriter(definitions).writeMessage(decoded);
  if (Buffer.compare(Buffer.from(again), Buffer.from(message.data)) !== 0) fail(`pose ${poses} encodes differently`);
  ++poses;
}
if (Number(reader.statistics.messageCount) !== messages || streamed.get("Message") !== messages)
  fail(`messages: statistics ${reader.statistics.messageCount}, stream ${streamed.get("Message")}, index ${messages}`);
if (reader.statistics.chunkCount !== reader.chunkIndexes.length) fail("chunk count and chunk indexes differ");
let metadata = 0, attachments = 0;
for await (const _ of reader.readMetadata()) ++metadata;
for await (const _ of reader.readAttachments({ validateCrcs: true })) ++attachments;
console.log(JSON.stringify({ messages, poses, metadata, attachments, chunks: reader.chunkIndexes.length }));
