// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import {createHmac} from 'node:crypto';
import {test} from 'node:test';
import {Bench, oldTopics, originOfN, referenceAt} from '../src/bench.ts';
import {fromHome, quaternionOf, rotate, rpyOf, slerp} from '../src/frames.ts';
import {Hold} from '../src/hold.ts';
import {measured} from '../src/measure.ts';
import {age, clean, clock, delay, delayPair, fixed, grouped, minutes, tickStep} from '../src/numbers.ts';
import {page} from '../src/page.ts';
import type {VehicleState} from '../src/protocol.ts';
import {makeNonce, tokenProof} from '../src/proof.ts';
import {rowName, RunRecord, unpack} from '../src/record.ts';
import {RecordSource} from '../src/record_source.ts';
import {between, decode, indexAt, Ring, waysTo} from '../src/series.ts';
import {titlesOf} from '../src/run_pair.ts';
import {StickPace, sticksOf} from '../src/stick_pace.ts';
import {actWords, kBefore, verdictText} from '../src/verdict.ts';
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
  assert.deepEqual([...decode({k: 1, d: [4, null, 1]})], [4, NaN, 5], 'a gap adds nothing');
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

test('a proof is an HMAC over both nonces and the place, and no nonce comes twice', () => {
  const context = {place: '127.0.0.1:5791', pageNonce: 'a', serverNonce: 'b'};
  const of = (prover: string) => createHmac('sha256', 'token').update(`cas\n${prover}\n127.0.0.1:5791\na\nb\n`).digest('hex');
  assert.equal(tokenProof('token', 'client', context), of('client'));
  assert.equal(tokenProof('token', 'server', context), of('server'));
  assert.match(makeNonce(), /^[0-9a-f]{64}$/);
  assert.notEqual(makeNonce(), makeNonce());
});

test('a reference is that of the picture, and none when it is old', () => {
  const told = {t_s: 10, p_W: [1, 2, 3] as [number, number, number], v_W: [0, 2, 0] as [number, number, number], yaw_rad: 0.5};
  assert.deepEqual(referenceAt(told, 10.25)!.p_W, [1, 2.5, 3]);
  assert.equal(referenceAt(told, 11), undefined);
  const bench = new Bench();
  const sim = (t_s: number) => bench.apply('snap.sim', {t_s, v: [{p: [0, 0, 0], q: [1, 0, 0, 0], vel: [0, 0, 0], w: [0, 0, 0], rotors: []}]});
  sim(10);
  bench.apply('snap.ref', {t_s: 10, v: [{p_W: told.p_W, v_W: told.v_W, yaw_rad: 0}]});
  sim(10.1);
  near(bench.vehicle!.reference!.p_W[1], 2.2);
  sim(12);
  assert.equal(bench.vehicle!.reference, undefined);
  bench.apply('snap.ref', {t_s: 12, v: [null]});
  sim(12.1);
  assert.equal(bench.vehicle!.reference, undefined);
});

test('a run tells its limits, the verdict and who touched it', () => {
  const check = (what: string, value: number | null, kept = true) => ({
    what, validity: false, value, bound: 0.5, margin: value === null ? null : 0.5 - value, least: false, unit: 'm', digits: 4, found: '', wanted: '', judged: true, kept,
  });
  const run = {
    name: 'hover', seed: 1, state: 'running', sentences: [], touched: [{by: 'the page (unix:uid 0)', what: 'sim.pause'}],
    stages: [{name: 'hold', begin_s: 5, end_s: 9, measured: true}],
    vehicles: [
      {name: 'one', system: 1, checks: [check('RMS error of the true position, x_m', 0.1), {...check('real-time factor', 1), validity: true}]},
      {name: 'two', system: 2, checks: [check('RMS error of the true position, x_m', 0.7, false), check('HIL_SENSOR lost', null)]},
    ],
  };
  const bench = new Bench();
  bench.vehicles = [{name: 'one', system: 1}, {name: 'two', system: 2}];
  bench.apply('snap.verdict', run);
  assert.deepEqual(bench.verdict!.rows.map(({name, value, margin, missed}) => ({name, value, margin, missed})), [{name: 'north', value: 0.1, margin: 0.4, missed: false}]);
  assert.deepEqual(bench.verdict!.touched, ['sim.pause by the page (unix:uid 0)']);
  assert.deepEqual(bench.measured, [5, 9]);
  bench.selected = 1;
  assert.equal(bench.verdict!.rows[0]!.missed, true);
  assert.equal(bench.verdict!.rows[1]!.value, null);
  bench.apply('event.verdict', {...run, state: 'failed', sentences: ['two: too far']});
  assert.equal(bench.verdict!.state, 'failed');
  assert.ok(bench.happenings.some((event) => event.text === 'Verdict: failed'));
});

