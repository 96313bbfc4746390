// SPDX-License-Identifier: BSD-3-Clause
import {kStale_s, oldTopics, type Bench} from './bench.ts';
import {rpyOf} from './frames.ts';
import {makeNonce, tokenProof} from './proof.ts';
import type {Scene, SnapSim} from './protocol.ts';
import {Ring, type Series} from './series.ts';
import type {Source} from './source.ts';

/** Arrivals are stamped on the clock of the frames, which does not stand still in a hidden tab. */
const clock_s = (): number => performance.now() / 1000;

const kFirstRetry_s = 0.25;
const kLastRetry_s = 4;
const kHidden_ms = 1000;
const kMostFields = 10;
const kDegrees = 180 / Math.PI;
const kTopics = ['sim', 'clouds', 'links', 'loop', 'messages', 'value', 'vehicle', 'verdict', 'tape', 'ref'];

const kUnknownToken = 'casweb does not know this token: open the address that it printed.';

interface Answer {
  resolve: (result: unknown) => void;
  reject: (error: Error) => void;
}

interface Frame {
  id?: number;
  method?: string;
  params?: {seq?: number};
  result?: unknown;
  error?: {code: number; message: string};
}

interface Hello {
  read_only?: boolean;
  protocol: number;
  topics: Record<string, number>;
  clock?: {sim_s: number; rate: number; paused: boolean} | null;
  methods?: string[];
}

/** Seconds until the next try to connect: doubling. */
export function retryAfter(tries: number): number {
  return Math.min(kLastRetry_s, kFirstRetry_s * 2 ** tries);
}

/** Keeps the token of the address for this tab, and takes it out of the address bar; false without one. */
function takeToken(): boolean {
  const parts = new URLSearchParams(location.hash.slice(1));
  const token = parts.get('k') ?? parts.get('v');
  if (!token) return false;
  sessionStorage.setItem('token', token);
  history.replaceState(null, '', location.pathname);
  return true;
}

/** A bench that flies, over the WebSocket of casweb. */
export class LiveSource implements Source {
  readonly kind = 'live';
  private bench!: Bench;
  private socket?: WebSocket;
  private tries = 0;
  private retryAt_s = 0;
  private began_s: number | null = null;
  private lostAt_s: number | null = null;
  private now_s = 0;
  private nextId = 1;
  private readonly answers = new Map<number, Answer>();
  private readonly rings = new Map<string, Ring>();
  private readonly acks = new Map<string, number>();
  private ackTimer?: ReturnType<typeof setTimeout>;
  private heardSim_s = 0;
  /** Moment up to which the vehicles' ages count. */
  private agedTo_s = 0;
  private readonly heard = new Map<string, number>();
  private rates: Record<string, number> = {};
  private methods = new Set<string>();
  private watched = new Map<string, {message: string; fields: string[]}>();
  /** The user's open messages, and their subscriptions. */
  private opened: Parameters<LiveSource['open']> = ['LOCAL_POSITION_NED'];
  private readonly known = new Map<string, string[]>();
  private units = new Map<string, string>();

  get commands(): boolean {
    return !this.bench.readOnly && this.methods.has('vehicle.hold');
  }

  start(bench: Bench): void {
    this.bench = bench;
    takeToken();
    bench.name = 'bench';
    window.addEventListener('hashchange', this.onAddress);
    this.connect();
  }

  /** Another address in the same tab: its token is tried at once. */
  private readonly onAddress = () => {
    if (!takeToken()) return;
    this.tries = 0;
    this.retryAt_s = 0;
    this.socket?.close();
  };

  private connect(): void {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = new WebSocket(`${scheme}://${location.host}/rpc`);
    this.socket = socket;
    socket.addEventListener('open', () => void this.hello());
    socket.addEventListener('message', (event) => this.onFrame(JSON.parse(String(event.data)) as Frame));
    socket.addEventListener('close', (event) => this.onClose(event));
  }

  private async hello(): Promise<void> {
    try {
      const hello = await this.greet();
      this.tries = 0;
      this.lostAt_s = null;
      const {bench} = this;
      bench.faultsOfPage = [];
      bench.connection = 'live';
      bench.readOnly = hello.read_only ?? false;
      this.methods = new Set(hello.methods ?? []);
      this.heardSim_s = clock_s();
      if (hello.clock) bench.apply('snap.sim', {t_s: hello.clock.sim_s, rate: hello.clock.rate, paused: hello.clock.paused, v: []});
      this.rates = hello.topics;
      const topics = Object.fromEntries(Object.entries(hello.topics).filter(([topic]) => kTopics.includes(topic)));
      await this.call('watch', {topics});
      await this.refresh();
    } catch (error) {
      this.bench.faultsOfPage = [error instanceof Error ? error.message : String(error)];
    }
  }

