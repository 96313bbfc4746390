// SPDX-License-Identifier: BSD-3-Clause
// The page against a casweb that is a few lines: docs/develop/web_protocol.md, spoken by the test.
import assert from 'node:assert/strict';
import {readdirSync, readFileSync} from 'node:fs';
import {extname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {gunzipSync} from 'node:zlib';
import type {Browser, Page, WebSocketRoute} from 'playwright-core';
import {complaints, launch, scene, until} from './chromium.ts';
import {makeRecord, placeAt} from './fixture.ts';
import {tokenProof, type ProofContext} from '../src/proof.ts';

const kAddress = 'http://127.0.0.1:5791';
const kPolicy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'none'; connect-src 'self'; " +
  "worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

let browser: Browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

const kHome = {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488};
/** How far north in W the vehicle's N begins. */
const kNorth_m = 3;
const kHomeOfVehicle = {...kHome, lat_deg: kHome.lat_deg + kNorth_m / ((Math.PI / 180) * 6_371_000), x_m: 0, y_m: 0, z_m: 0};

interface Call {
  method: string;
  params: Record<string, unknown>;
}

/** A casweb that answers, and remembers its requests. */
class FakeServer {
  calls: Call[] = [];
  acks: {topic: string; seq: number}[] = [];
  readOnly = false;
  gain = 0.6;  // MPC_XY_P
  refuses = new Map<string, string>();
  landed = 'on_ground';
  armed = false;
  hil = true;
  /** HIL packets by casd, by cause. */
  dropped: Record<string, number> = {};
  /** Else another program that took the port. */
  isCasweb = true;
  /** A run of hils is flown. */
  run?: object;
  /** Programs that are not there. */
  readonly down = new Set<string>();
  private nonces?: ProofContext;
  private socket?: WebSocketRoute;
  private seq = 0;
  private time_s = 10;

  async serve(page: Page): Promise<void> {
    await page.route(`${kAddress}/**`, (route) => {
      const path = new URL(route.request().url()).pathname;
      const file = join(process.env.CAS_PAGE!, path === '/' ? 'index.html' : path);
      const types: Record<string, string> = {'.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css'};
      return route.fulfill({body: readFileSync(file), contentType: types[extname(file)] ?? 'text/plain', headers: {'Content-Security-Policy': kPolicy}});
    });
    await page.routeWebSocket(`${kAddress.replace('http', 'ws')}/rpc`, (socket) => {
      this.socket = socket;
      socket.onMessage((text) => this.onMessage(JSON.parse(String(text)) as {id?: number; method: string; params: Record<string, unknown>}));
    });
  }

  private onMessage({id, method, params}: {id?: number; method: string; params: Record<string, unknown>}): void {
    if (method === 'ack') {
      this.acks.push(params as {topic: string; seq: number});
      this.feed(params.topic as string);
      return;
    }
    this.calls.push({method, params});
    if (method === 'hello' && params.nonce) {
      this.nonces = {place: new URL(kAddress).host, pageNonce: params.nonce as string, serverNonce: `nonce ${this.calls.length}`};
      const proof = tokenProof('secret-token', 'server', this.nonces);
      this.socket!.send(JSON.stringify({jsonrpc: '2.0', id, result: {nonce: this.nonces.serverNonce, proof: this.isCasweb ? proof : 'made up'}}));
      return;
    }
    if (method === 'hello' && params.proof !== tokenProof('secret-token', 'client', this.nonces!)) {
      this.socket!.send(JSON.stringify({jsonrpc: '2.0', id, error: {code: -32003, message: 'wrong token'}}));
      void this.socket!.close({code: 4403});
      return;
    }
    const refusal = method.startsWith('sim.') && this.down.has('hilsim') ? 'there is no hilsim' : this.refuses.get(method);
    const answer = refusal ? {error: {code: -32000, message: refusal}} : {result: this.answer(method, params)};
    this.socket!.send(JSON.stringify({jsonrpc: '2.0', id, ...answer}));
    if (method === 'watch') for (const topic of ['sim', 'clouds', 'vehicle', 'links', 'messages', ...(this.run ? ['ref', 'verdict'] : [])]) this.feed(topic);
  }

  private answer(method: string, params: Record<string, unknown>): unknown {
    const record = makeRecord();
    switch (method) {
      case 'hello': return {
        protocol: 2, casweb: '0.1.0', read_only: this.readOnly, source: 'live', casd: '0.1.0', hilsim: '0.1.0', clock: {sim_s: 10, rate: 1, paused: false},
        topics: {sim: 60, clouds: 5, links: 2, loop: 1, messages: 1, value: 10, vehicle: 10, ...(this.run ? {ref: 20, verdict: 2} : {})},
        methods: this.readOnly ? ['ack', 'watch'] : ['ack', 'watch', 'vehicle.hold', 'vehicle.arm', ...(this.run ? ['fault.inject'] : [])],
      };
      case 'sim.scene': return {hash: 'a', frame: 'W', home: kHome, vehicles: [{type: 'iris_paper', ...record.vehicles[0]!.scene, name: 'iris0', system: 1}], obstacles: [], world: [{shape: 'plane', p: [0, 0, 0], q: [1, 0, 0, 0]}, {shape: 'box', size_m: [1, 2, 3], p: [5, 5, 1.5], q: [1, 0, 0, 0]}]};
      case 'bench.status': return {programs: ['hilsim', 'casd'].map((name) => this.down.has(name)
        ? {name, state: 'down', reason: `there is no ${name} on this machine`} : {name, state: 'up', version: '0.1.0', age_s: 0.1})};
      case 'fault.list': return {kinds: ['drop', 'rotor', 'unplug', 'gust'], shortest_s: 0.05, longest_s: 30};
      case 'gain.list': return {loops: [{loop: 'position', parameters: {p: 'MPC_XY_P'}}]};
      case 'gain.get': return {loop: 'position', p: this.gain};
      case 'gain.set': {
        const before = {p: this.gain};
        this.gain = params.p as number;
        return {loop: 'position', p: this.gain, before};
      }
      default: return {result: 'ACCEPTED'};
    }
  }

  /** The next snapshot of a topic. */
  feed(topic: string): void {
    if (this.down.has(topic === 'sim' ? 'hilsim' : 'casd')) return;
    this.time_s += topic === 'sim' ? 0.05 : 0;
    const [n, e, u] = placeAt(this.time_s);
    const snaps: Record<string, object> = {
      sim: {t_s: this.time_s, rate: 1, paused: false, v: [{p: [e, n, u], q: [0.7071, 0, 0, 0.7071], vel: [0, 0, 0], w: [0, 0, 0], rotors: [800, 800, 800, 800]}], wind_W: [3, 1, 0]},
      vehicle: {vehicles: [{state: {
        system: 1, autopilot: 'PX4', armed: this.armed, hil: this.hil, mode: 'HOLD', landed: this.landed, heartbeat_age_s: 0.2, link: 'fcu',
        attitude: {roll_rad: 0, pitch_rad: 0, yaw_rad: 0, age_s: 0.02}, position_N: {x_m: n - kNorth_m, y_m: e, z_m: -u, vx_m_s: 0, vy_m_s: 0, vz_m_s: 0, age_s: 0.02}, home: kHomeOfVehicle,
      }, telemetry: {}}]},
      links: {hops: [
        {from: 'sim', to: 'casd', link: 'sim1', system: 1, type: 'udp', state: 'up', msgs: {HIL_SENSOR: 500, HIL_GPS: 5}, lost: 0, measured: 'none'},
        {from: 'casd', to: 'fcu', link: 'fcu1', system: 1, type: 'serial', state: 'up', baud: 921600, full: 0.4, queued: 0, high_water: 12, msgs: {HIL_SENSOR: 500, HIL_GPS: 5}, dropped: this.dropped, measured: 'none'},
        {from: 'fcu', to: 'casd', link: 'fcu1', system: 1, type: 'serial', state: 'up', full: 0.28, msgs: {HIL_CONTROLS: 400, HEARTBEAT: 1}, lost: 0, measured: 'none'},
        {from: 'casd', to: 'sim', link: 'sim1', system: 1, type: 'udp', state: 'up', msgs: {HIL_CONTROLS: 400}, measured: 'none'},
      ], forward_us: [{from: 'sim', to: 'fcu', from_link: 'sim1', to_link: 'fcu1', system: 1, count: 1, p50: 28, p99: 132}]},
      ref: {t_s: this.time_s - 0.1, v: [{p_W: [e, n + 0.2, u], v_W: [0, 1, 0], yaw_rad: 0}]},
      clouds: {t_s: this.time_s, v: [[e, n + 2, u, e, n, 0]]},
      verdict: this.run ?? {},
      messages: {messages: [{link: 'fcu', direction: 'rx', id: 0, name: 'HEARTBEAT', system: 1, component: 1, count: 9, hz: 1, age_s: 0.3}]},
    };
    this.say(`snap.${topic}`, {seq: ++this.seq, ...snaps[topic]});
  }

  say(method: string, params: object): void {
    this.socket?.send(JSON.stringify({jsonrpc: '2.0', method, params}));
  }
  /** A program ends. */
  end(name: string): void {
    this.down.add(name);
    this.say('event.program', {seq: ++this.seq, name, state: 'down', reason: 'it ended'});
  }
  cut(): void {
    void this.socket?.close({code: 1001});
  }
}

async function open(server: FakeServer, width = 1280, prepare?: () => void): Promise<{page: Page; errors: string[]}> {
  const page = await browser.newPage({viewport: {width, height: 800}, colorScheme: 'dark'});
  const errors = complaints(page);
  if (prepare) await page.addInitScript(prepare);
  await server.serve(page);
  await page.goto(`${kAddress}/#k=secret-token`);
  await until(page, 'the bench is live', (now) => now.connection === 'live' && now.drawn === 'truth');
  return {page, errors};
}

test('a live bench is shown, each snapshot acknowledged, and the token leaves the address', async () => {
  const server = new FakeServer();
  const {page, errors} = await open(server);
  const before = (await scene(page)).time_s!;
  await until(page, 'it goes on', (now) => now.time_s! > before + 0.5 && now.frames > 0);
  assert.equal(server.calls[0]!.method, 'hello');
  assert.ok(!JSON.stringify(server.calls).includes('secret-token'), 'the token is told to nobody');
  assert.ok(!page.url().includes('secret'), page.url());
  assert.ok(server.acks.some((ack) => ack.topic === 'sim') && server.acks.some((ack) => ack.topic === 'links'));
  await page.getByText('delay not measured').first().waitFor({state: 'attached'});
  server.say('event.statustext', {vehicle: 1, severity: 'warning', text: '<img src=x onerror=alert(1)>'});
  server.say('event.unknown', {what: 1});
  await page.getByRole('tab', {name: 'Log'}).first().click();
  await page.getByText('<img src=x').first().waitFor();
  assert.deepEqual(errors, []);
  await page.close();
});

test('arming asks, holding does not, and a refusal stands in the vehicle\'s own words', async () => {
  const server = new FakeServer();
  server.refuses.set('vehicle.arm', 'Preflight Fail: heading estimate invalid');
  const {page} = await open(server);
  const asked = (method: string) => server.calls.filter((call) => call.method === method).length;
  await page.getByRole('button', {name: /^Arm/}).click();
  assert.equal((await scene(page)).question, 'Arm vehicle 1?');
  assert.equal(asked('vehicle.arm'), 0, 'only asked');
  await page.keyboard.press('Escape');
  await until(page, 'the question is gone', (now) => now.question === undefined);
  await page.keyboard.press('a');
  await until(page, 'it asks by key, too', (now) => now.question === 'Arm vehicle 1?');
  await page.getByRole('button', {name: /^Arm/}).click();
  await until(page, 'it is refused', (now) => now.refusal.includes('heading estimate'));
  assert.equal(asked('vehicle.arm'), 1);
  await page.getByText('Preflight Fail: heading estimate invalid').waitFor();
  await page.keyboard.press('h');
  await until(page, 'hold is done at once', () => asked('vehicle.hold') === 1);
  await page.keyboard.down('l');
  await until(page, 'land, too', () => asked('vehicle.land') === 1);
  for (let i = 0; i < 5; ++i) await page.keyboard.down('l');  // repeats
  await page.keyboard.up('l');
  assert.equal(asked('vehicle.land'), 1, 'a held key commands once');
  await page.close();
});

test('a click on the ground is a place to go to, once it was answered', async () => {
  const server = new FakeServer();
  server.armed = true;
  server.landed = 'in_air';
  const {page} = await open(server);
  await until(page, 'a picture', (now) => now.frames > 0);
  await page.keyboard.press('g');
  const box = (await page.locator('canvas.gl').boundingBox())!;
  await page.mouse.click(box.x + box.width / 2, box.y + box.height * 0.8);
  const now = await until(page, 'it asks', (now) => /^Go to .* north, .* east, .* up\?$/.test(now.question ?? ''));
  await page.keyboard.press('Enter');
  await until(page, 'it goes', () => server.calls.some((call) => call.method === 'vehicle.goto'));
  const {params} = server.calls.find((call) => call.method === 'vehicle.goto')!;
  const north_m = Number(/^Go to (\S+) north/.exec(now.question!)![1]!.replace('−', '-'));
  assert.ok(Math.abs((params.north_m as number) - (north_m - kNorth_m)) < 0.06, `${JSON.stringify(params)} for ${now.question}`);
  assert.ok((params.down_m as number) < 0);
  await page.close();
});

test('gains are set after a question and undone', async () => {
  const server = new FakeServer();
  const {page} = await open(server);
  await page.getByRole('tab', {name: 'Gains'}).first().click();
  await page.getByLabel('New P').fill('abc');
  await page.getByRole('button', {name: 'Apply'}).click();
  await page.getByText('P: "abc" is no number.').waitFor();
  await page.getByLabel('New P').fill('0.9');
  await page.getByRole('button', {name: 'Apply'}).click();
  await until(page, 'it asks', (now) => now.question === 'Set position P 0.9?');
  await page.keyboard.press('Enter');
  await until(page, 'it is set', () => server.calls.some((call) => call.method === 'gain.set' && call.params.p === 0.9));
  await page.getByRole('button', {name: 'Undo'}).click();
  await until(page, 'it asks', (now) => now.question === 'Set position P 0.6?');
  await page.keyboard.press('Enter');
  await until(page, 'it is set back', () => server.calls.some((call) => call.method === 'gain.set' && call.params.p === 0.6));
  server.gain = 1.3;  // by somebody else
  await page.getByText('1.300 →').waitFor();
  assert.ok(await page.getByRole('button', {name: 'Undo'}).isDisabled());
  await page.close();
});

test('a lost server is told at once, nothing looks live, and the page comes back', async () => {
  const server = new FakeServer();
  const {page} = await open(server);
  server.cut();
  await until(page, 'it says lost', (now) => now.connection === 'lost');
  await page.getByText('nothing can be commanded').waitFor();
  await until(page, 'it is back', (now) => now.connection === 'live');
  assert.ok(server.calls.filter((call) => call.method === 'hello').length >= 2);
  await page.close();
});

/** As hils tells it. */
const kRun = {
  name: 'hover', seed: 3, state: 'running', sentences: [], touched: [], stages: [{name: 'hold', begin_s: 9, end_s: 11, measured: true}],
  vehicles: [{name: 'iris0', system: 1, checks: [
    {what: 'RMS error of the true position, x_m', validity: false, value: 0.1, bound: 0.5, margin: 0.4, least: false, unit: 'm', digits: 4, found: '', wanted: '', judged: true, kept: true},
    {what: 'HIL_SENSOR lost', validity: false, value: null, bound: 0, margin: null, least: false, unit: '', digits: 0, found: 'not known yet', wanted: '', judged: true, kept: true},
  ]}],
};

test('a run shows its reference, its limits so far, faults by hand and the verdict', async () => {
  const server = new FakeServer();
  server.run = kRun;
  server.landed = 'in_air';
  server.armed = true;
  const {page, errors} = await open(server);
  const now = await until(page, 'the reference is there', (each) => each.reference !== undefined && each.verdict === 'running');
  assert.ok(Math.abs(now.reference!.p_W[1] - now.vehicles[0]!.p![1] - 0.3) < 0.02, 'in the moment of the picture: 0.2 m and 0.1 s at 1 m/s');
  await page.getByText('0.10 of 0.5 m · 80 %').waitFor();
  await page.getByText('measured at the end; limit 0').waitFor();
  const cut = await page.locator('cas-faults button, cas-commands button').evaluateAll((all) => all.filter((each) => each.scrollWidth > each.clientWidth).map((each) => each.textContent));
  assert.deepEqual(cut, []);
  assert.equal(await page.getByText('touched', {exact: true}).count(), 0);
  await page.getByRole('button', {name: 'No GPS'}).click();
  assert.equal((await scene(page)).question, 'Take the GPS from vehicle 1 for 1 s?');
  await page.keyboard.press('Enter');
  await until(page, 'the fault is asked for', () => server.calls.some((call) => call.method === 'fault.inject'));
  assert.deepEqual(server.calls.find((call) => call.method === 'fault.inject')!.params, {vehicle: 1, name: 'No GPS', drop: 'gps', for_s: 1});
  server.say('event.fault', {seq: 1, name: 'No GPS', vehicle: 1, began_s: 1e6, ended_s: 1e6 + 1});
  server.run = {...kRun, touched: [{by: 'the page (unix:uid 0)', what: 'fault.inject'}]};
  server.feed('verdict');
  await page.getByText('touched', {exact: true}).waitFor();
  server.run = {...server.run, state: 'passed', out: '/out/hover'};
  server.say('event.verdict', server.run);
  await until(page, 'it is judged', (each) => each.verdict === 'passed' && each.faults.includes('No GPS'));
  assert.deepEqual(errors, []);
  server.cut();  // casweb ends with the run
  await page.getByText('Run over').waitFor();
  await page.getByText('/out/hover/replay.html').waitFor();
  assert.equal(await page.getByText('Page lost').count(), 0);
  await page.close();
});

test('a gamepad flies the vehicle once it was answered, and is let go of', async () => {
  const server = new FakeServer();
  const {page, errors} = await open(server, 1280, () => {
    const pad = {index: 1, mapping: 'standard', connected: true, axes: [0.5, -1, 0, 0], buttons: []};
    Object.defineProperty(navigator, 'getGamepads', {value: () => [null, pad]});
  });
  const sent = () => server.calls.filter((call) => call.method === 'vehicle.manual_control');
  await page.getByRole('button', {name: 'Sticks'}).click();
  assert.equal((await scene(page)).question, 'Fly vehicle 1 by the gamepad?');
  await page.getByRole('button', {name: /^Fly/}).click();
  await until(page, 'sticks are sent', () => sent().length > 3);
  assert.deepEqual(sent()[0]!.params, {vehicle: 1, yaw: 0.5, throttle: 1, roll: 0, pitch: 0});
  await page.getByRole('button', {name: 'Let go of the sticks'}).click();
  await page.getByText('The sticks were let go.').waitFor();
  assert.deepEqual(errors, []);
  await page.close();
});

test('a program that took the port of casweb learns nothing', async () => {
  const server = new FakeServer();
  server.isCasweb = false;
  const page = await browser.newPage();
  await server.serve(page);
  await page.goto(`${kAddress}/#k=secret-token`);
  await page.getByText('casweb does not know this token').waitFor();
  assert.ok(server.calls.every((call) => call.method === 'hello' && !call.params.proof && !call.params.token), JSON.stringify(server.calls));
  assert.equal(await page.evaluate(() => sessionStorage.getItem('token')), null, 'the page forgets a token that this program could read');
  await page.close();
});

test('a scene that is built anew compiles no shader again', async () => {
  const server = new FakeServer();
  const {page} = await open(server);
  // The first drawing may come with later packets: a slow machine has compiled all after some pictures alike.
  let alike = {programs: '', since: 0};
  let before = await until(page, 'pictures with the same shaders', (now) => {
    const programs = (now.programs3d ?? []).join();
    if (programs !== alike.programs) alike = {programs, since: now.frames};
    return programs !== '' && now.frames > alike.since + 30;
  });
  // A busy machine may draw something late or for a moment, which has a shader of its own; a fault compiles with every scene.
  let changed: number[] = [];
  for (let scene = 0; scene < 3; ++scene) {
    await page.keyboard.press('Shift+T');
    const after = await until(page, 'a picture in other colours', (now) => now.theme !== before.theme && now.frames > before.frames + 2);
    const [gone, anew] = [[before, after], [after, before]].map(([of, without]) => of!.programs3d!.filter((id) => !without!.programs3d!.includes(id)));
    changed = [...gone!, ...anew!];
    if (changed.length === 0) break;
    before = after;
  }
  assert.deepEqual(changed, []);
  await page.close();
});

test('view only has no commands, and a vehicle out of HIL is not commanded', async () => {
  const server = new FakeServer();
  server.readOnly = true;
  const {page} = await open(server, 400);
  await page.getByText('View only.').waitFor();
  assert.equal(await page.getByRole('button', {name: /^Arm/}).count(), 0);
  const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wider <= 0, `${wider} px too wide`);
  await page.close();
  const other = new FakeServer();
  other.hil = false;
  const second = await open(other);
  await second.page.getByText('does not say that it is in HIL').waitFor();
  assert.equal(await second.page.getByRole('button', {name: /^Arm/}).count(), 0);
  await second.page.close();
});

