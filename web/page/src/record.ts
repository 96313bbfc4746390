// SPDX-License-Identifier: BSD-3-Clause
// The record of a run, as hils/replay/replay_record.cpp writes it, and what can be read from it at a
// moment. Pure: time is an argument.
import {quaternionOf, slerp, type Quat, type Vec3} from './frames.ts';
import {fixed} from './numbers.ts';
import type {
  Check, Happening, Hop, ListedMessage, LoopFigures, Part, SceneVehicle, SimVehicle, SnapTape, Span, Stage, Verdict, VerdictRow,
  VehicleState,
} from './protocol.ts';
import type {RunSource} from './run_pair.ts';
import {between, decode, indexAt, type Column, type Series} from './series.ts';

/** [second, left, arrived, median us, 99 % us]; without delays where none were measured. */
type Bin = [number, number, number, number?, number?];

interface RecordHop {
  from: string;
  to: string;
  measured: string;
  messages: {id: number; name: string; bins: Bin[]}[];
}

interface RecordLog {
  messages: {name: string; rates: [number, number][]; t: Column; fields: {name: string; unit?: string; values: Column}[]}[];
  texts: [number, number, string][];
  /** Moment, MAV_MODE_FLAG, mode as HEARTBEAT's number or a word, MAV_LANDED_STATE. */
  states: [number, number, string, number][];
  /** Whose own log it is; of telemetry the HEARTBEATs say it. */
  autopilot?: string;
  duration_s: number;
}

interface RecordVehicle {
  name: string;
  system: number;
  scene?: SceneVehicle;
  passed?: boolean;
  /** A person acted by hand. */
  touched?: boolean;
  checks?: Check[];
  stages?: (Stage & {step?: string})[];
  faults?: Span[];
  events?: {t_s: number; kind: Happening['kind']; text: string; by?: string; before?: number | null; after?: number | null}[];
  responses?: StepResponse[];
  truth?: Record<string, Column> | null;
  /** Returns of its lidars, scan by scan: moment, east, north, up in W. */
  clouds?: Record<string, Column> | null;
  reference?: Record<string, Column> | null;
  /** Of the estimate, in W; without it the first true position. */
  origin?: Vec3;
  link?: {hops: RecordHop[]; relay: RecordHop[]; loop: [number, number, number, number, number][]; tapes: SnapTape[]} | null;
  log?: RecordLog | null;
}

/** How the flight followed a step of its reference. */
export interface StepResponse {
  name: string;
  size_m: number;
  rise_s: number | null;
  overshoot_pct: number | null;
  settling_s: number | null;
  integrated_error_m_s: number | null;
}

export interface RecordFile {
  format: number;
  name: string;
  description?: string;
  seed?: number;
  architecture?: string;
  virtual?: boolean;
  duration_s: number;
  rate?: number;
  nominal_hz?: Record<string, number>;
  line?: {type: string; baud?: number};
  controller?: string;
  verdict?: {valid: boolean; passed: boolean; failures: string[]};
  /** What does not move. */
  world?: {parts: Part[]; meshes: string[]} | null;
  vehicles: RecordVehicle[];
}

const kDegrees = 180 / Math.PI;
/** How long a message counts as fresh: three periods, at least 0.3 s. */
const kFresh_s = 0.3;
/** So long the returns of a lidar are shown. */
const kCloud_s = 1;

type Columns = Record<string, Float64Array>;

function decodeAll(columns: Record<string, Column> | null | undefined): Columns | undefined {
  if (!columns) return undefined;
  return Object.fromEntries(Object.entries(columns).map(([name, column]) => [name, decode(column)]));
}

/** Decoded when it is first asked for: a record has hundreds, and a page shows few of them. */
class LazyColumn {
  private values_?: Float64Array;

  constructor(private readonly column: Column, readonly unit?: string) {}

  get values(): Float64Array {
    return (this.values_ ??= decode(this.column));
  }
}

class RecordMessage {
  readonly name: string;
  readonly rates: Map<number, number>;
  readonly fields: Map<string, LazyColumn>;
  private readonly times: LazyColumn;

  constructor(raw: RecordLog['messages'][number]) {
    this.name = raw.name;
    this.rates = new Map(raw.rates);
    this.fields = new Map(raw.fields.map(({name, unit, values}) => [name, new LazyColumn(values, unit)]));
    this.times = new LazyColumn(raw.t);
  }