test('acts by hand are told in words', () => {
  kBefore.set('position p 1.2', 1.5);
  assert.equal(actWords('gain.set {"loop":"position","p":1.2,"vehicle":1} by the page (unix:uid 0)'), 'position P 1.5 → 1.2');
  assert.equal(actWords('gain.set {"loop":"position","i":0.25,"vehicle":1} by casd'), 'position I → 0.25');
  assert.equal(actWords('vehicle.goto {"down_m":-2.501032590866089,"east_m":-0.01,"north_m":3.0,"vehicle":1} by casd'), 'go to 3.0 m north, 2.5 m up');
  assert.equal(actWords('vehicle.takeoff {"altitude_m":2.5,"vehicle":1}, refused by casd'), 'takeoff altitude_m 2.5, refused');
  assert.equal(actWords('fault.inject {"drop":"gps","for_s":1.0,"name":"No GPS","vehicle":1} by casd'), 'fault No GPS, 1 s');
  assert.equal(actWords("sim.pause by hilsim's control socket (unix:uid 0)"), 'sim.pause');
  assert.equal(actWords('parameters were changed from outside'), 'parameters were changed from outside');
});

test('two points of a plot have a distance in the words of its axes', () => {
  assert.equal(measured({x: 1, y: 2}, {x: 3, y: 1}, 'simulated time, s', 'north, m'), 'Between the points: 2.0000 s, −1.0000 m; −0.5000 m a s');
  assert.equal(measured({x: 1, y: 2}, {x: 1, y: 1}, 'simulated time, s', 'error'), 'Between the points: 0.0000 s, −1.0000 ');
});

test('a tick is for what has passed, and a run that is heard no more is lost', () => {
  const check = (value: number | null, kept = true) => ({
    what: 'RMS error of the true position, x_m', validity: false, value, bound: 0.5, least: false, unit: 'm', digits: 4, found: '', wanted: '', judged: true, kept,
  });
  const run = (state: string, first: object, second: object) => ({
    name: 'hover', seed: 1, state, sentences: ['hils ended'], touched: [], stages: [],
    vehicles: [{name: 'one', system: 1, checks: [first]}, {name: 'two', system: 2, checks: [second]}],
  });
  const bench = new Bench();
  bench.connection = 'live';
  bench.programs = [{name: 'hils', state: 'up'}];
  bench.vehicles = [1, 2, 7].map((system) => ({name: `${system}`, system}));
  const said = () => verdictText(bench.verdict!);
  bench.apply('snap.verdict', run('running', check(null), check(null)));
  assert.deepEqual(said(), {text: 'Not measured yet', tone: 'grey', ticked: false});
  bench.apply('snap.verdict', run('running', check(0.1), check(null)));
  assert.deepEqual(said(), {text: '1 of 2 known, kept so far', tone: 'grey', ticked: false});
  bench.apply('snap.verdict', run('running', check(0.1), check(0.7, false)));
  assert.equal(said().text, '1 limit missed so far', 'of the other vehicle, too');
  bench.selected = 2;
  assert.deepEqual(bench.verdict!.rows, [], 'no limit of another vehicle is shown as its own');
  bench.runAge_s = 4;
  bench.old = new Map([['verdict', 4]]);
  assert.deepEqual(said(), {text: 'Run lost, 4.00 s old', tone: 'amber', ticked: false});
  bench.old = new Map();
  assert.equal(said().tone, 'red');
  bench.apply('event.program', {name: 'hils', state: 'down'});
  assert.equal(bench.verdict!.state, 'lost');
  bench.apply('event.verdict', run('passed', check(0.1), check(0.1)));
  assert.deepEqual(said(), {text: 'Passed, 2 of 2 limits', tone: '', ticked: true});
  bench.connection = 'lost';
  assert.equal(bench.verdict!.state, 'passed', 'a verdict that was told stands');
  bench.apply('event.verdict', run('invalid', check(0.1), check(0.1)));
  assert.deepEqual(said(), {text: 'No verdict: hils ended', tone: 'amber', ticked: false});
});

