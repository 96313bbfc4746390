// SPDX-License-Identifier: BSD-3-Clause
// The types of docs/develop/web_protocol.md. Unknown keys are ignored.
import type {Place, Quat, Vec3} from './frames.ts';

export interface Part {
  shape: 'box' | 'sphere' | 'cylinder' | 'plane' | 'mesh';
  size_m?: Vec3;
  radius_m?: number;
  length_m?: number;
  mesh?: string;
  p: Vec3;
  q: Quat;
  name?: string;
  /** Of a visual that turns with a control surface, about the y axis at x = size / 2. */
  surface?: {index: number; sign: number};
}

export interface SceneRotor {
  p_B: Vec3;
  axis_B: Vec3;
  radius_m: number;
  spin: number;
  k_f: number;
  omega_max_rad_s: number;
}

export interface SceneVehicle {
  name: string;
  system?: number;
  mass_kg?: number;
  parts?: Part[];
  /** Of its own model, without the rotors; where it has no mesh a stand-in is drawn. */
  visuals?: Part[];
  /** Of a record: triangles in base 64, which its parts name by their place. */
  meshes?: string[];
  rotors: SceneRotor[];
  rays?: {name: string; p_B: Vec3; dir_B: Vec3; max_m: number}[];
}

export interface Scene {
  hash: string;
  /** Origin of W. */
  home?: Place;
  vehicles: SceneVehicle[];
  world?: Part[];
  /** Of a record: triangles in base 64, which the parts of its world name by their place. */
  meshes?: string[];
  obstacles?: {name: string; parts: Part[]}[];
}

export interface SimVehicle {
  p: Vec3;
  q: Quat;
  vel: Vec3;
  w: Vec3;
  rotors: number[];
  /** Deflections of the control surfaces, rad. */
  surfaces?: number[];
  contact?: number;
  rays?: (number | null)[];
}

export interface SnapSim {
  t_s: number;
  rate?: number;
  paused?: boolean;
  late_steps?: number;
  v: SimVehicle[];
  wind_W?: Vec3;
  o?: {p: Vec3; q: Quat}[];
}

/** Returns of the lidars: of each vehicle x, y, z in W, one after the other. */
export interface SnapClouds {
  v: ArrayLike<number>[];
}

export interface Delay {
  p50: number;
  p99: number;
  max?: number;
}

/** One way of a link; `from` and `to` are sim, casd and fcu. */
export interface Hop {
  from: string;
  to: string;
  /** The vehicle; 0 while unknown. */
  system?: number;
  link?: string;
  type?: string;
  state?: string;
  endpoint?: string;
  baud?: number;
  full?: number;
  queued?: number;
  high_water?: number;
  msgs: Record<string, number>;
  lost?: number;
  /** HIL packets that casd dropped, by cause. */
  dropped?: Record<string, number>;
  us?: Delay;
  measured?: string;
}

export interface SnapLinks {
  hops: Hop[];
  forward_us?: ({from: string; to: string; system?: number; count?: number} & Delay)[];
}

export interface LoopFigures {
  system?: number;
  ms: Delay;
  count: number;
  unanswered?: number;
}

export interface SnapLoop {
  measured?: string;
  vehicles: LoopFigures[];
}

/** [message id, moment of leaving in us, us on the way]; a lost one has its id negated. */
export type TapePacket = [number, number, number];

export interface SnapTape {
  t_s: number;
  ms: number;
  around?: 'now' | 'loss';
  hops: Record<string, TapePacket[]>;
}

export interface VehicleState {
  system: number;
  autopilot?: string;
  type?: string;
  armed?: boolean;
  hil?: boolean;
  mode?: string;
  landed?: string;
  link?: string;
  heartbeat_age_s?: number;
  silent_after_s?: number;
  attitude?: {roll_rad: number; pitch_rad: number; yaw_rad: number; age_s: number};
  position_N?: {x_m: number; y_m: number; z_m: number; vx_m_s: number; vy_m_s: number; vz_m_s: number; age_s: number};
  global?: Place & {age_s: number};
  /** On Earth and in N. */
  home?: Place & {x_m: number; y_m: number; z_m: number};
  complaints?: string[];
}

export interface VerdictRow {
  name: string;
  value: number | null;
  limit: number | null;
  margin?: number | null;
  least?: boolean;
  unit?: string;
  digits?: number;
  missed?: boolean;
}

export interface Verdict {
  /** lost: it was running, and is heard no more. */
  state: 'running' | 'passed' | 'failed' | 'invalid' | 'lost';
  /** Seconds since its last report, for a run that is lost. */
  age_s?: number;
  /** Of the vehicle that is looked at. */
  rows: VerdictRow[];
  /** Of all vehicles of the run. */
  every?: VerdictRow[];
  sentences: string[];
  /** Acts of people on the run by hand, in words. */
  touched: string[];
  /** Folder of the results, when the run is over. */
  out?: string;
}

/** One thing that a run is held to, as hils writes it. */
export interface Check {
  what: string;
  validity: boolean;
  value: number | null;
  bound: number | null;
  /** How far the value is from the bound; negative beyond it. */
  margin?: number | null;
  least: boolean;
  unit: string;
  digits: number;
  found: string;
  wanted: string;
  judged: boolean;
  kept: boolean;
}

/** Where the vehicles of a run shall be at a moment; nothing before the climb and from the landing on. */
export interface SnapRef {
  t_s?: number;
  v: ({p_W: Vec3; v_W?: Vec3; yaw_rad: number} | null)[];
}

/** A run of hils while it flies, and when it is judged. */
export interface RunStatus {
  name: string;
  seed: number;
  state: Exclude<Verdict['state'], 'lost'>;
  sentences: string[];
  touched: {by: string; what: string}[];
  stages: Stage[];
  vehicles: {name: string; system: number; checks: Check[]}[];
  /** Folder of the results, with the verdict. */
  out?: string;
}

export interface ListedMessage {
  link: string;
  direction: string;
  id: number;
  name: string;
  system: number;
  component: number;
  count: number;
  hz: number;
  age_s: number;
}

export interface Stage {
  name: string;
  begin_s: number;
  end_s: number;
  measured: boolean;
  /** false: the flight ended in it. */
  finished?: boolean;
}

export interface Span {
  name: string;
  begin_s: number;
  end_s: number | null;
}

/** Something that happened. */
export interface Happening {
  t_s: number;
  kind: 'text' | 'state' | 'fault' | 'stage' | 'incident' | 'loss' | 'parameter' | 'act' | 'link' | 'program';
  severity: number;
  text: string;
  by?: string;
}

/** Severities of STATUSTEXT in words. */
export const kSeverities = ['emergency', 'alert', 'critical', 'error', 'warning', 'notice', 'info', 'debug'];
export const kWarning = 4;