test('after acts by hand the confirmation, Land, Hold and Disarm are in view', async () => {
  const server = new FakeServer();
  const what = 'vehicle.goto {"down_m":-2.501032590866089,"east_m":0.00310123,"north_m":3.0,"vehicle":1}';
  const check = (name: string) => ({...kRun.vehicles[0]!.checks[0]!, what: name});
  server.run = {...kRun, touched: Array.from({length: 9}, () => ({by: 'the page (unix:uid 0)', what})),
    vehicles: [{name: 'iris0', system: 1, checks: Array.from({length: 12}, (_, i) => check(`a limit with a long name, number ${i}`))}]};
  server.landed = 'in_air';
  server.armed = true;
  const {page} = await open(server);
  await page.getByText('Touched: go to 3.0 m north, 2.5 m up').waitFor();
  await page.keyboard.press('t');
  await until(page, 'it asks', (now) => now.question !== undefined);
  const fly = (await page.locator('.fly').boundingBox())!;
  for (const name of [/^Land/, /^Hold/, /^Disarm/, /^Take off/]) {
    const box = (await page.getByRole('button', {name}).boundingBox())!;
    assert.ok(box.y >= fly.y && box.y + box.height <= fly.y + fly.height, `${name} is out of view`);
  }
  assert.match(await page.evaluate(() => document.activeElement!.textContent!), /^Take off/);
  assert.equal(await page.evaluate(() => document.querySelector('.fly')!.scrollWidth - document.querySelector('.fly')!.clientWidth), 0);
  await page.close();
});