  get t(): Float64Array {
    return this.times.values;
  }
}

/** "north" for "RMS error of the true position, x_m". */
export function rowName(what: string): string {
  const axis: Record<string, string> = {x_m: 'north', y_m: 'east', z_m: 'up', yaw_rad: 'yaw'};
  const rms = /^RMS error of the (.*), (x_m|y_m|z_m|yaw_rad)$/.exec(what);
  if (rms) return (rms[1]!.startsWith('estimate') ? 'est. ' : '') + axis[rms[2]!]!;
  return what
    .replace(/^HIL_/, '')
    .replace(/rate of HIL_(\w+), error either way/, '$1 rate off')
    .replace('sensor to control', 'loop')
    .replace(/ time of step/, '')
    .replace(/ of step/, '');
}

/** The limits on the flight among all that a run is held to. */
export function rowsOf(checks: Check[]): VerdictRow[] {
  return checks.filter((check) => !check.validity).map((check) => ({
    name: rowName(check.what), value: check.value, limit: check.bound, margin: check.margin, least: check.least,
    unit: check.unit, digits: check.digits, missed: check.judged && !check.kept,
  }));
}

/** MAV_AUTOPILOT in casd's words. */
const kAutopilots: Record<number, string> = {3: 'ArduPilot', 12: 'PX4'};

const kLanded = ['', 'on_ground', 'in_air', 'takeoff', 'landing'];

/** One vehicle of a record with its columns decoded. */
export class VehicleRecord {
  readonly truth: Columns | undefined;
  readonly reference: Columns | undefined;
  private readonly clouds: Columns | undefined;
  private cloud: {first: number; end: number; places: Float32Array} = {first: 0, end: 0, places: new Float32Array()};
  readonly messages: RecordMessage[];
  /** From its HEARTBEATs; those of other components of the system do not count. */
  readonly autopilot: string | undefined;
  /** Origin of the estimate, in W: where the vehicle stood at the start, unless the record knows better. */
  readonly origin: Vec3 = [0, 0, 0];
  private readonly cache = new Map<string, Series | undefined>();

  constructor(readonly raw: RecordVehicle) {
    this.truth = decodeAll(raw.truth);
    this.reference = decodeAll(raw.reference);
    this.clouds = decodeAll(raw.clouds);
    this.messages = (raw.log?.messages ?? []).map((message) => new RecordMessage(message));
    const autopilots = this.message('HEARTBEAT')?.fields.get('autopilot')?.values ?? [];
    this.autopilot = raw.log?.autopilot ?? kAutopilots[autopilots.find((value) => value in kAutopilots) ?? -1];
    const {truth} = this;
    if (truth && truth.t!.length > 0) this.origin = [truth.y![0]!, truth.x![0]!, truth.z![0]!];
    if (raw.origin) this.origin = raw.origin;
  }

  get rotors(): number {
    return this.count('rotor');
  }

  /** Columns of the truth with a number behind their name. */
  private count(name: string): number {
    return Object.keys(this.truth ?? {}).filter((column) => column.startsWith(name)).length;
  }

  message(name: string): RecordMessage | undefined {
    return this.messages.find((message) => message.name === name);
  }

  /** The vehicle's own reports, by telemetry or in its own log: fields of one name. */
  private get status(): RecordMessage | undefined {
    return this.message('HEARTBEAT') ?? this.message('vehicle_status');
  }
  private get position(): RecordMessage | undefined {
    return this.message('LOCAL_POSITION_NED') ?? this.message('vehicle_local_position');
  }
  private get attitude(): RecordMessage | undefined {
    return this.message('ATTITUDE') ?? this.message('vehicle_attitude');
  }

  /** The true motion at a moment; nothing without truth. */
  simAt(t: number): SimVehicle | undefined {
    const truth = this.truth;
    if (!truth || truth.t!.length === 0) return undefined;
    const times = truth.t!;
    const i = Math.max(0, indexAt(times, t));
    const j = Math.min(times.length - 1, i + 1);
    const span = times[j]! - times[i]!;
    const share = span > 0 ? Math.max(0, Math.min(1, (t - times[i]!) / span)) : 0;
    const mix = (name: string) => truth[name]![i]! + share * (truth[name]![j]! - truth[name]![i]!);
    const attitude = (k: number): Quat => quaternionOf({roll: truth.roll![k]!, pitch: truth.pitch![k]!, yaw: truth.yaw![k]!});
    const each = (name: string) => Array.from({length: this.count(name)}, (_, k) => mix(`${name}${k + 1}`));
    return {
      p: [mix('y'), mix('x'), mix('z')],
      q: slerp(attitude(i), attitude(j), share),
      vel: [mix('vy'), mix('vx'), mix('vz')],
      w: [mix('p'), -mix('q'), -mix('r')],
      rotors: each('rotor'),
      surfaces: each('surface'),
    };
  }

