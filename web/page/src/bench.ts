// SPDX-License-Identifier: BSD-3-Clause
// State of the bench on the page: folds the messages of a Source, and computes no verdict.
import {fromHome, quaternionOf, rpyOf, type Place, type Quat, type Rpy, type Vec3} from './frames.ts';
import {kWarning} from './protocol.ts';
import type {
  Delay, Happening, Hop, ListedMessage, LoopFigures, RunStatus, Scene, SceneVehicle, SimVehicle, SnapClouds, SnapLinks, SnapLoop, SnapRef,
  SnapSim, SnapTape, Span, Stage, VehicleState, Verdict,
} from './protocol.ts';
import {rowsOf} from './record.ts';

/** A motion in W with the age of its source. */
export interface Motion {
  p: Vec3;
  q: Quat;
  rpy: Rpy;
  vel: Vec3;
  age_s: number;
}

export interface BenchVehicle {
  name: string;
  system: number;
  scene?: SceneVehicle;
  sim?: SimVehicle;
  state?: VehicleState;
  /** Origin of the vehicle's N in W, once it is known. */
  origin_W?: Vec3;
  /** Where it shall be in the moment that is shown. */
  reference?: {p_W: Vec3; yaw_rad: number};
  /** The newest received reference, with its time. */
  told?: {t_s: number; p_W: Vec3; v_W: Vec3; yaw_rad: number};
}

export type Connection = 'record' | 'connecting' | 'live' | 'lost';

/** After so long without news a value is stale. */
export const kStale_s = 0.3;

/** After so long without a HEARTBEAT a vehicle is not commanded. */
const kHeartbeat_s = 3;

/** An older reference is not used. */
const kReference_s = 0.5;

/** Topics that missed three periods (2 s at least), with the age of their last snapshot. */
export function oldTopics(heard: Map<string, number>, rates: Record<string, number>, now_s: number): Map<string, number> {
  const old = new Map<string, number>();
  for (const [topic, at_s] of heard) {
    if (now_s - at_s > Math.max(2, 3 / (rates[topic] ?? 1))) old.set(topic, now_s - at_s);
  }
  return old;
}

/**
 * Origin of the vehicle's N in W, from one place that it gives both on Earth and in N: PX4's home,
 * else where it is now. ArduPilot fills HOME_POSITION's place in N with zeros.
 */
export function originOfN(state: VehicleState, home: Place): Vec3 | undefined {
  const {home: own, global, position_N: now} = state;
  if (state.autopilot === 'PX4' && own && [own.x_m, own.y_m, own.z_m].every(Number.isFinite)) {
    const [e, n, u] = fromHome(home, own);
    return [e - own.y_m, n - own.x_m, u + own.z_m];
  }
  if (!global || !now || Math.max(global.age_s, now.age_s) > 1) return undefined;
  const [e, n, u] = fromHome(home, global);
  const dt_s = now.age_s - global.age_s;  // the position in N, moved to the moment of the place on Earth
  return [e - now.y_m - now.vy_m_s * dt_s, n - now.x_m - now.vx_m_s * dt_s, u + now.z_m + now.vz_m_s * dt_s];
}

export class Bench {
  connection: Connection = 'connecting';
  /** Seconds since the page lost casweb, or has looked for it. */
  waiting_s = 0;
  readOnly = false;
  name = '';
  subtitle = '';
  /** How fast simulated time goes; nothing where it is not known. */
  rate?: number;
  paused = false;
  lateSteps?: number;
  virtual = false;
  time_s: number | null = null;
  /** Seconds since the simulator said anything. */
  simAge_s = 0;
  duration_s: number | null = null;
  vehicles: BenchVehicle[] = [];
  /** A second run in the same moment; nothing without one. */
  beside: (SimVehicle | undefined)[] = [];
  besideVerdict?: Verdict;
  /** Its name, and what differs from the first. */
  besideTitle?: {name: string; differs: string};
  private selectedSystem_?: number;
  scene?: Scene;
  wind_W?: Vec3;
  clouds: SnapClouds = {v: []};
  links?: SnapLinks;
  loopMeasured = 'stamps';
  loopOpen_s?: number;
  tape?: SnapTape;
  messages: ListedMessage[] = [];
  nominal_hz: Record<string, number> = {};
  /** Limits that the run sets; none where it sets none. */
  bounds: {loop_p99_ms?: number} = {};
  /** The run of hils that is flown, or was. */
  run?: RunStatus;
  /** Seconds since it was heard. */
  runAge_s = 0;
  private verdict_?: Verdict;
  /** Faults that may be begun by hand. */
  faultKinds: string[] = [];
  stages: Stage[] = [];
  faults: Span[] = [];
  measured: [number, number] | null = null;
  happenings: Happening[] = [];
  programs: {name: string; state: string; version?: string; reason?: string; age_s?: number}[] = [];
  controller = '';
  /** Why there are no links, in words. */
  noLinks = '';
  /** Topics whose last snapshot is old, with its age. */
  old = new Map<string, number>();
  private loops: LoopFigures[] = [];
  /** Errors of the page itself. */
  faultsOfPage: string[] = [];