test('packets that casd drops stand beside those that were lost', async () => {
  const server = new FakeServer();
  server.dropped = {age: 528, closed: 1};
  const {page} = await open(server);
  await page.getByText(/ · 529 dropped$/).waitFor({state: 'attached'});
  server.say('snap.loop', {seq: 1, measured: 'echo', vehicles: [{system: 1, ms: {p50: 1.6, p99: 4}, count: 400}]});
  await page.getByText('lost 0 · casd dropped 529').waitFor({state: 'attached'});
  await page.close();
});

test('a program that ends takes what it told with it', async () => {
  const server = new FakeServer();
  const {page} = await open(server);
  await page.getByRole('button', {name: /^Hold/}).waitFor();
  server.end('hilsim');
  await until(page, 'the estimate is left', (now) => now.drawn === 'estimate');
  server.end('casd');
  await page.getByText('casd is down: nothing can be commanded.').waitFor();
  assert.equal(await page.getByRole('button', {name: /^Hold/}).count(), 0);
  await page.getByText(/^links: .* old$/).waitFor();
  await page.close();
});

test('a new address in the same tab is taken', async () => {
  const server = new FakeServer();
  const page = await browser.newPage();
  await server.serve(page);
  await page.goto(`${kAddress}/#k=of-yesterday`);
  const fault = page.getByText('casweb does not know this token');
  await fault.waitFor();
  await page.goto(`${kAddress}/#k=secret-token`);
  await until(page, 'the bench is live', (now) => now.connection === 'live');
  await fault.waitFor({state: 'detached'});
  assert.ok(!page.url().includes('secret'), page.url());
  await page.close();
});

test('each asset lies compressed beside itself', () => {
  const folder = join(process.env.CAS_PAGE!, 'assets');
  const names = readdirSync(folder).filter((name) => !name.endsWith('.gz'));
  assert.ok(names.length >= 3);
  for (const name of names) assert.deepEqual(gunzipSync(readFileSync(join(folder, `${name}.gz`))), readFileSync(join(folder, name)), name);
});