  /** East, north and up of what its lidars saw just before a moment, one after the other; the same object while it stays. */
  cloudAt(t: number): Float32Array {
    const {clouds} = this;
    if (!clouds) return this.cloud.places;
    const first = indexAt(clouds.t!, t - kCloud_s) + 1;
    const end = indexAt(clouds.t!, t) + 1;
    if (first !== this.cloud.first || end !== this.cloud.end) {
      const places = new Float32Array(3 * (end - first));
      [clouds.e!, clouds.n!, clouds.u!].forEach((column, axis) => {
        for (let i = first; i < end; ++i) places[3 * (i - first) + axis] = column[i]!;
      });
      this.cloud = {first, end, places};
    }
    return this.cloud.places;
  }

  /** The reference at a moment; undefined outside the flight. */
  referenceAt(t: number): {p_W: Vec3; yaw_rad: number} | undefined {
    const ref = this.reference;
    if (!ref) return undefined;
    const i = indexAt(ref.t!, t);
    if (i < 0 || t - ref.t![i]! > 0.2) return undefined;
    return {p_W: [ref.y![i]!, ref.x![i]!, ref.z![i]!], yaw_rad: ref.yaw![i]!};
  }

  /** The vehicle's state, as vehicle.state answers it. */
  stateAt(t: number): VehicleState {
    const states = this.raw.log?.states ?? [];
    const state = states[indexAt(states.map((row) => row[0]), t)];
    const result: VehicleState = {system: this.raw.system, autopilot: this.autopilot};
    if (state) {
      result.armed = (state[1] & 128) !== 0;
      result.hil = (state[1] & 32) !== 0;
      result.mode = state[2];
      result.landed = kLanded[state[3]];
    }
    const heartbeat = this.status;
    if (heartbeat) {
      const i = indexAt(heartbeat.t, t);
      if (i >= 0) result.heartbeat_age_s = t - heartbeat.t[i]!;
    }
    const local = this.position;
    const attitude = this.attitude;
    const i = local ? indexAt(local.t, t) : -1;
    const at = (message: RecordMessage, name: string) => {
      const field = message.fields.get(name);
      return field ? (between(message.t, field.values, t) ?? field.values[indexAt(message.t, t)]!) : NaN;
    };
    if (local && i >= 0) {
      const fresh = local.t[i]! + kFresh_s > t;
      const when = (name: string) => (fresh ? at(local, name) : (local.fields.get(name)?.values[i] ?? NaN));
      result.position_N = {
        x_m: when('x') + this.origin[1],
        y_m: when('y') + this.origin[0],
        z_m: when('z') - this.origin[2],
        vx_m_s: when('vx'),
        vy_m_s: when('vy'),
        vz_m_s: when('vz'),
        age_s: t - local.t[i]!,
      };
    }
    const j = attitude ? indexAt(attitude.t, t) : -1;
    if (attitude && j >= 0) {
      const nearest = (name: string) => attitude.fields.get(name)?.values[j] ?? NaN;
      result.attitude = {
        roll_rad: at(attitude, 'roll'),
        pitch_rad: at(attitude, 'pitch'),
        yaw_rad: nearest('yaw'),  // wraps
        age_s: t - attitude.t[j]!,
      };
    }
    return result;
  }

  /** A quantity over the whole run. */
  series(key: string): Series | undefined {
    if (!this.cache.has(key)) this.cache.set(key, this.makeSeries(key));
    return this.cache.get(key);
  }

