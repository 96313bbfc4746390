// SPDX-License-Identifier: BSD-3-Clause
// MAVSDK's messages to a vehicle: discovery, health, take-off height, offboard.
// usage: node mavsdk.js <terminal of fcu_emulator>
'use strict';

const assert = require('assert');
const { VehicleLine } = require('./vehicle_line');

const ACCEPTED = 0;
const OFFBOARD = 6 << 16;

async function discover(line) {
  await line.next('HEARTBEAT', (m) => m.autopilot === 12);
  const version = line.next('AUTOPILOT_VERSION');
  assert.strictEqual((await line.command(512, [148])).result, ACCEPTED);
  assert.notStrictEqual(BigInt((await version).uid), 0n, 'a vehicle with a name of its own');
}

const view = new DataView(new ArrayBuffer(4));
function integerOf(float) {
  view.setFloat32(0, float, true);
  return view.getInt32(0, true);
}

async function parameter(line, name) {
  const value = line.next('PARAM_VALUE', (m) => m.param_id === name);
  line.send('PARAM_REQUEST_READ', { target_system: 1, target_component: 1, param_index: -1, param_id: name });
  return value;
}

// health_all_ok
async function health(line) {
  for (const name of ['CAL_GYRO0_ID', 'CAL_ACC0_ID', 'CAL_MAG0_ID']) {
    const value = await parameter(line, name);
    assert.strictEqual(value.param_type, 6, 'an INT32, bytewise');
    assert.notStrictEqual(integerOf(value.param_value), 0, name);
  }
  const PREARM = 1 << 28;
  const armable = line.next('SYS_STATUS', (m) => (m.onboard_control_sensors_health & PREARM) !== 0);
  line.standStill(15000); // of simulated time
  line.every(10, () => line.standStill(10));
  const health_bits = (await armable).onboard_control_sensors_health;
  for (const bit of [0, 1, 2, 5]) assert.ok(health_bits & (1 << bit), `sensor ${bit}`); // gyro, accelerometer, compass, GPS
  await line.next('LOCAL_POSITION_NED');
  await line.next('GLOBAL_POSITION_INT');
  await line.next('HOME_POSITION');
  assert.strictEqual((await line.next('EXTENDED_SYS_STATE')).landed_state, 1);
}

async function setTakeoffHeight(line) {
  const answer = line.next('PARAM_VALUE', (m) => m.param_id === 'MIS_TAKEOFF_ALT');
  line.send('PARAM_SET', {
    target_system: 1, target_component: 1, param_id: 'MIS_TAKEOFF_ALT', param_value: 3.5, param_type: 9,
  });
  assert.strictEqual((await answer).param_value, 3.5);
}

async function flyOffboard(line) {
  assert.strictEqual((await line.command(176, [1, 6, 0])).result, 1, 'no offboard without setpoints');
  let talking = true;
  const IGNORE_ALL_BUT_POSITION_AND_YAW = 0b100111111000;
  line.every(50, () => {
    if (!talking) return;
    line.send('SET_POSITION_TARGET_LOCAL_NED', {
      target_system: 1, target_component: 1, coordinate_frame: 1, type_mask: IGNORE_ALL_BUT_POSITION_AND_YAW,
      x: 0, y: 0, z: 0, yaw: 0,
    });
  });
  await new Promise((resolve) => setTimeout(resolve, 200));
  assert.strictEqual((await line.command(176, [1, 6, 0])).result, ACCEPTED, 'offboard');
  await line.next('HEARTBEAT', (m) => m.custom_mode === OFFBOARD);
  assert.strictEqual((await line.command(400, [1])).result, ACCEPTED, 'arming');
  talking = false; // the companion falls silent
  await line.next('STATUSTEXT', (m) => m.text.startsWith('Offboard setpoints lost'));
  await line.next('HEARTBEAT', (m) => m.custom_mode !== OFFBOARD);
}

async function main() {
  const line = new VehicleLine(process.argv[2], 245, 190);
  const beat = () => line.send('HEARTBEAT', { type: 6, autopilot: 8, base_mode: 0, custom_mode: 0, system_status: 4 });
  beat();
  line.every(1000, beat);
  await discover(line);
  await health(line);
  await setTakeoffHeight(line);
  await flyOffboard(line);
  line.close();
  console.log('MAVSDK: discovered, healthy, offboard and its loss');
}

main().catch((error) => {
  console.error(error.stack);
  process.exit(1);
});