  /** Place of the vehicle that is looked at; it is kept by its system id. */
  get selected(): number {
    return Math.max(0, this.vehicles.findIndex(({system}) => system === this.selectedSystem_));
  }
  set selected(i: number) {
    this.selectedSystem_ = this.vehicles[i]?.system;
  }

  get vehicle(): BenchVehicle | undefined {
    return this.vehicles[this.selected];
  }

  /** Of the selected vehicle; undefined if there is none. */
  get verdict(): Verdict | undefined {
    const {run} = this;
    if (!run) return this.verdict_;
    const own = run.vehicles.find(({system}) => system === this.vehicle?.system);
    return {
      state: this.runIsLost ? 'lost' : run.state, age_s: this.runAge_s, rows: rowsOf(own?.checks ?? []),
      every: run.vehicles.flatMap(({checks}) => rowsOf(checks)), sentences: run.sentences,
      touched: run.touched.map(({by, what}) => `${what} by ${by}`), out: run.out,
    };
  }
  /** The run was judged, and its programs have ended with it: nothing is wrong with the page. */
  get runIsOver(): boolean {
    return this.connection === 'lost' && this.run !== undefined && this.run.state !== 'running';
  }
  /** Nothing is known any more of a run that goes on: neither of its limits nor of its end. */
  private get runIsLost(): boolean {
    if (this.run?.state !== 'running') return false;
    return this.connection !== 'live' || this.old.has('verdict') || this.programs.some(({name, state}) => name === 'hils' && state !== 'up');
  }
  set verdict(verdict: Verdict | undefined) {
    this.verdict_ = verdict;
  }

  /** Takes in one message of the protocol; unknown ones are ignored. */
  apply(method: string, params: unknown): void {
    switch (method) {
      case 'snap.sim': return this.onSim(params as SnapSim);
      case 'snap.vehicle': return this.onVehicle(params as {vehicles: {state: VehicleState}[]});
      case 'snap.ref': return this.onReference(params as SnapRef);
      case 'snap.clouds': this.clouds = params as SnapClouds; return;
      case 'snap.links': this.links = params as SnapLinks; return;
      case 'snap.loop': return this.onLoop(params as SnapLoop);
      case 'snap.tape': this.tape = params as SnapTape; return;
      case 'snap.messages': this.messages = (params as {messages: ListedMessage[]}).messages ?? []; return;
      case 'snap.verdict':
      case 'event.verdict': return this.onRun(params as RunStatus);
      case 'event.statustext': {
        const event = params as {severity: number | string; text: string};
        this.happened({kind: 'text', severity: severityNumber(event.severity), text: event.text});
        return;
      }
      case 'event.link': {
        const event = params as {link: string; state: string; endpoint?: string};
        const bad = event.state === 'down';
        this.happened({kind: 'link', severity: bad ? 3 : 6, text: `Link ${event.link} ${event.state}`});
        return;
      }
      case 'event.program': {
        const event = params as {name: string; state: string; reason?: string};
        const known = this.programs.find((each) => each.name === event.name);
        if (known) Object.assign(known, event);
        else this.programs.push(event);
        if (event.name === 'hilsim' && event.state !== 'up') this.dropSim();
        const reason = event.reason ? `: ${event.reason}` : '';
        this.happened({kind: 'program', severity: event.state === 'up' ? 6 : 3, text: `${event.name} ${event.state}${reason}`});
        return;
      }
      case 'event.fault': {
        const event = params as {name: string; vehicle: number; began_s: number; ended_s: number};
        this.faults = [...this.faults, {name: event.name, begin_s: event.began_s, end_s: event.ended_s}];
        this.happened({kind: 'fault', severity: 4, text: `Fault ${event.name} of vehicle ${event.vehicle}`, by: 'hand'});
        return;
      }
    }
  }

  /** The vehicles of a scene in its order, then those that casd alone hears. */
  setScene(scene: Scene): void {
    const same = scene.hash === this.scene?.hash;
    this.scene = scene;
    const before = this.vehicles;
    const now = scene.vehicles.map((vehicle, i): BenchVehicle => {
      const system = vehicle.system ?? i + 1;
      const known = before.find((each) => each.system === system);
      return {
        name: vehicle.name, system, scene: vehicle, state: known?.state,
        sim: same ? known?.sim : undefined, origin_W: same ? known?.origin_W : undefined,
      };
    });
    const others = before.filter(({state, system}) => state && !now.some((each) => each.system === system));
    this.vehicles = [...now, ...others.map(({name, system, state}) => ({name, system, state}))];
  }