  private makeSeries(key: string): Series | undefined {
    const dot = key.indexOf('.');
    const [whole, part] = [key.slice(0, dot), key.slice(dot + 1)];
    if (whole === 'truth') return this.ofTruth(part);
    if (whole === 'ref' && this.reference) {
      const name = {n: 'x', e: 'y', u: 'z'}[part];
      return name ? {t: this.reference.t!, v: this.reference[name]!} : undefined;
    }
    if (whole === 'est') return this.ofEstimate(part);
    if (whole === 'rotor' && this.truth?.[`rotor${part}`]) return {t: this.truth.t!, v: this.truth[`rotor${part}`]!};
    if (key === 'error.m') return this.error();
    if (whole === 'loop' && this.raw.link) {
      const column = part === 'p50' ? 2 : 3;
      const rows = this.raw.link.loop;
      if (rows.length === 0) return undefined;
      return {t: rows.map((row) => row[0] + 0.5), v: rows.map((row) => row[column] / 1000)};
    }
    const message = this.message(whole);
    const field = message?.fields.get(part);
    return field ? {t: message!.t, v: field.values, unit: field.unit} : undefined;
  }

  private ofTruth(part: string): Series | undefined {
    const truth = this.truth;
    if (!truth) return undefined;
    const name = {n: 'x', e: 'y', u: 'z'}[part];
    if (name) return {t: truth.t!, v: truth[name]!};
    if (truth[part]) return {t: truth.t!, v: truth[part]!.map((value) => value * kDegrees)};
    return undefined;
  }

  private ofEstimate(part: string): Series | undefined {
    const local = this.position;
    const attitude = this.attitude;
    const shifted = (name: string, sign: number, offset: number) => {
      const field = local?.fields.get(name);
      return field ? {t: local!.t, v: field.values.map((value) => sign * value + offset)} : undefined;
    };
    if (part === 'n') return shifted('x', 1, this.origin[1]);
    if (part === 'e') return shifted('y', 1, this.origin[0]);
    if (part === 'u') return shifted('z', -1, this.origin[2]);
    const field = attitude?.fields.get(part);
    return field ? {t: attitude!.t, v: field.values.map((value) => value * kDegrees)} : undefined;
  }

  /** Distance of the truth from the reference, between climb and the end of the measured part. */
  private error(): Series | undefined {
    const truth = this.truth;
    if (!truth || !this.reference) return undefined;
    const stages = this.raw.stages ?? [];
    const begin_s = stages.find((stage) => stage.step === 'takeoff')?.end_s ?? 0;
    const end_s = stages.find((stage) => stage.measured)?.end_s ?? Infinity;
    const v = new Float64Array(truth.t!.length).fill(NaN);
    for (let i = 0; i < v.length; ++i) {
      const ref = this.referenceAt(truth.t![i]!);
      if (!ref || truth.t![i]! < begin_s || truth.t![i]! > end_s) continue;
      v[i] = Math.hypot(truth.y![i]! - ref.p_W[0], truth.x![i]! - ref.p_W[1], truth.z![i]! - ref.p_W[2]);
    }
    return {t: truth.t!, v};
  }
}

function binAt(bins: Bin[], second: number): Bin | undefined {
  const i = indexAt(bins.map((bin) => bin[0]), second);
  return i >= 0 && bins[i]![0] === second ? bins[i] : undefined;
}

/** A run, or a flight log alone. */
export class RunRecord {
  readonly vehicles: VehicleRecord[];

  constructor(readonly raw: RecordFile, readonly source?: RunSource) {
    if (raw.format !== 1) throw new Error(`this record has format ${raw.format}; the page reads 1`);
    this.vehicles = raw.vehicles.map((vehicle) => new VehicleRecord(vehicle));
  }

  get duration_s(): number {
    return this.raw.duration_s;
  }

  /** Begin and end of the measured stage. */
  get measured(): [number, number] | null {
    const stage = this.raw.vehicles[0]?.stages?.find((each) => each.measured);
    return stage ? [stage.begin_s, stage.end_s] : null;
  }

  /** Seconds before the first thing that went wrong in a failed flight. */
  get beforeFailure_s(): number | null {
    const kBefore_s = 3;
    if (!this.raw.verdict || this.raw.verdict.passed) return null;
    const times = this.raw.vehicles.flatMap(({events}) => (events ?? []).filter((event) => event.kind === 'incident').map((event) => event.t_s));
    return times.length ? Math.max(0, Math.min(...times) - kBefore_s) : null;
  }