  /** Both ends prove that they know the token of the address; a program that took the port gets nothing that it can use. */
  private async greet(): Promise<Hello> {
    const token = sessionStorage.getItem('token') ?? '';
    const pageNonce = makeNonce();
    const server = (await this.call('hello', {protocol: 2, nonce: pageNonce})) as {nonce: string; proof: string};
    const context = {place: location.host, pageNonce, serverNonce: server.nonce};
    if (server.proof !== tokenProof(token, 'server', context)) {
      sessionStorage.removeItem('token');
      this.socket?.close();
      throw new Error(kUnknownToken);
    }
    return (await this.call('hello', {protocol: 2, proof: tokenProof(token, 'client', context), client: 'page 0.2.0'})) as Hello;
  }

  /** Fetches the scene, the programs present, and the kinds of faults. */
  private async refresh(): Promise<void> {
    const scene = await this.call('sim.scene').catch(() => null);
    if (scene) this.bench.setScene(scene as Scene);
    const status = (await this.call('bench.status').catch(() => null)) as {programs: Bench['programs']} | null;
    if (status) this.bench.programs = status.programs;
    const faults = this.methods.has('fault.inject') ? await this.call('fault.list').catch(() => null) : null;
    this.bench.faultKinds = (faults as {kinds: string[]} | null)?.kinds ?? [];
    this.open(...this.opened);
  }

  private onClose(event: CloseEvent): void {
    for (const {reject} of this.answers.values()) reject(new Error('the page lost casweb'));
    this.answers.clear();
    this.acks.clear();
    this.watched.clear();
    if (this.bench.connection === 'live') {
      this.bench.connection = 'lost';
      this.lostAt_s = this.now_s;
    }
    if (event.code === 4403) this.bench.faultsOfPage = [kUnknownToken];
    this.retryAt_s = this.now_s + retryAfter(this.tries++);
    this.socket = undefined;
  }

  tick(now_s: number): void {
    const {bench} = this;
    this.now_s = now_s;
    this.began_s ??= now_s;
    bench.waiting_s = now_s - (this.lostAt_s ?? this.began_s);
    bench.simAge_s = bench.time_s !== null && !bench.paused ? Math.max(0, now_s - this.heardSim_s) : 0;
    bench.runAge_s = now_s - (this.heard.get('verdict') ?? now_s);
    bench.old = oldTopics(this.heard, this.rates, now_s);
    if (bench.connection !== 'live') bench.simAge_s = Math.max(bench.simAge_s, bench.waiting_s);
    this.growOld(now_s);
    if (!this.socket && now_s >= this.retryAt_s) this.connect();
    this.acknowledge();
  }

  /** Ages go on while nothing comes. */
  private growOld(now_s: number): void {
    if (now_s - (this.heard.get('vehicle') ?? now_s) < kStale_s) return;
    this.bench.growOld(now_s - this.agedTo_s);
    this.agedTo_s = now_s;
  }

  /** After a frame was drawn; a page in the background asks for one a second. */
  private acknowledge(): void {
    if (this.acks.size === 0) return;
    const send = () => {
      this.ackTimer = undefined;
      for (const [topic, seq] of this.acks) this.send({jsonrpc: '2.0', method: 'ack', params: {topic, seq}});
      this.acks.clear();
    };
    if (!document.hidden) send();
    else this.ackTimer ??= setTimeout(send, kHidden_ms);
  }

