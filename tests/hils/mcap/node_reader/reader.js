// SPDX-License-Identifier: BSD-3-Clause
// usage: node reader.js FOLDER: reads FOLDER/flight.mcap with @mcap/core, through its index and from begin to end, and
// holds it to the run's other files.
import {McapIndexedReader, McapStreamReader} from '@mcap/core';
import {decompress} from 'fzstd';
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';

const folder = process.argv[2];
const bytes = readFileSync(join(folder, 'flight.mcap'));
const decompressHandlers = {zstd: (data) => decompress(data)};
const kSecond = 1_000_000_000n;
const text = new TextDecoder();

class FileBytes {
  reads = 0;
  async size() {
    return BigInt(bytes.length);
  }
  async read(offset, length) {
    this.reads += Number(length);
    return new Uint8Array(bytes.subarray(Number(offset), Number(offset + length)));
  }
}

/** A value against its schema: types, and no field that the schema lacks. */
function check(schema, value, path) {
  if (value === null && schema.type === 'number') return; // not a number
  switch (schema.type) {
    case 'object':
      assert.equal(typeof value, 'object', path);
      for (const [key, inner] of Object.entries(value)) {
        assert.ok(key in schema.properties, `${path}.${key} is not in the schema`);
        check(schema.properties[key], inner, `${path}.${key}`);
      }
      return;
    case 'array':
      assert.ok(Array.isArray(value), path);
      value.forEach((inner, i) => check(schema.items, inner, `${path}[${i}]`));
      return;
    case 'integer':
      assert.ok(Number.isInteger(value), `${path}: ${value}`);
      return;
    default:
      assert.equal(typeof value, schema.type, path);
  }
}

/** Packets of the flight log: eight bytes of time, then MAVLink 1 or 2. */
function tlogPackets() {
  const log = readFileSync(join(folder, 'flight.tlog'));
  const ids = new Map();
  for (let at = 0; at < log.length;) {
    const packet = at + 8;
    const isV2 = log[packet] === 0xfd;
    assert.ok(isV2 || log[packet] === 0xfe, `no packet at byte ${packet} of the log`);
    const signed = isV2 && (log[packet + 2] & 1) !== 0;
    const id = isV2 ? log.readUIntLE(packet + 7, 3) : log[packet + 5];
    ids.set(id, (ids.get(id) ?? 0) + 1);
    at = packet + (isV2 ? 12 + (signed ? 13 : 0) : 8) + log[packet + 1];
  }
  return ids;
}

const truth = readFileSync(join(folder, 'truth.csv'), 'utf8').trim().split('\n').slice(1).map((line) => line.split(',').map(Number));
const commands = readFileSync(join(folder, 'sensors/motor_command.csv'), 'utf8').trim().split('\n').length - 1;

// From begin to end, with every checksum.
const stream = new McapStreamReader({decompressHandlers, validateCrcs: true});
stream.append(bytes);
const schemas = new Map();
const channels = new Map();
const counts = new Map();
const entities = [];
let last = 0n;
for (let record = stream.nextRecord(); record; record = stream.nextRecord()) {
  if (record.type === 'Schema') schemas.set(record.id, {...record, json: JSON.parse(text.decode(record.data))});
  if (record.type === 'Channel') channels.set(record.id, record);
  if (record.type !== 'Message') continue;
  const channel = channels.get(record.channelId);
  const schema = schemas.get(channel.schemaId);
  const value = JSON.parse(text.decode(record.data));
  check(schema.json, value, channel.topic);
  assert.ok(record.logTime >= last, 'messages are in order of time');
  assert.equal(record.sequence, counts.get(channel.topic) ?? 0);
  last = record.logTime;
  counts.set(channel.topic, record.sequence + 1);
  if (value.timestamp) {
    assert.equal(BigInt(value.timestamp.sec) * kSecond + BigInt(value.timestamp.nsec), record.logTime);
  }
  if (channel.topic === '/scene') entities.push(...value.entities);
}
assert.ok(stream.done());
for (const schema of schemas.values()) {
  assert.equal(schema.encoding, 'jsonschema');
  assert.equal(schema.json.title, schema.name);
}
for (const channel of channels.values()) assert.equal(channel.messageEncoding, 'json');
const schemaOf = (topic) => schemas.get([...channels.values()].find((channel) => channel.topic === topic).schemaId).name;
assert.equal(schemaOf('/tf'), 'foxglove.FrameTransform');
assert.equal(schemaOf('/scene'), 'foxglove.SceneUpdate');
assert.equal(schemaOf('/location'), 'foxglove.LocationFix');
assert.equal(schemaOf('/mavlink/ATTITUDE'), 'mavlink.ATTITUDE');