  /** Limits of the links that the run was held to. */
  get bounds(): {loop_p99_ms?: number} {
    const loop = this.raw.vehicles[0]?.checks?.find((check) => check.what === 'delay of the loop, 99 %');
    return loop?.bound == null ? {} : {loop_p99_ms: loop.bound / 1000};
  }

  hasLinks(vehicle: number): boolean {
    return Boolean(this.raw.vehicles[vehicle]?.link?.hops.length);
  }

  /** The second of a moment; in the last one, which the end cut, the one before it. */
  private secondOf(vehicle: number, t: number): number {
    const ends = (this.raw.vehicles[vehicle]?.link?.hops ?? []).flatMap(({messages}) => messages.map(({bins}) => bins.at(-1)?.[0] ?? 0));
    return Math.max(0, Math.min(Math.floor(t), Math.floor(this.duration_s) - 1, ends.length > 0 ? Math.max(...ends) - 1 : Infinity));
  }

  /** The hops in the second of a moment. */
  hopsAt(vehicle: number, t: number): {hops: Hop[]; forward: Hop[]} {
    const raw = this.raw.vehicles[vehicle];
    const second = this.secondOf(vehicle, t);
    const line = this.raw.line;
    const make = (hop: RecordHop): Hop => {
      const msgs: Record<string, number> = {};
      let lost = 0;
      for (const message of hop.messages) {
        msgs[message.name] = binAt(message.bins, second)?.[2] ?? 0;
        const last = message.bins.at(-1)?.[0] ?? 0;
        for (const bin of message.bins) {
          if (bin[0] <= second && bin[0] < last) lost += bin[1] - bin[2];
        }
      }
      if (hop.from === 'fcu' && raw?.log) {
        let other = 0;
        for (const message of this.vehicles[vehicle]!.messages) {
          if (!message.name.startsWith('HIL_')) other += message.rates.get(second) ?? 0;
        }
        if (other > 0) msgs.other = other;
      }
      const main = hop.messages[0] && binAt(hop.messages[0].bins, second);
      const us = main?.[3] !== undefined ? {p50: main[3], p99: main[4]!} : undefined;
      const onLine = hop.from === 'fcu' || hop.to === 'fcu';
      return {
        from: hop.from, to: hop.to, msgs, lost, us, measured: hop.measured,
        type: onLine ? (line?.type ?? 'serial') : 'udp',
        baud: onLine ? line?.baud : undefined,
      };
    };
    return {hops: (raw?.link?.hops ?? []).map(make), forward: (raw?.link?.relay ?? []).map(make)};
  }

  loopAt(vehicle: number, t: number): LoopFigures | undefined {
    const rows = this.raw.vehicles[vehicle]?.link?.loop ?? [];
    const second = this.secondOf(vehicle, t);
    const i = indexAt(rows.map((row) => row[0]), second);
    const row = rows[i];
    if (!row || row[1] === 0 || second - row[0] > 2) return undefined;
    return {ms: {p50: row[2] / 1000, p99: row[3] / 1000, max: row[4] / 1000}, count: row[1]};
  }

  /** Seconds since a control answered a sensor message; nothing while the loop is closed. */
  openFor(vehicle: number, t: number): number | undefined {
    const rows = this.raw.vehicles[vehicle]?.link?.loop ?? [];
    const i = indexAt(rows.map((row) => row[0]), t);
    if (i < 0 || i === rows.length - 1 || Math.floor(t) === rows[i]![0]) return undefined;
    return t - rows[i]![0] - 1;
  }

  /** The tape that is played at a moment; one around a loss goes before. */
  tapeAt(vehicle: number, t: number): SnapTape | undefined {
    const tapes = this.raw.vehicles[vehicle]?.link?.tapes ?? [];
    const past = tapes.filter((tape) => tape.t_s <= t + 1e-9);
    const loss = past.findLast((tape) => tape.around === 'loss' && t - tape.t_s < 4);
    return loss ?? past.findLast((tape) => tape.around !== 'loss');
  }

