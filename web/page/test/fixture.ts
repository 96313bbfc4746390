// SPDX-License-Identifier: BSD-3-Clause
// A record as hils writes it, of a flight that is a formula: a circle of 2 m at 2.5 m, a second each 12.
import {gzipSync} from 'node:zlib';
import type {RecordFile} from '../src/record.ts';
import type {Column} from '../src/series.ts';

export const kDuration_s = 40;
/** The second in which 7 HIL_SENSOR are lost on the line. */
export const kLossSecond = 24;

export function column(values: number[], k: number): Column {
  let before = 0;
  return {k, d: values.map((value) => {
    const next = Math.round(value / k);
    const d = next - before;
    before = next;
    return d;
  })};
}

const times = (hz: number): number[] => Array.from({length: Math.floor(kDuration_s * hz) + 1}, (_, i) => i / hz);

/** Place at a moment: north, east, up. */
export function placeAt(t: number, radius = 2): [number, number, number] {
  const height = Math.min(2.5, t * 0.5, (kDuration_s - t) * 0.5);
  const flying = height >= 2.5 ? 1 : 0;
  const a = (2 * Math.PI * (t - 5)) / 12;
  return [flying * radius * Math.sin(a), flying * radius * (1 - Math.cos(a)), height];
}

function bins(hz: number, p50: number, lossAt?: number): [number, number, number, number, number][] {
  return Array.from({length: kDuration_s}, (_, s) => [s, hz, s === lossAt ? hz - 7 : hz, p50, p50 * 2.5]);
}

