// SPDX-License-Identifier: BSD-3-Clause
// What the page knows of the bench: folds the messages of a Source, and computes no verdict.
import {quaternionOf, rpyOf, type Quat, type Rpy, type Vec3} from './frames.ts';
import {kWarning} from './protocol.ts';
import type {
  Happening, ListedMessage, LoopFigures, Scene, SceneVehicle, SimVehicle, SnapLinks, SnapLoop, SnapSim, SnapTape, Span,
  Stage, VehicleState, Verdict,
} from './protocol.ts';

/** A motion in W with the age of what told it. */
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
  reference?: {p_W: Vec3; yaw_rad: number};
}

export type Connection = 'record' | 'connecting' | 'live' | 'lost';

/** After so long without news a value is stale. */
export const kStale_s = 0.3;

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
  besideName = '';
  selected = 0;
  scene?: Scene;
  wind_W?: Vec3;
  links?: SnapLinks;
  loop?: LoopFigures;
  loopMeasured = 'stamps';
  loopOpen_s?: number;
  actuatorTimeout_s = 0.5;
  tape?: SnapTape;
  messages: ListedMessage[] = [];
  nominal_hz: Record<string, number> = {};
  bounds = {loop_p99_ms: 10, lost: 0, line_full_pct: 90};
  verdict?: Verdict;
  stages: Stage[] = [];
  faults: Span[] = [];
  measured: [number, number] | null = null;
  happenings: Happening[] = [];
  programs: {name: string; state: string; version?: string; reason?: string; age_s?: number}[] = [];
  controller = '';
  /** Why there are no links, in words. */
  noLinks = '';
  /** Errors of the page itself. */
  faultsOfPage: string[] = [];

  get vehicle(): BenchVehicle | undefined {
    return this.vehicles[this.selected];
  }

  /** Takes in one message of the protocol; unknown ones are ignored. */
  apply(method: string, params: unknown): void {
    switch (method) {
      case 'snap.sim': return this.onSim(params as SnapSim);
      case 'snap.vehicle': return this.onVehicle(params as {vehicles: {state: VehicleState}[]});
      case 'snap.ref': return this.onReference(params as {v: (BenchVehicle['reference'] | null)[]});
      case 'snap.links': this.links = params as SnapLinks; return;
      case 'snap.loop': return this.onLoop(params as SnapLoop);
      case 'snap.tape': this.tape = params as SnapTape; return;
      case 'snap.messages': this.messages = (params as {messages: ListedMessage[]}).messages ?? []; return;
      case 'snap.verdict': this.verdict = params as Verdict; return;
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
        const reason = event.reason ? `: ${event.reason}` : '';
        this.happened({kind: 'program', severity: event.state === 'up' ? 6 : 3, text: `${event.name} ${event.state}${reason}`});
        return;
      }
      case 'event.fault': {
        const event = params as {kind: string; began_s: number; ended_s?: number};
        this.faults.push({name: event.kind, begin_s: event.began_s, end_s: event.ended_s ?? null});
        this.happened({kind: 'fault', severity: 4, text: `Fault ${event.kind}`});
        return;
      }
    }
  }

  setScene(scene: Scene): void {
    this.scene = scene;
    scene.vehicles.forEach((vehicle, i) => {
      const known = this.vehicles[i];
      if (known) Object.assign(known, {scene: vehicle, name: vehicle.name, system: vehicle.system ?? known.system});
      else this.vehicles.push({name: vehicle.name, system: vehicle.system ?? i + 1, scene: vehicle});
    });
  }

  /** Where the simulator has the vehicle. */
  truth(vehicle = this.vehicle): Motion | undefined {
    const sim = vehicle?.sim;
    if (!sim) return undefined;
    return {p: sim.p, q: sim.q, rpy: rpyOf(sim.q), vel: sim.vel, age_s: this.simAge_s};
  }

  /** Where the vehicle believes to be. */
  estimate(vehicle = this.vehicle): Motion | undefined {
    const position = vehicle?.state?.position_N;
    const attitude = vehicle?.state?.attitude;
    if (!position || !attitude) return undefined;
    const rpy = {roll: attitude.roll_rad, pitch: attitude.pitch_rad, yaw: attitude.yaw_rad};
    return {
      p: [position.y_m, position.x_m, -position.z_m],
      q: quaternionOf(rpy),
      rpy,
      vel: [position.vy_m_s, position.vx_m_s, -position.vz_m_s],
      age_s: Math.max(position.age_s, attitude.age_s),
    };
  }

  /** What is drawn as the vehicle: the truth, else the estimate. */
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
  }

  private onVehicle(snap: {vehicles: {state: VehicleState}[]}): void {
    snap.vehicles.forEach(({state}, i) => {
      const known = this.vehicles.find((each) => each.system === state.system) ?? this.vehicles[i];
      if (known) known.state = state;
      else this.vehicles.push({name: `vehicle ${state.system}`, system: state.system, state});
    });
  }

  private onReference(snap: {v: (BenchVehicle['reference'] | null)[]}): void {
    snap.v.forEach((reference, i) => {
      const known = this.vehicles[i];
      if (known) known.reference = reference ?? undefined;
    });
  }

  private onLoop(snap: SnapLoop): void {
    this.loopMeasured = snap.measured ?? 'stamps';
    const own = snap.vehicles.find((each) => each.system === this.vehicle?.system);
    this.loop = own ?? snap.vehicles[0];
  }
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