test('a question is about the vehicle that was looked at, and about no other', () => {
  const {bench} = page;
  bench.vehicles = [{name: 'one', system: 1}, {name: 'two', system: 2}];
  const asked: (number | undefined)[] = [];
  const ask = () => page.ask('Arm?', 'Arm', (vehicle) => asked.push(vehicle));
  bench.selected = 1;
  ask();
  bench.vehicles = [{name: 'new', system: 5}, {name: 'one', system: 1}, {name: 'two', system: 2}];
  assert.equal(bench.selected, 2, 'another one that is heard moves no selection');
  page.answer(true);
  assert.deepEqual(asked, [2]);
  ask();
  bench.selected = 0;
  page.answer(true);
  assert.deepEqual(asked, [2]);
  ask();
  page.goto = {vehicle: 5, north_m: 0, east_m: 0, up_m: 1};
  bench.selected = 1;
  page.redraw();
  assert.equal(page.question, undefined);
  assert.equal(page.goto, null);
});

test('a gamepad is a transmitter of mode 2', () => {
  assert.deepEqual(sticksOf([0, 0, 0, 0]), {yaw: 0, throttle: 0.5, roll: 0, pitch: 0});
  assert.deepEqual(sticksOf([1, -1, -0.5, -0.5]), {yaw: 1, throttle: 1, roll: -0.5, pitch: 0.5});
  assert.equal(sticksOf([0.03, 0, 0, 0]).yaw, 0, 'a stick that does not centre');
});

test('sticks go 20 times a second, and are let go after half a second without an answer', () => {
  const pace = new StickPace();
  assert.equal(pace.tick(0), false);
  pace.start(1);
  let sent = 0;
  for (let i = 0; i < 60; ++i) {
    if (!pace.tick(1 + i / 60)) continue;
    ++sent;
    pace.answered();
  }
  assert.ok(sent >= 19 && sent <= 21, String(sent));
  assert.equal(pace.tick(2.05), true);
  assert.equal(pace.tick(2.3), true);
  assert.equal(pace.on, true);
  assert.equal(pace.tick(2.6), false);
  assert.equal(pace.on, false, 'nobody answers');
});

test('answers that come late are noticed, and few sticks are under way', () => {
  const pace = new StickPace();
  pace.start(0);
  let sent = 0;
  for (let i = 0; i < 24; ++i) sent += Number(pace.tick(i / 50));
  assert.equal(sent, 5, 'no answer: no more than five');
  const late = new StickPace();
  late.start(0);
  let i = 0;
  for (; i < 200 && late.on; ++i) {
    if (i % 30 === 29) late.answered();  // one in 0.6 s
    late.tick(i / 50);
  }
  assert.ok(!late.on && i < 40, 'an answer to an older one does not hide a younger that waits');
});

