// SPDX-License-Identifier: BSD-3-Clause
import type {Bench} from './bench.ts';
import type {SimVehicle} from './protocol.ts';
import type {RunRecord, StepResponse} from './record.ts';
import {titlesOf} from './run_pair.ts';
import type {Series} from './series.ts';
import type {Player, Source} from './source.ts';

/** Plays a record, and a second one beside it, through the messages of the protocol. */
export class RecordSource implements Source, Player {
  readonly kind = 'record';
  readonly commands = false;
  readonly player = this;
  time_s = 0;
  playing = false;
  private speed_ = 1;
  private bench!: Bench;
  private last_s: number | null = null;
  private told = {second: -1, selected: -1, tape: -2, messages: -1};

  constructor(private readonly record: RunRecord, private readonly second?: RunRecord) {}

  get duration_s(): number {
    return this.record.duration_s;
  }
  get speed(): number {
    return this.speed_;
  }
  set speed(value: number) {
    this.speed_ = Math.max(0.1, Math.min(10, value));
  }

  start(bench: Bench): void {
    this.bench = bench;
    const {raw} = this.record;
    bench.connection = 'record';
    bench.readOnly = true;
    bench.name = raw.name;
    const parts = [this.record.raw.vehicles[0]?.scene?.name, raw.seed === undefined ? '' : `seed ${raw.seed}`];
    bench.subtitle = parts.filter(Boolean).join(' · ');
    bench.duration_s = this.record.duration_s;
    bench.virtual = raw.virtual ?? false;
    bench.rate = raw.rate;
    bench.nominal_hz = raw.nominal_hz ?? {};
    bench.controller = raw.controller ?? '';
    bench.measured = this.record.measured;
    bench.bounds = this.record.bounds;
    bench.vehicles = raw.vehicles.map(({name, system, scene}) => ({name, system, scene}));
    bench.scene = {hash: 'record', vehicles: raw.vehicles.flatMap(({scene}) => scene ?? []), world: raw.world?.parts, meshes: raw.world?.meshes};
    if (!this.record.hasLinks(0)) {
      bench.noLinks = raw.architecture === 'direct' ? 'simulator and controller are one process in this run' : 'not recorded';
    }
    if (this.second) {
      const [a, b] = titlesOf([this.record, this.second].map(({raw: {name}, source}) => ({name, source})));
      bench.name = a!.name;
      bench.subtitle = a!.differs;
      bench.besideTitle = b;
      bench.besideVerdict = this.second.verdict(0);
    }
    this.seek(this.begin_s);
  }

  /** Where a record is opened: before a failure, else at the measured stage, so that something flies. */
  private get begin_s(): number {
    return this.record.beforeFailure_s ?? this.record.measured?.[0] ?? 0;
  }

  tick(now_s: number): void {
    const passed = this.last_s === null ? 0 : Math.min(0.25, now_s - this.last_s);
    this.last_s = now_s;
    if (!this.playing) {
      if (this.told.selected !== this.bench.selected) this.feed();
      return;
    }
    this.time_s = Math.min(this.duration_s, this.time_s + passed * this.speed_);
    if (this.time_s >= this.duration_s) this.playing = false;
    this.feed();
  }

  play(on: boolean): void {
    if (on && this.time_s >= this.duration_s - 1e-6) this.time_s = 0;
    this.playing = on;
    this.feed();
  }

  seek(time_s: number): void {
    this.time_s = Math.max(0, Math.min(this.duration_s, time_s));
    this.feed();
  }

  call(method: string): Promise<unknown> {
    return Promise.reject(new Error(`a record cannot be commanded (${method})`));
  }

  series(vehicle: number, key: string): Series | undefined {
    return this.record.vehicles[vehicle]?.series(key);
  }

  /** Names of a message's fields. */
  fields(message: string): string[] {
    return [...(this.record.vehicles[this.bench.selected]?.message(message)?.fields.keys() ?? [])];
  }

  /** How the steps of the flight were followed. */
  get responses(): StepResponse[] {
    return this.record.raw.vehicles[this.bench.selected]?.responses ?? [];
  }

  /** Of the second run, on the clock of the first. */
  beside(vehicle: number, key: string): Series | undefined {
    const series = this.second?.vehicles[vehicle]?.series(key);
    if (!series) return undefined;
    const shift = this.shift_s;
    return {t: Float64Array.from(series.t, (t) => t - shift), v: series.v, unit: series.unit};
  }

  /** Both are aligned at the begin of the measured stage. */
  private get shift_s(): number {
    return (this.second?.measured?.[0] ?? 0) - (this.record.measured?.[0] ?? 0);
  }

  private feed(): void {
    const {bench, record, time_s: t} = this;
    const sims = record.vehicles.map((vehicle) => vehicle.simAt(t));
    bench.time_s = t;
    if (sims.every((sim): sim is SimVehicle => sim !== undefined) && sims.length > 0) {
      bench.apply('snap.sim', {t_s: t, rate: bench.rate, paused: !this.playing, v: sims});
    } else {
      bench.paused = !this.playing;
    }
    const clouds = record.vehicles.map((vehicle) => vehicle.cloudAt(t));
    if (clouds.some((cloud, i) => cloud !== bench.clouds.v[i])) bench.apply('snap.clouds', {v: clouds});
    bench.beside = this.second?.vehicles.map((vehicle) => vehicle.simAt(t + this.shift_s)) ?? [];
    bench.apply('snap.ref', {v: record.vehicles.map((vehicle) => vehicle.referenceAt(t) ?? null)});
    bench.apply('snap.vehicle', {vehicles: record.vehicles.map((vehicle) => ({state: vehicle.stateAt(t)}))});
    this.feedSlow(t);
  }

  private feedSlow(t: number): void {
    const {bench, record} = this;
    const vehicle = bench.selected;
    const other = vehicle !== this.told.selected;
    if (other) {
      this.told.selected = vehicle;
      bench.verdict = record.verdict(vehicle);
      bench.stages = record.raw.vehicles[vehicle]?.stages ?? [];
      bench.faults = record.raw.vehicles[vehicle]?.faults ?? [];
      bench.happenings = record.happenings(vehicle);
    }
    const second = Math.floor(t);
    if (other || second !== this.told.second) {
      this.told.second = second;
      if (record.hasLinks(vehicle)) {
        const {hops, forward} = record.hopsAt(vehicle, t);
        const forward_us = forward.flatMap(({from, to, us}) => (us ? [{from, to, ...us}] : []));
        bench.apply('snap.links', {hops, forward_us});
        const loop = record.loopAt(vehicle, t);
        bench.apply('snap.loop', {vehicles: loop ? [loop] : []});
      }
    }
    bench.loopOpen_s = record.openFor(vehicle, t);
    const tape = record.tapeAt(vehicle, t);
    if (tape && bench.tape !== tape) bench.apply('snap.tape', tape);
    const quarter = Math.floor(t * 4);
    if (other || quarter !== this.told.messages) {
      this.told.messages = quarter;
      bench.apply('snap.messages', {messages: record.messagesAt(vehicle, t)});
    }
  }
}