  /** Rates of all messages, as message.list answers. */
  messagesAt(vehicle: number, t: number): ListedMessage[] {
    const record = this.vehicles[vehicle];
    if (!record) return [];
    const second = this.secondOf(vehicle, t);
    const list: ListedMessage[] = [];
    const add = (link: string, name: string, id: number, hz: number, age_s: number) => {
      list.push({link, direction: 'rx', id, name, system: record.raw.system, component: 1, count: 0, hz, age_s});
    };
    for (const hop of this.raw.vehicles[vehicle]?.link?.hops ?? []) {
      if (hop.from !== 'sim' && hop.from !== 'fcu') continue;
      for (const message of hop.messages) {
        add(hop.from, message.name, message.id, binAt(message.bins, second)?.[2] ?? 0, 0);
      }
    }
    for (const message of record.messages) {
      if (list.some((each) => each.name === message.name)) continue;
      const i = indexAt(message.t, t);
      // Rare messages: over the last five seconds.
      let count = 0;
      for (let s = second - 4; s <= second; ++s) count += message.rates.get(s) ?? 0;
      const hz = (message.rates.get(second) ?? 0) > 4 ? message.rates.get(second)! : count / 5;
      add('fcu', message.name, -1, hz, i >= 0 ? t - message.t[i]! : Infinity);
    }
    return list;
  }

  verdict(vehicle: number): Verdict | undefined {
    const verdict = this.raw.verdict;
    if (!verdict) return undefined;
    const raw = this.raw.vehicles[vehicle];
    const state = !verdict.valid ? 'invalid' : verdict.passed ? 'passed' : 'failed';
    const acts = (raw?.events ?? []).filter((event) => event.kind === 'act');
    const touched = acts.map((event) => `${event.text} by ${event.by ?? 'somebody'}`);
    if (raw?.touched && touched.length === 0) touched.push('parameters were changed from outside');
    return {state, rows: rowsOf(raw?.checks ?? []), sentences: verdict.failures, touched: raw?.touched ? touched : []};
  }

  /** Everything that happened to a vehicle, in the order of time. */
  happenings(vehicle: number): Happening[] {
    const raw = this.raw.vehicles[vehicle];
    if (!raw) return [];
    const list: Happening[] = [];
    for (const [t_s, severity, text] of raw.log?.texts ?? []) list.push({t_s, kind: 'text', severity, text});
    let armed = false;
    let mode = '';
    for (const [t_s, base, nowMode] of raw.log?.states ?? []) {
      const nowArmed = (base & 128) !== 0;
      if (nowArmed !== armed) list.push({t_s, kind: 'state', severity: 6, text: nowArmed ? 'Armed' : 'Disarmed'});
      if (nowMode !== mode && mode !== '') list.push({t_s, kind: 'state', severity: 6, text: `Mode ${nowMode}`});
      armed = nowArmed;
      mode = nowMode;
    }
    for (const fault of raw.faults ?? []) {
      list.push({t_s: fault.begin_s, kind: 'fault', severity: 4, text: `Fault ${fault.name} begins`});
      if (fault.end_s !== null) list.push({t_s: fault.end_s, kind: 'fault', severity: 5, text: `Fault ${fault.name} ends`});
    }
    for (const event of raw.events ?? []) {
      const change = event.kind === 'parameter' ? ` ${fixed(event.before, 3)} → ${fixed(event.after, 3)}` : '';
      list.push({
        t_s: event.t_s, kind: event.kind, severity: event.kind === 'incident' ? 2 : event.kind === 'loss' ? 4 : 6,
        text: event.text + change, by: event.by,
      });
    }
    list.push(...this.losses(vehicle));
    return list.sort((a, b) => a.t_s - b.t_s);
  }

  private losses(vehicle: number): Happening[] {
    const names: Record<string, string> = {sim: 'simulator', casd: 'casd', fcu: 'controller'};
    const list: Happening[] = [];
    for (const hop of this.raw.vehicles[vehicle]?.link?.hops ?? []) {
      for (const message of hop.messages) {
        const last = message.bins.at(-1)?.[0] ?? 0;
        for (const bin of message.bins) {
          const lost = bin[1] - bin[2];
          if (lost <= 0 || bin[0] >= last) continue;
          list.push({
            t_s: bin[0], kind: 'loss', severity: 4,
            text: `${lost} ${message.name} lost between ${names[hop.from]} and ${names[hop.to]}`,
          });
        }
      }
    }
    return list;
  }
}

/** Reads the block of a record out of the page: gzip in base 64, and where it is from as JSON in base 64. */
export async function unpack(text: string, source?: string): Promise<RunRecord> {
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new RunRecord(JSON.parse(await new Response(stream).text()) as RecordFile, source ? JSON.parse(atob(source)) as RunSource : undefined);
}