  private send(frame: object): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(frame));
  }

  call(method: string, params: object = {}): Promise<unknown> {
    return new Promise((resolve, reject) => {
      if (this.socket?.readyState !== WebSocket.OPEN) {
        reject(new Error('the page has no connection to casweb'));
        return;
      }
      const id = this.nextId++;
      this.answers.set(id, {resolve, reject});
      this.send({jsonrpc: '2.0', id, method, params});
    });
  }

  private onFrame(frame: Frame): void {
    if (frame.id !== undefined) {
      const answer = this.answers.get(frame.id);
      this.answers.delete(frame.id);
      if (frame.error) answer?.reject(new Error(frame.error.message));
      else answer?.resolve(frame.result);
      return;
    }
    if (!frame.method) return;
    if (frame.method.startsWith('snap.')) {
      this.heard.set(frame.method.slice(5), clock_s());
      if (frame.params?.seq !== undefined) this.acks.set(frame.method.slice(5), frame.params.seq);
      // No frame is drawn in a hidden tab: acknowledge from here.
      if (document.hidden) this.acknowledge();
    }
    this.bench.apply(frame.method, frame.params);
    this.keep(frame.method, frame.params);
    if (frame.method === 'event.scene' || (frame.method === 'event.program')) void this.refresh();
  }

  private push(vehicle: number, key: string, t: number, v: number, unit?: string): void {
    const name = `${vehicle}|${key}`;
    let ring = this.rings.get(name);
    if (!ring) this.rings.set(name, (ring = new Ring(unit)));
    ring.push(t, v);
  }

  /** Puts samples of plots into rings. */
  private keep(method: string, params: unknown): void {
    if (method === 'snap.sim') {
      this.heardSim_s = clock_s();
      this.keepSim(params as SnapSim);
    } else if (method === 'snap.vehicle') {
      this.agedTo_s = clock_s();
      this.keepEstimates();
    } else if (method === 'snap.loop') {
      const t = this.bench.time_s ?? this.now_s;
      this.bench.vehicles.forEach((vehicle, i) => {
        const loop = this.bench.loopOf(vehicle);
        if (!loop) return;
        this.push(i, 'loop.p50', t, loop.ms.p50);
        this.push(i, 'loop.p99', t, loop.ms.p99);
      });
    } else if (method === 'snap.value') {
      this.keepValues(params as {series: {key: string; samples: (number | string | null)[][]}[]});
    }
  }

  private keepSim(snap: SnapSim): void {
    const t = snap.t_s;
    snap.v.forEach((sim, i) => {
      const rpy = rpyOf(sim.q);
      const values: Record<string, number> = {
        'truth.n': sim.p[1], 'truth.e': sim.p[0], 'truth.u': sim.p[2], 'truth.roll': rpy.roll * kDegrees, 'truth.pitch': rpy.pitch * kDegrees,
        'truth.yaw': rpy.yaw * kDegrees, 'truth.p': sim.w[0] * kDegrees, 'truth.q': -sim.w[1] * kDegrees, 'truth.r': -sim.w[2] * kDegrees,
      };
      sim.rotors.forEach((omega, k) => { values[`rotor.${k + 1}`] = omega; });
      const reference = this.bench.vehicles[i]?.reference;
      if (reference) {
        const [e, n, u] = reference.p_W;
        Object.assign(values, {'ref.n': n, 'ref.e': e, 'ref.u': u, 'error.m': Math.hypot(sim.p[0] - e, sim.p[1] - n, sim.p[2] - u)});
      }
      for (const [key, value] of Object.entries(values)) this.push(i, key, t, value);
    });
  }

  private keepEstimates(): void {
    const {bench} = this;
    bench.vehicles.forEach((vehicle, i) => {
      const estimate = bench.estimate(vehicle);
      if (!estimate || estimate.age_s > 0.3) return;
      const t = bench.time_s ?? this.now_s;
      this.push(i, 'est.n', t, estimate.p[1]);
      this.push(i, 'est.e', t, estimate.p[0]);
      this.push(i, 'est.u', t, estimate.p[2]);
    });
  }

  private keepValues(snap: {series: {key: string; samples: (number | string | null)[][]}[]}): void {
    for (const {key, samples} of snap.series) {
      const watched = this.watched.get(key);
      if (!watched) continue;
      for (const sample of samples) {
        watched.fields.forEach((field, i) => {
          const value = sample[i + 1];
          const name = `${watched.message}.${field}`;
          if (typeof value === 'number') this.push(this.bench.selected, name, sample[0] as number, value, this.units.get(name));
        });
      }
    }
  }

  series(vehicle: number, key: string): Series | undefined {
    return this.rings.get(`${vehicle}|${key}`);
  }

  /** Fields of a message that was opened. */
  fields(message: string): string[] {
    return this.known.get(message) ?? [];
  }

  /** Watches the fields of one message, and of none before it. */
  open(message: string | null, link?: string, system?: number, component?: number): void {
    this.opened = [message, link, system, component];
    void this.openFields(message, link, system, component).catch(() => undefined);
  }

  private async openFields(message: string | null, link?: string, system?: number, component?: number): Promise<void> {
    for (const key of this.watched.keys()) await this.call('message.unwatch', {key}).catch(() => undefined);
    this.watched.clear();
    if (!message) return;
    const listed = this.bench.messages.find((each) => each.name === message && each.direction === 'rx');
    const from = {link: link ?? listed?.link, message, system: system ?? listed?.system, component: component ?? listed?.component};
    if (from.link === undefined) return;
    const answer = (await this.call('message.value', from)) as {fields: {name: string; value: unknown; units?: string}[] | null};
    const fields = (answer.fields ?? []).filter((field) => typeof field.value === 'number' && !field.name.startsWith('time_')).slice(0, kMostFields);
    this.known.set(message, fields.map((field) => field.name));
    for (const field of fields) if (field.units) this.units.set(`${message}.${field.name}`, field.units);
    if (fields.length === 0) return;
    const names = fields.map((field) => field.name);
    const {key} = (await this.call('message.watch', {...from, fields: names, hz: 10})) as {key: string};
    this.watched.set(key, {message, fields: names});
  }
}
