// Listens to a live view with Foxglove's own client: node check_foxglove.mjs PORT SECONDS TOPIC...
// Subscribes to every channel, decodes each message with the schema that its channel advertises, and prints how many of
// each topic were decoded, as JSON. Exit code 1 when one of the named topics had none, or a message could not be decoded.
// Modules (@foxglove/ws-protocol, @foxglove/rosmsg, @foxglove/rosmsg2-serialization, ws) are looked up in the folder
// $OMNIFLIGHT_NODE_MODULES.
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(join(process.env.OMNIFLIGHT_NODE_MODULES ?? ".", "_.js"));
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { WebSocket } = require("ws");

const [port, seconds, ...wanted] = process.argv.slice(2);
const decoders = new Map(), counts = {}, topics = new Map();
const fail = (text) => {
  console.error(text);
  process.exit(1);
};
const decoder = (channel) => {
  if (channel.encoding === "json") return (data) => JSON.parse(new TextDecoder().decode(data));
  if (channel.encoding !== "cdr") fail(`${channel.topic} is encoded as ${channel.encoding}`);
  const reader = new MessageReader(parse(channel.schema, { ros2: true }));
  return (data) => reader.readMessage(data);
};

const client = new FoxgloveClient({
  ws: new WebSocket(`ws://127.0.0.1:${port}`, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});
client.on("error", (error) => fail(String(error)));
client.on("status", (status) => fail(JSON.stringify(status)));
client.on("advertise", (channels) => {
  for (const channel of channels) {
    decoders.set(client.subscribe(channel.id), decoder(channel));
    topics.set([...decoders.keys()].at(-1), channel.topic);
    counts[channel.topic] ??= 0;
  }
});
client.on("message", ({ subscriptionId, data }) => {
  const topic = topics.get(subscriptionId);
  try {
    decoders.get(subscriptionId)(data);
  } catch (error) {
    fail(`${topic}: ${error}`);
  }
  ++counts[topic];
  if (wanted.every((name) => counts[name] > 0)) finish();
});
const finish = () => {
  console.log(JSON.stringify(counts));
  const silent = wanted.filter((name) => !counts[name]);
  if (silent.length > 0) fail(`nothing came on ${silent}`);
  process.exit(0);
};
setTimeout(finish, 1000 * Number(seconds));