  /** Seconds go by without a word of casd. */
  growOld(dt_s: number): void {
    for (const {state} of this.vehicles) {
      if (!state) continue;
      if (state.heartbeat_age_s !== undefined) state.heartbeat_age_s += dt_s;
      for (const part of [state.position_N, state.attitude, state.global]) {
        if (part) part.age_s += dt_s;
      }
    }
  }

  /** Why the vehicle may not be commanded; empty where it may. */
  get interlock(): string {
    const state = this.vehicle?.state;
    if (this.connection !== 'live') return 'The page has no connection: nothing can be commanded.';
    if (this.programs.some((each) => each.name === 'casd' && each.state !== 'up')) return 'casd is down: nothing can be commanded.';
    if (!state) return 'No vehicle is heard: `casctl doctor` says why.';
    if (state.hil === false) return `Vehicle ${state.system} does not say that it is in HIL: casd refuses to command it from here.`;
    const silent_s = state.heartbeat_age_s ?? Infinity;
    const limit_s = state.silent_after_s ?? kHeartbeat_s;
    if (silent_s > limit_s) return `Vehicle ${state.system} is silent: its last HEARTBEAT is more than ${limit_s} s old.`;
    return '';
  }

  /** Hops of the vehicle that is looked at. */
  get hops(): Hop[] {
    return (this.links?.hops ?? []).filter(({system}) => this.isOwn(system));
  }

  /** The way through casd for its packets that come from a side, sim or fcu. */
  forward(from: string): Delay | undefined {
    return this.links?.forward_us?.find((each) => each.from === from && this.isOwn(each.system));
  }

  /** Whether a figure is of the selected vehicle; 0 is a figure without a vehicle. */
  private isOwn(system: number | undefined): boolean {
    return !system || system === this.vehicle?.system;
  }

  /** Figures of the loop; those of another vehicle are never its own. */
  loopOf(vehicle = this.vehicle): LoopFigures | undefined {
    return this.loops.find(({system}) => system === vehicle?.system) ?? this.loops.find(({system}) => system === undefined);
  }
  get loop(): LoopFigures | undefined {
    return this.loopOf();
  }

  /** Origin of the vehicle's N in W. A record counts in W itself; without a scene N is all there is. */
  originOf(vehicle = this.vehicle): Vec3 | undefined {
    return this.scene?.home ? vehicle?.origin_W : [0, 0, 0];
  }

  /** A place of W as a command wants it; nothing where the origin of N is not known. */
  inN(p_W: Vec3): {north_m: number; east_m: number; down_m: number} | undefined {
    const origin = this.originOf();
    return origin && {north_m: p_W[1] - origin[1], east_m: p_W[0] - origin[0], down_m: origin[2] - p_W[2]};
  }

  /** Where the simulator has the vehicle. */
  truth(vehicle = this.vehicle): Motion | undefined {
    const sim = vehicle?.sim;
    if (!sim) return undefined;
    return {p: sim.p, q: sim.q, rpy: rpyOf(sim.q), vel: sim.vel, age_s: this.simAge_s};
  }

  /** Where the vehicle believes to be; nothing where the origin of its N is not known. */
  estimate(vehicle = this.vehicle): Motion | undefined {
    const position = vehicle?.state?.position_N;
    const attitude = vehicle?.state?.attitude;
    const origin = this.originOf(vehicle);
    if (!position || !attitude || !origin) return undefined;
    const rpy = {roll: attitude.roll_rad, pitch: attitude.pitch_rad, yaw: attitude.yaw_rad};
    return {
      p: [position.y_m + origin[0], position.x_m + origin[1], origin[2] - position.z_m],
      q: quaternionOf(rpy),
      rpy,
      vel: [position.vy_m_s, position.vx_m_s, -position.vz_m_s],
      age_s: Math.max(position.age_s, attitude.age_s),
    };
  }

  /** The motion drawn as the vehicle: the truth, else the estimate. */
  motion(vehicle = this.vehicle): {motion: Motion; label: 'truth' | 'estimate'} | undefined {
    const truth = this.truth(vehicle);
    if (truth) return {motion: truth, label: 'truth'};
    const estimate = this.estimate(vehicle);
    return estimate && {motion: estimate, label: 'estimate'};
  }

