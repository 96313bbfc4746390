// SPDX-License-Identifier: BSD-3-Clause
// The far end of the emulated controller's line, spoken by node-mavlink alone: packets out, packets
// in, and a simulated vehicle that stands still. Messages are given and taken by the field names of
// the MAVLink definition.
'use strict';

const fs = require('fs');
const { PassThrough } = require('stream');
const mavlink = require('node-mavlink');

const REGISTRY = { ...mavlink.minimal.REGISTRY, ...mavlink.standard.REGISTRY, ...mavlink.common.REGISTRY };
const BY_NAME = Object.fromEntries(Object.values(REGISTRY).map((type) => [type.MSG_NAME, type]));
const PATIENCE_MS = 20000;
const WIDE = /^u?int64/;

class VehicleLine {
  constructor(path, system, component) {
    this.fd = fs.openSync(path, fs.constants.O_RDWR | fs.constants.O_NOCTTY | fs.constants.O_NONBLOCK);
    this.protocol = new mavlink.MavLinkProtocolV2(system, component);
    this.simulator = new mavlink.MavLinkProtocolV2(1, 200);
    this.system = system;
    this.component = component;
    this.sequence = 0;
    this.waiting = [];
    this.timers = [];
    this.sensorUsec = 1_000_000;
    this.bytes = new PassThrough();
    this.bytes.pipe(new mavlink.MavLinkPacketSplitter()).pipe(new mavlink.MavLinkPacketParser())
      .on('data', (packet) => this.onPacket(packet));
    this.every(1, () => this.read());
  }

  every(ms, action) { this.timers.push(setInterval(action, ms)); }

  read() {
    const buffer = Buffer.alloc(65536);
    try {
      const count = fs.readSync(this.fd, buffer, 0, buffer.length, null);
      if (count > 0) this.bytes.write(buffer.subarray(0, count));
    } catch (error) {
      if (error.code !== 'EAGAIN') throw error;
    }
  }

  write(bytes) {
    for (let done = 0; done < bytes.length;) {
      try {
        done += fs.writeSync(this.fd, bytes, done);
      } catch (error) {
        if (error.code !== 'EAGAIN') throw error;
        this.read(); // neither side may wait for the other
      }
    }
  }

  send(name, fields, protocol = this.protocol) {
    const type = BY_NAME[name];
    const message = new type();
    for (const field of type.FIELDS) {
      if (fields[field.source] === undefined) continue;
      message[field.name] = WIDE.test(field.type) ? BigInt(fields[field.source]) : fields[field.source];
    }
    this.write(protocol.serialize(message, this.sequence));
    this.sequence = (this.sequence + 1) % 256;
  }

  onPacket(packet) {
    const type = REGISTRY[packet.header.msgid];
    if (type === undefined) return;
    const data = packet.protocol.data(packet.payload, type);
    const fields = { system: packet.header.sysid, component: packet.header.compid };
    for (const field of type.FIELDS) fields[field.source] = data[field.name];
    this.waiting = this.waiting.filter((wait) => !wait(type.MSG_NAME, fields));
  }

  // Fields of the next message of this name that meets the condition.
  next(name, condition = () => true, patience = PATIENCE_MS) {
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`no ${name} in ${patience} ms`)), patience);
      this.waiting.push((seen, fields) => {
        if (seen !== name || !condition(fields)) return false;
        clearTimeout(timer);
        resolve(fields);
        return true;
      });
    });
  }

  // Calls `take` with each message of this name until it returns true.
  until(name, take) { return this.next(name, (fields) => take(fields) === true); }

  // Sends a command and resolves with its acknowledgement.
  command(id, params = []) {
    const ack = this.next('COMMAND_ACK', (m) => m.command === id);
    const fields = { target_system: 1, target_component: 1, command: id };
    for (let i = 0; i < 7; ++i) fields[`param${i + 1}`] = params[i] ?? 0;
    this.send('COMMAND_LONG', fields);
    return ack;
  }

  // Sensors of a vehicle that stands still at the default home, for so many milliseconds.
  standStill(ms) {
    const noise = (sigma) => sigma * (Math.random() + Math.random() + Math.random() - 1.5) * 2;
    for (let i = 0; i < ms / 2; ++i) {
      this.sensorUsec += 2000;
      this.send('HIL_SENSOR', {
        time_usec: this.sensorUsec, xacc: noise(0.04), yacc: noise(0.06), zacc: -9.80665 + noise(0.07),
        xgyro: noise(0.012), ygyro: noise(0.014), zgyro: noise(0.002), xmag: 0.2135 + noise(0.004),
        ymag: 0.0127 + noise(0.004), zmag: 0.4331 + noise(0.004), abs_pressure: 956.0 + noise(0.01),
        pressure_alt: 488, temperature: 12, fields_updated: 0x1FFF,
      }, this.simulator);
      if (this.sensorUsec % 200000 !== 0) continue;
      this.send('HIL_GPS', {
        time_usec: this.sensorUsec, fix_type: 3, lat: Math.round(473977420 + noise(27)),
        lon: Math.round(85455940 + noise(40)), alt: Math.round(488000 + noise(300)), eph: 42, epv: 30,
        vel: 0, vn: Math.round(noise(10)), ve: Math.round(noise(10)), vd: 0, cog: 65535, satellites_visible: 10,
      }, this.simulator);
    }
  }

  close() {
    this.timers.forEach(clearInterval);
    this.waiting = [];
    fs.closeSync(this.fd);
  }
}

module.exports = { VehicleLine };
