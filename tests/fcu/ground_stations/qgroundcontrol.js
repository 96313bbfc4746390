// SPDX-License-Identifier: BSD-3-Clause
// QGroundControl's messages to a vehicle that it meets, up to "ready to fly" and a mission.
// usage: node qgroundcontrol.js <terminal of fcu_emulator>
'use strict';

const assert = require('assert');
const { VehicleLine } = require('./vehicle_line');

const ACCEPTED = 0, UNSUPPORTED = 3;
const REQUEST_MESSAGE = 512;
const AUTO_LOITER = (4 << 16) | (3 << 24);

async function requested(line, id, name) {
  const message = line.next(name);
  const ack = await line.command(REQUEST_MESSAGE, [id]);
  assert.strictEqual(ack.result, ACCEPTED, `REQUEST_MESSAGE ${name}`);
  return message;
}

async function meet(line) {
  const beat = await line.next('HEARTBEAT');
  assert.strictEqual(beat.autopilot, 12, 'a PX4 vehicle');
  assert.strictEqual(beat.type, 2, 'a quadrotor');
  assert.ok(beat.base_mode & 1, 'custom modes');
  assert.ok(beat.base_mode & 32, 'in HIL');
  assert.strictEqual(beat.custom_mode >>> 0, AUTO_LOITER >>> 0, 'in hold');
}

async function identify(line) {
  const version = await requested(line, 148, 'AUTOPILOT_VERSION');
  const capabilities = BigInt(version.capabilities);
  for (const bit of [4n, 8n, 8192n]) assert.ok(capabilities & bit, `capability ${bit}`);
  const again = line.next('AUTOPILOT_VERSION');
  assert.strictEqual((await line.command(520, [1])).result, ACCEPTED, 'older releases ask so');
  await again;
  // PROTOCOL_VERSION: node-mavlink does not know the message itself.
  assert.strictEqual((await line.command(REQUEST_MESSAGE, [300])).result, ACCEPTED);
  const modes = [];
  const all = line.until('AVAILABLE_MODES', (m) => {
    modes.push(m);
    return modes.length === m.number_modes;
  });
  assert.strictEqual((await line.command(REQUEST_MESSAGE, [435, 0])).result, ACCEPTED);
  await all;
  assert.deepStrictEqual(modes.map((m) => m.mode_index), modes.map((_, i) => i + 1));
  // Component metadata, component information, camera, gimbal: none here.
  for (const id of [397, 395, 259, 280]) {
    assert.strictEqual((await line.command(REQUEST_MESSAGE, [id])).result, UNSUPPORTED, `message ${id}`);
  }
}

async function loadParameters(line) {
  const parameters = new Map();
  let total = 0, hash = false;
  const whole = line.until('PARAM_VALUE', (m) => {
    if (m.param_index === 65535) {
      assert.strictEqual(m.param_id, '_HASH_CHECK');
      hash = true;
      return false;
    }
    total = m.param_count;
    // Every tenth is taken for lost.
    if (m.param_index % 10 !== 3) parameters.set(m.param_index, m);
    return m.param_index === total - 1;
  });
  line.send('PARAM_REQUEST_LIST', { target_system: 1, target_component: 1 });
  await whole;
  assert.ok(hash, 'the hash comes first');
  for (let index = 0; index < total; ++index) {
    if (parameters.has(index)) continue;
    const value = line.next('PARAM_VALUE', (m) => m.param_index === index);
    line.send('PARAM_REQUEST_READ',
              { target_system: 1, target_component: 1, param_index: index, param_id: '' });
    parameters.set(index, await value);
  }
  assert.strictEqual(parameters.size, total);
  const names = new Set([...parameters.values()].map((m) => m.param_id));
  assert.strictEqual(names.size, total, 'each name once');
  for (const name of ['SYS_AUTOSTART', 'CAL_GYRO0_ID', 'MC_ROLL_P', 'MIS_TAKEOFF_ALT']) assert.ok(names.has(name), name);
  return total;
}

async function loadPlans(line) {
  for (const type of [0, 1, 2]) { // mission, fence, rally points
    const count = line.next('MISSION_COUNT', (m) => m.mission_type === type);
    line.send('MISSION_REQUEST_LIST', { target_system: 1, target_component: 1, mission_type: type });
    assert.strictEqual((await count).count, 0);
    line.send('MISSION_ACK', { target_system: 1, target_component: 1, type: 0, mission_type: type });
  }
}

async function becomeReady(line) {
  const PREARM = 1 << 28;
  const ready = line.next('SYS_STATUS', (m) => (m.onboard_control_sensors_health & PREARM) !== 0);
  line.standStill(15000); // of simulated time
  line.every(10, () => line.standStill(10));
  const status = await ready;
  assert.ok(status.onboard_control_sensors_present & PREARM);
  assert.ok(status.onboard_control_sensors_enabled & PREARM);
  assert.ok((await line.next('GPS_RAW_INT')).fix_type >= 3);
  assert.strictEqual((await line.next('EXTENDED_SYS_STATE')).landed_state, 1, 'on the ground');
  const home = line.next('HOME_POSITION');
  assert.strictEqual((await line.command(410)).result, ACCEPTED, 'GET_HOME_POSITION');
  assert.ok(Math.abs((await home).latitude - 473977420) < 100);
  await requested(line, 242, 'HOME_POSITION');
}

async function uploadMission(line) {
  const items = [[22, 0], [16, 300], [21, 300]]; // takeoff, waypoint, land; 1e-7 degree north
  const accepted = line.next('MISSION_ACK');
  const answers = line.until('MISSION_REQUEST_INT', (m) => {
    const [command, north] = items[m.seq];
    line.send('MISSION_ITEM_INT', {
      target_system: 1, target_component: 1, seq: m.seq, frame: 6, command, current: m.seq === 0 ? 1 : 0,
      autocontinue: 1, x: 473977420 + north, y: 85455940, z: command === 21 ? 0 : 5, mission_type: 0,
    });
    return m.seq === items.length - 1;
  });
  line.send('MISSION_COUNT', { target_system: 1, target_component: 1, count: items.length, mission_type: 0 });
  await answers;
  assert.strictEqual((await accepted).type, 0);
}

async function main() {
  const line = new VehicleLine(process.argv[2], 255, 190);
  const beat = () => line.send('HEARTBEAT', { type: 6, autopilot: 8, base_mode: 192, custom_mode: 0, system_status: 4 });
  beat();
  line.every(1000, beat);
  await meet(line);
  await identify(line);
  const parameters = await loadParameters(line);
  await loadPlans(line);
  await becomeReady(line);
  await uploadMission(line);
  assert.strictEqual((await line.command(400, [1])).result, ACCEPTED, 'arming');
  await line.next('HEARTBEAT', (m) => (m.base_mode & 128) !== 0);
  assert.strictEqual((await line.command(400, [0])).result, ACCEPTED, 'disarming');
  line.close();
  console.log(`QGroundControl: ${parameters} parameters, plans, home, ready, mission, armed`);
}

main().catch((error) => {
  console.error(error.stack);
  process.exit(1);
});