  /** Bound of the distance from the reference: the largest of the position's limits, else 0.5 m. */
  get errorLimit_m(): number {
    const rows = this.verdict?.rows.filter((row) => row.unit === 'm' && row.limit !== null) ?? [];
    return rows.length > 0 ? Math.max(...rows.map((row) => row.limit!)) : 0.5;
  }

  /** Those that `next event` walks: faults, losses, incidents, warnings and worse, arming. */
  get marks(): Happening[] {
    return this.happenings.filter((each) => isMark(each));
  }

  private happened(event: Omit<Happening, 't_s'>): void {
    this.happenings.push({t_s: this.time_s ?? 0, ...event});
    if (this.happenings.length > 2000) this.happenings.splice(0, 500);
  }

  private onSim(snap: SnapSim): void {
    this.time_s = snap.t_s;
    this.simAge_s = 0;
    if (snap.rate !== undefined) this.rate = snap.rate;
    this.paused = snap.paused ?? false;
    this.lateSteps = snap.late_steps ?? this.lateSteps;
    this.wind_W = snap.wind_W;
    snap.v.forEach((sim, i) => {
      const known = this.vehicles[i];
      if (known) known.sim = sim;
      else this.vehicles.push({name: `vehicle ${i + 1}`, system: i + 1, sim});
    });
    for (const vehicle of this.vehicles.slice(snap.v.length)) vehicle.sim = undefined;
    for (const vehicle of this.vehicles) if (vehicle.told) vehicle.reference = referenceAt(vehicle.told, snap.t_s);
  }

  /** Nothing of a simulator that has ended is shown. */
  private dropSim(): void {
    for (const vehicle of this.vehicles) vehicle.sim = vehicle.reference = vehicle.told = undefined;
    this.clouds = {v: []};
    this.wind_W = this.rate = this.lateSteps = undefined;
    this.paused = false;
  }

  private onVehicle(snap: {vehicles: {state: VehicleState}[]}): void {
    for (const vehicle of this.vehicles) vehicle.state = undefined;
    for (const {state} of snap.vehicles) {
      const known = this.vehicles.find((each) => each.system === state.system);
      const vehicle = known ?? {name: `vehicle ${state.system}`, system: state.system};
      if (!known) this.vehicles.push(vehicle);
      vehicle.state = state;
      if (this.scene?.home) vehicle.origin_W = originOfN(state, this.scene.home) ?? vehicle.origin_W;
    }
    this.vehicles = this.vehicles.filter(({scene, sim, state}) => scene ?? sim ?? state);
  }

  private onReference(snap: SnapRef): void {
    snap.v.forEach((reference, i) => {
      const known = this.vehicles[i];
      if (!known) return;
      known.told = undefined;
      known.reference = reference ?? undefined;
      if (!reference?.v_W || snap.t_s === undefined) return;
      known.told = {t_s: snap.t_s, p_W: reference.p_W, v_W: reference.v_W, yaw_rad: reference.yaw_rad};
      known.reference = referenceAt(known.told, this.time_s ?? snap.t_s);
    });
  }

  /** A run of hils; its limits are its own words, none is computed here. */
  private onRun(run: RunStatus): void {
    if (run.state !== 'running' && this.run?.state === 'running') {
      this.happened({kind: 'stage', severity: run.state === 'passed' ? 6 : 3, text: `Verdict: ${run.state}`});
    }
    this.run = run;
    this.name = run.name;
    this.subtitle = `seed ${run.seed}`;
    this.stages = run.stages;
    const measured = run.stages.find((stage) => stage.measured);
    this.measured = measured ? [measured.begin_s, measured.end_s] : null;
  }

  private onLoop(snap: SnapLoop): void {
    this.loopMeasured = snap.measured ?? 'stamps';
    this.loops = snap.vehicles;
  }
}

/** The reference in the moment of a picture, which is a little before or after that of the received one. */
export function referenceAt(told: NonNullable<BenchVehicle['told']>, t_s: number): BenchVehicle['reference'] {
  const dt_s = t_s - told.t_s;
  if (Math.abs(dt_s) > kReference_s) return undefined;
  return {p_W: told.p_W.map((p, k) => p + told.v_W[k]! * dt_s) as Vec3, yaw_rad: told.yaw_rad};
}

export function isMark(event: Happening): boolean {
  if (event.kind === 'text') return event.severity <= kWarning;
  if (event.kind === 'state') return event.text === 'Armed' || event.text === 'Disarmed';
  return event.kind === 'fault' || event.kind === 'loss' || event.kind === 'incident' || event.kind === 'link';
}

function severityNumber(severity: number | string): number {
  if (typeof severity === 'number') return severity;
  const words = ['emergency', 'alert', 'critical', 'error', 'warning', 'notice', 'info', 'debug'];
  const i = words.indexOf(severity);
  return i < 0 ? 6 : i;
}
