// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {Bench} from '../src/bench.ts';
import {quaternionOf, rotate, rpyOf, slerp} from '../src/frames.ts';
import {age, clean, clock, delay, delayPair, fixed, grouped, minutes} from '../src/numbers.ts';
import {rowName, RunRecord, unpack} from '../src/record.ts';
import {RecordSource} from '../src/record_source.ts';
import {between, decode, indexAt, Ring} from '../src/series.ts';
import {kDuration_s, kLossSecond, makeRecord, pack, placeAt} from './fixture.ts';

const near = (a: number, b: number, within = 1e-6) => assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

test('numbers have a real minus sign, fixed decimals and a dash for nothing', () => {
  assert.equal(fixed(-1.234), '−1.23');
  assert.equal(fixed(-0.001), '0.00');
  assert.equal(fixed(undefined), '–');
  assert.equal(fixed(NaN), '–');
  assert.equal(grouped(921600), '921 600');
});

test('delays change their unit at 1 ms and end where clocks end', () => {
  assert.equal(delay(33.4), '33 µs');
  assert.equal(delay(2245), '2.25 ms');
  assert.equal(delay(-4), 'under 10 µs');
  assert.equal(delay(undefined), '–');
  assert.equal(delayPair({p50: 33, p99: 198}), '33 µs · 99 % 198 µs');
  assert.equal(delayPair({p50: -4, p99: -1}), 'under 10 µs');
});

test('the clock never rounds up', () => {
  assert.equal(clock(59.999), 'T+ 00:59.99');
  assert.equal(clock(61.5), 'T+ 01:01.50');
  assert.equal(clock(null), 'T+ ––:––.––');
  assert.equal(minutes(59.96, 1), '00:59.9');
  assert.equal(age(0.421), '0.42 s old');
});

test('control characters from the wire are shown, not obeyed', () => {
  assert.equal(clean('a\u0007b\u202ec'), 'a�b�c');
});

test('a heading of north is a quarter turn in W, and back', () => {
  const forward = rotate(quaternionOf({roll: 0, pitch: 0, yaw: 0}), [1, 0, 0]);
  near(forward[0], 0);
  near(forward[1], 1);
  const up = rotate(quaternionOf({roll: 0, pitch: 0.3, yaw: 1}), [1, 0, 0]);
  assert.ok(up[2] > 0.29, 'nose up is up');
  const right = rotate(quaternionOf({roll: 0.3, pitch: 0, yaw: 0}), [0, -1, 0]);
  assert.ok(right[2] < -0.29, 'positive roll turns the right side down');
  const rpy = rpyOf(quaternionOf({roll: 0.2, pitch: -0.4, yaw: 2.5}));
  near(rpy.roll, 0.2);
  near(rpy.pitch, -0.4);
  near(rpy.yaw, 2.5);
  const half = slerp(quaternionOf({roll: 0, pitch: 0, yaw: 0}), quaternionOf({roll: 0, pitch: 0, yaw: 1}), 0.5);
  near(rpyOf(half).yaw, 0.5);
});

test('columns are sums of differences', () => {
  assert.deepEqual([...decode({k: 0.5, d: [4, -1, 0, 2]})], [2, 1.5, 1.5, 2.5]);
  assert.equal(indexAt([0, 1, 2], 1.5), 1);
  assert.equal(indexAt([0, 1, 2], -1), -1);
  near(between([0, 1], [0, 10], 0.25)!, 2.5);
  assert.equal(between([0, 5], [0, 10], 3), undefined, 'nothing across a gap');
});

test('a ring keeps 20 Hz and begins anew when time goes back', () => {
  const ring = new Ring();
  for (let i = 0; i < 1000; ++i) ring.push(i / 1000, i);
  assert.ok(ring.t.length > 15 && ring.t.length < 25);
  ring.push(0.1, 1);
  assert.deepEqual(ring.t, [0.1]);
});