export function makeRecord(name = 'circle', radius = 2): RecordFile {
  const t = times(50);
  const at = t.map((each) => placeAt(each, radius));
  const t20 = times(20);
  const ref = t20.filter((each) => each > 5 && each < 35);
  const local = times(10);
  const zero = t.map(() => 0);
  const sensor = {id: 107, name: 'HIL_SENSOR'};
  const gps = {id: 113, name: 'HIL_GPS'};
  const controls = {id: 91, name: 'HIL_CONTROLS'};
  const tape = (t_s: number, around: 'now' | 'loss') => ({
    t_s, ms: 20, around, hops: {
      'sim>casd': Array.from({length: 10}, (_, i): [number, number, number] => [107, i * 2000, 35]),
      'casd>fcu': Array.from({length: 10}, (_, i): [number, number, number] => [around === 'loss' && i === 4 ? -107 : 107, i * 2000 + 60, 860]),
      'fcu>casd': Array.from({length: 8}, (_, i): [number, number, number] => [91, i * 2500 + 950, 620]),
      'casd>sim': Array.from({length: 8}, (_, i): [number, number, number] => [91, i * 2500 + 1600, 5]),
    },
  });
  const field = (key: string, values: number[], unit?: string) => ({name: key, unit, values: column(values, 0.0001)});
  return {
    format: 1, name, seed: 1, architecture: 'tcas', virtual: false, duration_s: kDuration_s, rate: 1,
    nominal_hz: {HIL_SENSOR: 500, HIL_GPS: 5, HIL_CONTROLS: 400}, line: {type: 'serial', baud: 921600}, controller: 'fcu_emulator',
    verdict: {valid: true, passed: false, failures: ['7 of 20000 HIL_SENSOR were lost; the limit is 0']},
    vehicles: [{
      name: 'iris0', system: 1,
      scene: {
        name: 'iris_paper', mass_kg: 1.55, parts: [],
        rotors: [[0.194, -0.194, 1], [-0.194, -0.194, -1], [-0.194, 0.194, 1], [0.194, 0.194, -1]].map(([x, y, spin]) => ({
          p_B: [x!, y!, 0.023], axis_B: [0, 0, 1], radius_m: 0.128, spin: spin!, k_f: 5.84e-6, omega_max_rad_s: 1100,
        })),
      },
      checks: [
        {what: 'RMS error of the true position, x_m', validity: false, value: 0.09, bound: 0.5, least: false, unit: 'm', digits: 4, found: '', wanted: '', judged: true, kept: true},
        {what: 'RMS error of the true position, yaw_rad', validity: false, value: 0.004, bound: 0.1, least: false, unit: 'rad', digits: 4, found: '', wanted: '', judged: true, kept: true},
        {what: 'HIL_SENSOR lost', validity: false, value: 7, bound: 0, least: false, unit: '', digits: 0, found: '', wanted: '', judged: true, kept: false},
        {what: 'HIL_GPS lost', validity: false, value: 0, bound: 0, least: false, unit: '', digits: 0, found: '', wanted: '', judged: true, kept: true},
        {what: 'delay of the loop, 99 %', validity: false, value: 4600, bound: 6000, least: false, unit: 'us', digits: 0, found: '', wanted: '', judged: true, kept: true},
        {what: 'real-time factor', validity: true, value: 1, bound: 0.99, least: true, unit: '', digits: 4, found: '', wanted: '', judged: true, kept: true},
      ],
      stages: [
        {name: 'arm', begin_s: 0, end_s: 2, measured: false}, {name: 'takeoff', begin_s: 2, end_s: 8, measured: false},
        {name: 'circle', begin_s: 8, end_s: 32, measured: true}, {name: 'land', begin_s: 32, end_s: 40, measured: false},
      ],
      faults: [{name: 'gust', begin_s: 18, end_s: 20}],
      events: [{t_s: 12, kind: 'parameter', text: 'MPC_XY_P', by: 'scenario', before: 0.6, after: 0.9}],
      responses: [{name: 'north', size_m: 3, rise_s: 1.2, overshoot_pct: 4, settling_s: 3, integrated_error_m_s: 2}],
      truth: {
        t: column(t, 0.001), x: column(at.map((p) => p[0]), 0.001), y: column(at.map((p) => p[1]), 0.001), z: column(at.map((p) => p[2]), 0.001),
        vx: column(zero, 0.002), vy: column(zero, 0.002), vz: column(zero, 0.002), roll: column(t.map((s) => 0.1 * Math.sin(s)), 0.0005),
        pitch: column(t.map((s) => 0.1 * Math.cos(s)), 0.0005), yaw: column(zero, 0.0005), p: column(zero, 0.002), q: column(zero, 0.002), r: column(zero, 0.002),
        rotor1: column(t.map(() => 800), 1), rotor2: column(t.map(() => 805), 1), rotor3: column(t.map(() => 795), 1), rotor4: column(t.map(() => 810), 1),
      },
      reference: {
        t: column(ref, 0.001), x: column(ref.map((s) => placeAt(s, radius)[0]), 0.001), y: column(ref.map((s) => placeAt(s, radius)[1] + 0.1), 0.001),
        z: column(ref.map((s) => placeAt(s, radius)[2]), 0.001), yaw: column(ref.map(() => 0), 0.0005),
      },
      link: {
        hops: [
          {from: 'sim', to: 'casd', measured: 'stamps', messages: [{...sensor, bins: bins(500, 33)}, {...gps, bins: bins(5, 40)}]},
          {from: 'casd', to: 'fcu', measured: 'stamps', messages: [{...sensor, bins: bins(500, 860, kLossSecond)}, {...gps, bins: bins(5, 600)}]},
          {from: 'fcu', to: 'casd', measured: 'stamps', messages: [{...controls, bins: bins(400, 630)}]},
          {from: 'casd', to: 'sim', measured: 'stamps', messages: [{...controls, bins: bins(400, 0.1)}]},
        ],
        relay: [
          {from: 'sim', to: 'fcu', measured: 'stamps', messages: [{...sensor, bins: bins(500, 28)}]},
          {from: 'fcu', to: 'sim', measured: 'stamps', messages: [{...controls, bins: bins(400, 19)}]},
        ],
        loop: Array.from({length: kDuration_s}, (_, s): [number, number, number, number, number] => [s, 400, 1590, 4600, 9000]),
        tapes: [...Array.from({length: 10}, (_, i) => tape(i * 4, 'now')), tape(kLossSecond + 0.5, 'loss')],
      },
      log: {
        messages: [
          {name: 'HEARTBEAT', rates: Array.from({length: kDuration_s}, (_, s): [number, number] => [s, 1]), t: column(Array.from({length: kDuration_s}, (_, s) => s), 0.001), fields: [field('autopilot', Array.from({length: kDuration_s}, (_, s) => (s % 2 ? 12 : 8)))]},
          {
            name: 'LOCAL_POSITION_NED', rates: Array.from({length: kDuration_s}, (_, s): [number, number] => [s, 10]), t: column(local, 0.001),
            fields: [
              field('x', local.map((s) => placeAt(s, radius)[0] + 0.05), 'm'), field('y', local.map((s) => placeAt(s, radius)[1]), 'm'),
              field('z', local.map((s) => -placeAt(s, radius)[2]), 'm'), field('vx', local.map(() => 0), 'm/s'), field('vy', local.map(() => 0), 'm/s'), field('vz', local.map(() => 0), 'm/s'),
            ],
          },
          {
            name: 'ATTITUDE', rates: Array.from({length: kDuration_s}, (_, s): [number, number] => [s, 10]), t: column(local, 0.001),
            fields: [field('roll', local.map((s) => 0.1 * Math.sin(s)), 'rad'), field('pitch', local.map((s) => 0.1 * Math.cos(s)), 'rad'), field('yaw', local.map(() => 0), 'rad')],
          },
        ],
        texts: [[1.5, 6, 'Ready\u0007 for takeoff'], [26, 4, '<b>GPS</b> is weak']],
        states: [[0, 32, 'MISSION', 1], [2, 160, 'HOLD', 1], [4, 160, 'HOLD', 2], [39, 32, 'HOLD', 1]],
        duration_s: kDuration_s,
      },
    }],
  } as unknown as RecordFile;
}

/** A record as it lies in the page. */
export const pack = (record: RecordFile): string => gzipSync(JSON.stringify(record)).toString('base64');