test('a record in which somebody acted says so', () => {
  const raw = makeRecord();
  assert.deepEqual(new RunRecord(raw).verdict(0)!.touched, []);
  raw.vehicles[0]!.touched = true;
  raw.vehicles[0]!.events!.push({t_s: 9, kind: 'act', text: 'sim.pause', by: "hilsim's control socket (unix:uid 0)"});
  assert.deepEqual(new RunRecord(raw).verdict(0)!.touched, ["sim.pause by hilsim's control socket (unix:uid 0)"]);
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

test('the end of a record has the figures of its last whole second', () => {
  const raw = makeRecord();
  const link = raw.vehicles[0]!.link!;
  for (const hop of link.hops) for (const {bins} of hop.messages) bins.at(-1)!.splice(1, 2, 100, 90);  // cut by the end
  link.loop.at(-1)!.splice(1, 4, 0, 0, 0, 0);
  const record = new RunRecord(raw);
  for (const t of [kDuration_s - 0.5, kDuration_s]) {
    const {hops} = record.hopsAt(0, t);
    assert.equal(hops.find(({to}) => to === 'fcu')!.msgs.HIL_SENSOR, 500);
    assert.equal(hops.find(({from}) => from === 'fcu')!.msgs.HIL_CONTROLS, 400);
    assert.equal(record.loopAt(0, t)!.ms.p50, 1.59);
    assert.equal(record.messagesAt(0, t).find(({name}) => name === 'HIL_SENSOR')!.hz, 500);
  }
});

test('on its way to a reference that jumped a vehicle is in no error', () => {
  const t = Array.from({length: 100}, (_, i) => i / 10);
  const north = {t, v: t.map((s) => (s < 2 ? 0 : 3))};
  const flown = t.map((s) => Math.min(3, Math.max(0, s - 2)));
  const error = {t, v: t.map((_, i) => Math.abs(north.v[i]! - flown[i]!))};
  const ways = waysTo([north, {t, v: t.map(() => 0)}], error, 0.5);
  assert.equal(ways.length, 1);
  near(ways[0]![0], 1.9);
  near(ways[0]![1], 4.5, 0.11);
  const circle = {t, v: t.map((s) => 2 * Math.sin(s))};
  assert.deepEqual(waysTo([circle], {t, v: t.map(() => 1)}, 0.5), [], 'one that moves on is followed');
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

test('two runs of one name are told apart by where they are from and what they flew with', () => {
  const source = (path: string, mean: string) => ({path, settings: {'hilsim.vehicles[iris0].plugins[wind].mean_m_s': mean, 'hilsim.seed': '1', 'hilsim.world': `/${path}/bench.yaml`}});
  assert.deepEqual(titlesOf([{name: 'wind', source: source('out/calm', '3')}, {name: 'wind', source: source('out/gusty/', '9')}]),
    [{name: 'calm', differs: 'wind mean_m_s 3'}, {name: 'gusty', differs: 'wind mean_m_s 9'}]);
  assert.deepEqual(titlesOf([{name: 'wind', source: source('a/out', '3')}, {name: 'wind', source: source('b/out', '3')}]).map(({name}) => name), ['a/out', 'b/out']);
  assert.deepEqual(titlesOf([{name: 'hover'}, {name: 'wind'}]), [{name: 'hover', differs: ''}, {name: 'wind', differs: ''}]);
});

test('a record of another format is refused in a sentence', () => {
  assert.throws(() => new RunRecord({...makeRecord(), format: 2}), /format 2; the page reads 1/);
});

const kHome = {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488};

/** A vehicle whose N begins 3 m north, 2 m east and 0.5 m up in W, at 5 m north of there. */
function stateOf(system = 1): VehicleState {
  const degree_m = (Math.PI / 180) * 6_371_000;
  const place = (n: number, e: number, u: number) => ({
    lat_deg: kHome.lat_deg + n / degree_m, lon_deg: kHome.lon_deg + e / degree_m / Math.cos((kHome.lat_deg * Math.PI) / 180), alt_m: kHome.alt_m + u,
  });
  return {
    system, autopilot: 'PX4', hil: true, armed: true, heartbeat_age_s: 0.2,
    attitude: {roll_rad: 0, pitch_rad: 0, yaw_rad: 0, age_s: 0},
    position_N: {x_m: 5, y_m: 0, z_m: -2.5, vx_m_s: 1, vy_m_s: 0, vz_m_s: 0, age_s: 0.1},
    global: {...place(7.9, 2, 3), age_s: 0.2},
    home: {...place(4, 2, 0.5), x_m: 1, y_m: 0, z_m: 0},
  };
}

function liveBench(...states: VehicleState[]): Bench {
  const bench = new Bench();
  bench.connection = 'live';
  bench.programs = [{name: 'hilsim', state: 'up'}, {name: 'casd', state: 'up'}];
  bench.setScene({hash: 'a', home: kHome, vehicles: [{name: 'iris0', system: 1, rotors: []}, {name: 'iris1', system: 2, rotors: []}]});
  bench.apply('snap.vehicle', {vehicles: states.map((state) => ({state}))});
  return bench;
}

const kSim = {p: [0, 0, 0], q: [1, 0, 0, 0], vel: [0, 0, 0], w: [0, 0, 0], rotors: []};

test('places on Earth are east, north and up of home, over the date line, too', () => {
  const [e, n, u] = fromHome({lat_deg: 0, lon_deg: 179.9999, alt_m: 1}, {lat_deg: 0.0001, lon_deg: -179.9999, alt_m: 3});
  near(e, 22.239, 0.001);
  near(n, 11.1195, 0.001);
  near(u, 2);
});

test('the origin of N comes from home, or from where the vehicle is', () => {
  for (const state of [stateOf(), {...stateOf(), home: undefined}, {...stateOf(), autopilot: 'ArduPilot'}]) {
    originOfN(state, kHome)!.forEach((value, i) => near(value, [2, 3, 0.5][i]!, 0.001));
  }
  const old = {...stateOf(), home: undefined};
  old.global!.age_s = 5;
  assert.equal(originOfN(old, kHome), undefined);
});

test('a place of W is commanded in N, the estimate drawn in W, and neither guessed', () => {
  const bench = liveBench(stateOf());
  const to = bench.inN([2, 4, 3])!;
  near(to.north_m, 1, 0.001);
  near(to.east_m, 0, 0.001);
  near(to.down_m, -2.5, 0.001);
  bench.estimate()!.p.forEach((value, i) => near(value, [2, 8, 3][i]!, 0.001));
  const unknown = liveBench({...stateOf(), home: undefined, global: undefined});
  assert.equal(unknown.inN([0, 0, 2]), undefined);
  assert.equal(unknown.estimate(), undefined);
});

test('a silent casd or vehicle is not commanded', () => {
  const bench = liveBench(stateOf());
  assert.equal(bench.interlock, '');
  bench.growOld(2.9);
  assert.match(bench.interlock, /^Vehicle 1 is silent/);
  near(bench.vehicle!.state!.position_N!.age_s, 3, 1e-9);
  const down = liveBench(stateOf());
  down.apply('event.program', {name: 'casd', state: 'down', reason: 'gone'});
  assert.match(down.interlock, /^casd is down/);
});

test('a topic is old after three periods, 2 s at least', () => {
  const heard = new Map([['sim', 10], ['loop', 10], ['links', 10]]);
  assert.deepEqual([...oldTopics(heard, {sim: 60, loop: 1, links: 2}, 11.9).keys()], []);
  assert.deepEqual([...oldTopics(heard, {sim: 60, loop: 1, links: 2}, 12.5).keys()], ['sim', 'links']);
  near(oldTopics(heard, {loop: 1}, 14).get('loop')!, 4);
});

test('nothing of an earlier run stays', () => {
  const bench = liveBench(stateOf(1), stateOf(2), stateOf(7));
  bench.apply('snap.sim', {t_s: 1, v: [kSim, kSim]});
  bench.selected = 2;
  assert.deepEqual(bench.vehicles.map((each) => each.system), [1, 2, 7]);
  bench.apply('snap.vehicle', {vehicles: [{state: stateOf(1)}]});
  assert.deepEqual(bench.vehicles.map((each) => [each.system, Boolean(each.state)]), [[1, true], [2, false]]);
  assert.equal(bench.selected, 0);
  bench.setScene({hash: 'b', home: kHome, vehicles: [{name: 'other', system: 1, rotors: []}]});
  assert.deepEqual(bench.vehicles.map((each) => each.name), ['other']);
  assert.equal(bench.truth(), undefined);
  bench.apply('snap.sim', {t_s: 1, v: [kSim]});
  assert.ok(bench.truth());
  bench.apply('event.program', {name: 'hilsim', state: 'down'});
  assert.equal(bench.truth(), undefined);
});

test('each vehicle has its own loop and hops', () => {
  const bench = liveBench(stateOf(1), stateOf(2));
  const hop = (from: string, to: string, link: string, system: number) => ({from, to, link, system, msgs: {}});
  bench.apply('snap.links', {
    hops: [hop('sim', 'casd', 'sim1', 1), hop('casd', 'fcu', 'fcu1', 1), hop('sim', 'casd', 'sim2', 2), hop('casd', 'fcu', 'fcu2', 2), hop('casd', 'fcu', 'spare', 0)],
    forward_us: [{from: 'sim', to: 'fcu', system: 1, p50: 20, p99: 30}, {from: 'sim', to: 'fcu', system: 2, p50: 40, p99: 60}],
  });
  bench.apply('snap.loop', {vehicles: [{system: 1, ms: {p50: 1, p99: 2}, count: 1}]});
  assert.equal(bench.loop!.ms.p50, 1);
  bench.selected = 1;
  assert.equal(bench.loop, undefined, 'not that of another vehicle');
  assert.deepEqual(bench.hops.map(({link}) => link), ['sim2', 'fcu2', 'spare']);
  assert.equal(bench.forward('sim')!.p50, 40);
});

test('a limit is told where the run has one', () => {
  assert.equal(new Bench().bounds.loop_p99_ms, undefined);
  const bench = new Bench();
  new RecordSource(new RunRecord(makeRecord())).start(bench);
  assert.equal(bench.bounds.loop_p99_ms, 6);
});

test('the autopilot is that of the HEARTBEATs', () => {
  const record = makeRecord();
  assert.equal(new RunRecord(record).vehicles[0]!.autopilot, 'PX4');
  record.vehicles[0]!.log!.messages[0]!.fields = [];
  assert.equal(new RunRecord(record).vehicles[0]!.stateAt(14).autopilot, undefined);
});

test('a press counts while frames are drawn, and ends with the button', () => {
  const hold = new Hold(1);
  hold.down(5);
  assert.equal(hold.tick(65), false, 'a page that stood still held nothing');
  let fired = 0;
  for (let i = 1; i <= 20; ++i) fired += Number(hold.tick(65 + i * 0.1));
  assert.equal(fired, 1);
  hold.down(70);
  hold.tick(70.1);
  hold.up();
  for (let i = 1; i <= 20; ++i) assert.equal(hold.tick(70 + i * 0.1), false);
});

test('an axis of years has no more ticks than pixels', () => {
  assert.equal(tickStep(60, 800), 5);
  assert.ok(4e9 / tickStep(4e9, 800) < 20);
});