test('a record answers with the motion, the reference and the estimate of a moment', () => {
  const record = new RunRecord(makeRecord());
  const vehicle = record.vehicles[0]!;
  const t = 14.3;
  const [n, e, u] = placeAt(t);
  const sim = vehicle.simAt(t)!;
  near(sim.p[0], e, 0.01);
  near(sim.p[1], n, 0.01);
  near(sim.p[2], u, 0.01);
  assert.deepEqual(sim.rotors.map(Math.round), [800, 805, 795, 810]);
  near(vehicle.referenceAt(t)!.p_W[0], e + 0.1, 0.1);
  assert.equal(vehicle.referenceAt(38), undefined);
  const state = vehicle.stateAt(t);
  assert.equal(state.mode, 'HOLD');
  assert.equal(state.armed, true);
  assert.equal(state.landed, 'in_air');
  near(state.position_N!.x_m, n + 0.05, 0.05);
  near(vehicle.series('error.m')!.v[Math.round(t * 50)]!, 0.1, 0.08);
});

test('an estimate that comes no more is told as old as it is', () => {
  const raw = makeRecord();
  for (const message of raw.vehicles[0]!.log!.messages) {
    const cut = Math.floor(message.t.d.length / 2);
    message.t.d.length = cut;
    for (const field of message.fields) field.values.d.length = cut;
  }
  const state = new RunRecord(raw).vehicles[0]!.stateAt(25);
  near(state.position_N!.age_s, 5.1, 0.2);
});

test('hops show the rates and delays of their second, and losses so far', () => {
  const record = new RunRecord(makeRecord());
  const line = (t: number) => record.hopsAt(0, t).hops.find((hop) => hop.to === 'fcu')!;
  assert.equal(line(10).msgs.HIL_SENSOR, 500);
  assert.deepEqual(line(10).us, {p50: 860, p99: 2150});
  assert.equal(line(10).lost, 0);
  assert.equal(line(kLossSecond + 1).lost, 7);
  assert.equal(line(10).baud, 921600);
  assert.equal(line(10).full, undefined, 'what was not measured is not shown');
  assert.equal(record.hopsAt(0, 10).hops.find((hop) => hop.from === 'fcu')!.msgs.other, 21);
  assert.equal(record.tapeAt(0, 13)!.t_s, 12);
  assert.equal(record.tapeAt(0, kLossSecond + 1)!.around, 'loss');
});

test('what happened is in the order of time, with losses and arming', () => {
  const list = new RunRecord(makeRecord()).happenings(0);
  const times = list.map((event) => event.t_s);
  assert.deepEqual(times, [...times].sort((a, b) => a - b));
  assert.ok(list.some((event) => event.kind === 'loss' && event.text.startsWith('7 HIL_SENSOR lost between casd and controller')));
  assert.ok(list.some((event) => event.text === 'Armed'));
});

test('limits have short names', () => {
  assert.equal(rowName('RMS error of the true position, x_m'), 'north');
  assert.equal(rowName('RMS error of the estimate, yaw_rad'), 'est. yaw');
  assert.equal(rowName('HIL_SENSOR lost'), 'SENSOR lost');
  assert.equal(rowName('rate of HIL_GPS, error either way'), 'GPS rate off');
});

test('a record plays through the messages of the protocol', async () => {
  const bench = new Bench();
  const source = new RecordSource(await unpack(pack(makeRecord())));
  source.start(bench);
  assert.equal(bench.time_s, 8, 'it opens at the measured stage');
  assert.equal(bench.verdict!.state, 'failed');
  source.tick(0);
  source.play(true);
  for (let i = 1; i <= 20; ++i) source.tick(i / 10);
  near(bench.time_s!, 10, 1e-6);
  source.speed = 10;
  source.tick(2.1);
  near(bench.time_s!, 11, 1e-6);
  source.seek(1e9);
  assert.equal(bench.time_s, kDuration_s);
  source.seek(kLossSecond + 1);
  assert.equal(bench.tape!.around, 'loss');
  await assert.rejects(source.call('vehicle.arm'), /cannot be commanded/);
});

test('two records lie on the clock of the first by their measured stages', () => {
  const later = makeRecord('later', 3);
  for (const stage of later.vehicles[0]!.stages!) {
    stage.begin_s += 2;
    stage.end_s += 2;
  }
  const source = new RecordSource(new RunRecord(makeRecord()), new RunRecord(later));
  const bench = new Bench();
  source.start(bench);
  near(source.beside(0, 'truth.n')!.t[100]!, 0, 1e-9);
  assert.ok(bench.beside[0]);
});

test('a record of another format is refused in a sentence', () => {
  assert.throws(() => new RunRecord({...makeRecord(), format: 2}), /format 2; the page reads 1/);
});
