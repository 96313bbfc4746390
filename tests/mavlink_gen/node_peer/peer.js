// SPDX-License-Identifier: BSD-3-Clause
// Exchanges packets of every message between our codec and node-mavlink, both ways, plain and signed.
// usage: node peer.js <path of mavlink_peer>
'use strict';

const { spawnSync } = require('child_process');
const { Readable } = require('stream');
const assert = require('assert');
const mavlink = require('node-mavlink');

const program = process.argv[2];
const classes = { ...mavlink.minimal.REGISTRY, ...mavlink.standard.REGISTRY, ...mavlink.common.REGISTRY };
const key = mavlink.MavLinkPacketSignature.key('peer');
const lines = (text) => text.split('\n').filter((line) => line !== '').map((line) => JSON.parse(line));

function run(args, input) {
  const result = spawnSync(program, args, { input, encoding: 'utf8', maxBuffer: 1 << 28 });
  assert.strictEqual(result.status, 0, result.stderr || String(result.error));
  return lines(result.stdout);
}

// One value of node-mavlink in the form that our program prints.
function plain(value, field) {
  if (Array.isArray(value)) return value.map((element) => plain(element, field));
  if (typeof value === 'bigint') return value.toString();
  return value;
}

function expectFields(actual, expected, where) {
  for (const [name, value] of Object.entries(expected)) {
    if (actual[name] !== undefined) assert.deepStrictEqual(actual[name], value, `${where}.${name}`);
  }
}

// node-mavlink must read our packets.
async function readOurs(sent, signed) {
  const bytes = Buffer.concat(sent.map((packet) => Buffer.from(packet.hex, 'hex')));
  const stream = Readable.from([bytes]).pipe(new mavlink.MavLinkPacketSplitter())
    .pipe(new mavlink.MavLinkPacketParser());
  let count = 0;
  for await (const packet of stream) {
    const expected = sent[count++];
    const type = classes[packet.header.msgid];
    assert.strictEqual(packet.header.msgid, expected.id);
    assert.strictEqual(packet.header.seq, expected.sequence);
    if (signed) assert.ok(packet.signature.matches(key), `signature of ${type.MSG_NAME}`);
    const data = packet.protocol.data(packet.payload, type);
    const actual = {};
    for (const field of type.FIELDS) actual[field.source] = plain(data[field.name], field);
    expectFields(actual, expected.fields, type.MSG_NAME);
  }
  assert.strictEqual(count, sent.length, 'node-mavlink found another number of packets');
}

function restored(value, field) {
  if (Array.isArray(value)) return value.map((element) => restored(element, field));
  return /^u?int64/.test(field.type) ? BigInt(value) : value;
}

// node-mavlink packs the same values.
function packTheirs(sent, signed) {
  const protocol = new mavlink.MavLinkProtocolV2(42, 7, signed ? mavlink.MavLinkProtocolV2.IFLAG_SIGNED : 0);
  let time = Date.UTC(2024, 0, 1);
  return sent.map((packet) => {
    const type = classes[packet.id];
    const message = new type();
    for (const field of type.FIELDS) {
      const value = packet.fields[field.source];
      if (value !== undefined) message[field.name] = restored(value, field);
    }
    const bytes = protocol.serialize(message, packet.sequence);
    return signed ? protocol.sign(bytes, 5, key, time++) : bytes;
  });
}

async function exchange(signed) {
  const flags = signed ? ['--signed'] : [];
  const all = run(['send', ...flags]);
  const sent = all.filter((packet) => classes[packet.id] !== undefined);
  const missing = new Set(all.filter((packet) => classes[packet.id] === undefined).map((packet) => packet.id));
  await readOurs(sent, signed);
  const theirs = packTheirs(sent, signed);
  if (!signed) {
    theirs.forEach((bytes, i) => assert.strictEqual(bytes.toString('hex'), sent[i].hex,
                                                    classes[sent[i].id].MSG_NAME));
  }
  const received = run(['receive', ...flags], theirs.map((bytes) => bytes.toString('hex')).join('\n') + '\n');
  assert.strictEqual(received.length, sent.length);
  received.forEach((packet, i) => {
    assert.strictEqual(packet.id, sent[i].id);
    assert.strictEqual(packet.accepted, true, `signature of packet ${i}`);
    assert.deepStrictEqual(packet.fields, sent[i].fields);
  });
  console.log(`${signed ? 'signed' : 'plain'}: ${sent.length} packets of ${new Set(sent.map((p) => p.id)).size}` +
              ` messages agree both ways; ${missing.size} messages unknown to node-mavlink`);
}

exchange(false).then(() => exchange(true)).catch((error) => {
  console.error(error.message);
  process.exit(1);
});