// As many of each as the run's other files have.
assert.equal(counts.get('/truth'), truth.length);
assert.equal(counts.get('/motors'), truth.length);
assert.equal(counts.get('/motor_command'), commands);
const packets = tlogPackets();
const kAttitude = 30;
const kLocalPositionNed = 32;
assert.equal(counts.get('/mavlink/ATTITUDE'), packets.get(kAttitude));
assert.equal(counts.get('/mavlink/LOCAL_POSITION_NED'), packets.get(kLocalPositionNed));
const mavlink = [...counts].filter(([topic]) => topic.startsWith('/mavlink/'));
assert.equal(mavlink.length, packets.size);
const sum = (values) => values.reduce((all, value) => all + value, 0);
assert.equal(sum(mavlink.map(([, count]) => count)), sum([...packets.values()]));
assert.equal(counts.get('/scene'), 1);
assert.ok(entities.some((entity) => entity.frame_id !== 'world' && entity.cylinders.length >= 4), 'discs of the rotors');

// By the index: statistics, and a second of one topic without the rest of the file.
const file = new FileBytes();
const indexed = await McapIndexedReader.Initialize({readable: file, decompressHandlers});
const {statistics} = indexed;
assert.equal(statistics.messageCount, BigInt(sum([...counts.values()])));
assert.equal(statistics.channelCount, channels.size);
assert.equal(statistics.schemaCount, schemas.size);
assert.equal(statistics.chunkCount, indexed.chunkIndexes.length);
assert.ok(statistics.chunkCount >= 5);
assert.equal(statistics.messageStartTime, 0n);
assert.equal(statistics.messageEndTime, last);
for (const [id, count] of statistics.channelMessageCounts) {
  assert.equal(count, BigInt(counts.get(channels.get(id).topic)), channels.get(id).topic);
}
assert.ok(indexed.chunkIndexes.every((chunk) => chunk.uncompressedSize <= 1n << 20n));
const metadata = [];
for await (const record of indexed.readMetadata({name: 'cas'})) metadata.push(record);
assert.equal(metadata[0].metadata.get('scenario'), 'hover');

file.reads = 0;
const begin = 20n * kSecond;
const found = [];
for await (const message of indexed.readMessages({topics: ['/truth'], startTime: begin, endTime: begin + kSecond})) {
  found.push({time: message.logTime, value: JSON.parse(text.decode(message.data))});
}
const wanted = truth.filter(([t]) => t >= 20 && t <= 21 + 1e-9);
assert.equal(found.length, wanted.length);
found.forEach(({time, value}, i) => {
  const [t, x, y, z, vx, vy, vz, roll, pitch, yaw, p, q, r] = wanted[i];
  const near = (a, b, what) => assert.ok(Math.abs(a - b) <= 1e-6 * Math.max(1, Math.abs(b)), `${what}: ${a}, ${b}`);
  near(Number(time) / 1e9, t, 't');
  // truth.csv has north, east, up and forward, right, down; here are east, north, up and forward, left, up.
  const {position, velocity, angular_velocity: w, orientation} = value;
  [[position.x, y], [position.y, x], [position.z, z], [velocity.x, vy], [velocity.y, vx], [velocity.z, vz], [w.x, p], [w.y, -q],
    [w.z, -r], [value.roll, roll], [value.pitch, pitch], [value.yaw, yaw]].forEach(([a, b], j) => near(a, b, `number ${j}`));
  // Where the nose points: its east and north by the quaternion, and by yaw from north.
  const {x: qx, y: qy, z: qz, w: qw} = orientation;
  const east = 1 - 2 * (qy * qy + qz * qz);
  const north = 2 * (qx * qy + qw * qz);
  assert.ok(Math.abs(Math.atan2(east, north) - yaw) < 1e-5, 'the nose is where yaw says');
});
assert.ok(file.reads < bytes.length / 3, `${file.reads} of ${bytes.length} bytes were read for one second`);
console.log(`flight.mcap: ${statistics.messageCount} messages on ${channels.size} channels in ${statistics.chunkCount} chunks, ${bytes.length} bytes`);
