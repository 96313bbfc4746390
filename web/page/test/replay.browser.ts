// SPDX-License-Identifier: BSD-3-Clause
// replay.html from file:// in a real browser; asserts on the page's own report, never on pixels.
import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {pathToFileURL} from 'node:url';
import type {Browser, Page} from 'playwright-core';
import {complaints, launch, launchFlat, scene, until} from './chromium.ts';
import {column, kDuration_s, makeRecord, pack} from './fixture.ts';

let browser: Browser;
const folder = mkdtempSync(join(tmpdir(), 'cas-page-'));
before(async () => { browser = await launch(); });
after(async () => {
  await browser.close();
  rmSync(folder, {recursive: true, force: true});
});

/** A replay with these blocks; answers its address. */
function replay(name: string, blocks: string[], sources: object[] = []): string {
  const html = readFileSync(join(process.env.CAS_PAGE!, 'replay.html'), 'utf8');
  const source = (i: number) => (sources[i] ? ` data-source="${btoa(JSON.stringify(sources[i]))}"` : '');
  const records = blocks.map((block, i) => `<script type="application/octet-stream" class="record"${source(i)}>${block}</script>`).join('\n');
  const file = join(folder, `${name}.html`);
  writeFileSync(file, html.replace('<!--RECORDS-->', () => records));
  return pathToFileURL(file).href;
}

async function open(address: string, width = 1280, height = 800, dark = true): Promise<{page: Page; errors: string[]}> {
  const page = await browser.newPage({viewport: {width, height}, colorScheme: dark ? 'dark' : 'light'});
  const errors = complaints(page);
  await page.goto(address);
  return {page, errors};
}

test('a replay opens from a file, plays, and complains of nothing', async () => {
  const {page, errors} = await open(replay('one', [pack(makeRecord())]));
  const first = await until(page, 'a picture', (now) => now.frames > 0);
  assert.equal(first.connection, 'record');
  assert.equal(first.time_s, 8, 'at the measured stage');
  assert.equal(first.drawn, 'truth');
  assert.equal(first.verdict, 'failed');
  assert.ok(first.tags.includes('est') || first.tags.includes('ref'));
  await page.getByRole('button', {name: 'Play', exact: true}).click();
  await until(page, 'time goes on', (now) => now.time_s! > 8.2 && now.playing === true);
  await page.keyboard.press('Space');
  await until(page, 'it stands', (now) => now.playing === false);
  await page.keyboard.press('=');
  assert.equal((await scene(page)).speed, 2);
  await page.keyboard.press('Home');
  assert.equal((await scene(page)).time_s, 0);
  await page.keyboard.press('n');
  await until(page, 'the next event is arming', (now) => now.time_s === 2);
  await page.keyboard.press('n');
  await until(page, 'then the gust', (now) => now.time_s === 18);
  for (const [key, camera] of [['2', 'follow'], ['3', 'chase'], ['4', 'top'], ['1', 'orbit']] as const) {
    await page.keyboard.press(key);
    assert.equal((await scene(page)).camera, camera);
  }
  assert.deepEqual(errors, []);
  await page.close();
});

test('the timeline scrubs, the log jumps, and a plot takes a field', async () => {
  const {page, errors} = await open(replay('scrub', [pack(makeRecord())]));
  await until(page, 'a picture', (now) => now.frames > 0);
  const slider = page.getByRole('slider', {name: 'Time in the record'});
  const box = (await slider.boundingBox())!;
  await page.mouse.click(box.x + 14 + (box.width - 28) / 2, box.y + 40);
  const middle = (await scene(page)).time_s!;
  assert.ok(Math.abs(middle - kDuration_s / 2) < 0.2, `${middle}`);
  await page.getByRole('tab', {name: 'Log'}).first().click();
  await page.getByRole('button', {name: /GPS.* is weak/}).first().click();
  assert.equal((await scene(page)).time_s, 26);
  assert.equal(await page.locator('.log b').count(), 0, 'text from the wire is no HTML');
  await page.getByRole('tab', {name: 'Messages'}).first().click();
  await page.getByRole('button', {name: 'Plot LOCAL_POSITION_NED.x'}).first().click();
  await page.getByRole('tab', {name: 'Plots'}).first().click();
  await page.locator('[aria-label="LOCAL_POSITION_NED.x"] canvas').first().waitFor();
  assert.deepEqual(errors, []);
  await page.close();
});

test('the loss is told: hop, tape and limits', async () => {
  const {page} = await open(replay('loss', [pack(makeRecord())]));
  await until(page, 'a picture', (now) => now.frames > 0);
  await page.keyboard.press('Home');
  for (let i = 0; i < 4; ++i) await page.keyboard.press('n');  // arming, gust, its end, loss
  const now = await until(page, 'at the loss', (scene) => scene.time_s === 24);
  assert.equal(now.links!.find((hop) => hop.to === 'fcu')!.lost, 7);
  await page.keyboard.press('ArrowRight');
  await until(page, 'the tape around it', (scene) => scene.tape === 'loss');
  await page.getByText('7 of 20000 HIL_SENSOR were lost').waitFor();
  await page.close();
});

test('a failed flight opens before its failure, in its world, with the step that was not done', async () => {
  const record = makeRecord('crash');
  const bytes = new ArrayBuffer(8 + 36 + 12);
  new Uint32Array(bytes, 0, 2).set([3, 1]);
  new Float32Array(bytes, 8, 9).set([0, 0, 0, 1, 0, 0, 0, 0, 2]);
  new Uint32Array(bytes, 44, 3).set([0, 1, 2]);
  record.world = {
    parts: [{name: 'wall', shape: 'box', size_m: [1, 4, 3], p: [3, 0, 1.5], q: [1, 0, 0, 0]}, {name: 'tree', shape: 'mesh', mesh: '0', p: [0, 5, 0], q: [1, 0, 0, 0]}],
    meshes: [Buffer.from(bytes).toString('base64')],
  };
  const vehicle = record.vehicles[0]!;
  // A scan of two returns at 16.5 s, one of a single return at 17.5 s: each is shown for a second.
  vehicle.clouds = {t: column([16.5, 16.5, 17.5], 0.001), e: column([1, 2, 3], 0.01), n: column([0, 0, 1], 0.01), u: column([1, 1, 2], 0.01)};
  vehicle.events = [...(vehicle.events ?? []), {t_s: 20, kind: 'incident', text: "the vehicle hit 'wall' at 4.0 m/s"}];
  vehicle.stages!.at(-1)!.finished = false;
  const {page, errors} = await open(replay('crash', [pack(record)]));
  const now = await until(page, 'box and mesh of the world', (scene) => scene.frames > 0 && scene.worldParts === 2);
  assert.equal(now.time_s, 17);
  await until(page, 'the returns of the lidar', (scene) => scene.returns === 2);
  await page.getByText('lidar', {exact: true}).waitFor();
  await page.keyboard.press('ArrowRight');
  await until(page, 'the next scan alone', (scene) => scene.time_s === 18 && scene.returns === 1);
  await page.keyboard.press('ArrowRight');
  await until(page, 'no old scan', (scene) => scene.time_s === 19 && scene.returns === 0);
  await page.getByText('not done').first().waitFor({state: 'attached'});
  assert.deepEqual(errors, []);
  await page.close();
});

test('two runs lie over each other, the first on the left', async () => {
  const calm = makeRecord('wind');
  calm.verdict = {valid: true, passed: true, failures: []};
  const other = makeRecord('wind', 3);
  other.vehicles[0]!.checks![0]!.value = 0.3;
  const source = (path: string, mean: string) => ({path, settings: {'hilsim.plugins[wind].mean_m_s': mean}});
  const {page, errors} = await open(replay('two', [pack(calm), pack(other)], [source('out/calm', '3'), source('out/gusty', '9')]));
  await until(page, 'a picture', (now) => now.frames > 0);
  await page.getByText('A · B').waitFor();
  await page.getByText('truth B').first().waitFor();
  assert.match(await page.locator('.lim').first().innerText(), /0\.09 · 0\.30 of 0\.5 m/);
  const header = (await page.locator('header.top').innerText()).replace(/\s+/g, ' ');
  assert.match(header, /A calm wind mean_m_s 3 B gusty wind mean_m_s 9/);
  assert.match(header, /A: Passed, .* B: Failed/, 'neither verdict hides the other');
  await page.getByText('B: 7 of 20000 HIL_SENSOR were lost').waitFor();
  assert.deepEqual(errors, []);
  await page.close();
});

test('a flight log alone is drawn at its estimate', async () => {
  const whole = makeRecord('log.tlog');
  const {name, system, log} = whole.vehicles[0]!;
  const bare = {format: 1, name: whole.name, duration_s: whole.duration_s, vehicles: [{name, system, log}]};
  const {page, errors} = await open(replay('log', [pack(bare)]));
  const now = await until(page, 'a picture', (scene) => scene.frames > 0);
  assert.equal(now.drawn, 'estimate');
  await page.getByText('not recorded').first().waitFor({state: 'attached'});
  assert.deepEqual(errors, []);
  await page.close();
});

test('a vehicle\'s own log is drawn at its estimate', async () => {
  const whole = makeRecord('own.ulg');
  const {name, system, log} = whole.vehicles[0]!;
  const topics: Record<string, string> = {
    HEARTBEAT: 'vehicle_status', LOCAL_POSITION_NED: 'vehicle_local_position', ATTITUDE: 'vehicle_attitude',
  };
  const own = {
    ...log!, autopilot: 'PX4', states: log!.states.map(([t, flags, , landed]): [number, number, string, number] => [t, flags, 'POSCTL', landed]),
    messages: log!.messages.map((message) => ({...message, name: topics[message.name] ?? message.name})),
  };
  const events = [{t_s: 12, kind: 'loss' as const, text: 'the log lacks 40 ms'}];
  const {page, errors} = await open(replay('ulg', [pack({
    format: 1, name: whole.name, duration_s: whole.duration_s, controller: 'PX4_FMU_V5X', vehicles: [{name, system, log: own, events}],
  })]));
  const now = await until(page, 'a picture', (scene) => scene.frames > 0);
  assert.equal(now.drawn, 'estimate');
  await page.getByText('POSCTL').first().waitFor();
  await page.getByRole('tab', {name: 'Log'}).first().click();
  await page.getByRole('button', {name: /the log lacks 40 ms/}).first().click();
  assert.equal((await scene(page)).time_s, 12);
  assert.deepEqual(errors, []);
  await page.close();
});

test('a vehicle with meshes of its own is drawn by them, whatever the theme', async () => {
  const corner = Buffer.concat([Buffer.from(Uint32Array.of(3, 1).buffer), Buffer.from(Float32Array.of(0, 0, 0, 0.3, 0, 0, 0, 0.3, 0).buffer),
    Buffer.from(Uint32Array.of(0, 1, 2).buffer)]);
  const record = makeRecord('meshes');
  Object.assign(record.vehicles[0]!.scene!, {
    visuals: [
      {shape: 'mesh', mesh: '0', p: [0, 0, 0.1], q: [1, 0, 0, 0]},
      {shape: 'box', size_m: [0.1, 0.1, 0.1], p: [0, 0, 0], q: [1, 0, 0, 0]},
    ],
    meshes: [corner.toString('base64')],
  });
  const {page, errors} = await open(replay('meshes', [pack(record)]));
  await until(page, 'its meshes', (now) => now.frames > 0 && now.ownMeshes === 1);
  const before = await scene(page);
  await page.keyboard.press('Shift+T');
  await until(page, 'the other theme', (now) => now.theme !== before.theme && now.frames > before.frames && now.ownMeshes === 1);
  assert.deepEqual(errors, []);
  await page.close();
});

test('a damaged record is a sentence', async () => {
  const {page} = await open(replay('damaged', ['AAAA']));
  await page.getByText('The record cannot be read').waitFor();
  await page.close();
});

test('each control has a name, and no label is cut or touches its neighbour', async () => {
  for (const [width, height] of [[1280, 800], [1920, 1080], [400, 800]] as const) {
    const {page} = await open(replay('names', [pack(makeRecord())]), width, height);
    await until(page, 'a picture', (now) => now.frames > 0);
    const nameless = await page.evaluate(() => [...document.querySelectorAll('button, select, input, canvas:not(.uplot canvas), [role=slider]')]
      .filter((each) => !(each.getAttribute('aria-label') ?? each.textContent ?? '').trim()).map((each) => each.outerHTML.slice(0, 120)));
    assert.deepEqual(nameless, [], `at ${width}`);
    const touching = await page.evaluate(() => {
      const texts = [...document.querySelectorAll('cas-links svg text')].map((each) => ({text: each.textContent!.trim(), box: each.getBoundingClientRect()}));
      const frame = document.querySelector('#link')!.getBoundingClientRect();
      const found: string[] = [];
      texts.forEach((a, i) => {
        if (a.text && (a.box.left < frame.left || a.box.right > frame.right + 0.5)) found.push(`cut: ${a.text}`);
        for (const b of texts.slice(i + 1)) {
          const over = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
          const high = Math.min(a.box.bottom, b.box.bottom) - Math.max(a.box.top, b.box.top);
          if (a.text && b.text && over > 0.5 && high > 4) found.push(`${a.text} | ${b.text}`);
        }
      });
      return found;
    });
    assert.deepEqual(touching, [], `at ${width}`);
    const cut = await page.locator('button.name, .play button, .chip').evaluateAll((all) => all.filter((each) => each.clientWidth > 0 && each.scrollWidth > each.clientWidth).map((each) => each.textContent));
    assert.deepEqual(cut, [], `at ${width}`);
    const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wider <= 0, `${wider} px too wide at ${width}`);
    await page.close();
  }
});

test('nothing moves its place after it was drawn', async () => {
  const {page} = await open(replay('still', [pack(makeRecord())]), 1280, 800, false);
  const now = await until(page, 'a picture', (each) => each.frames > 0);
  await page.keyboard.press('Space');
  await until(page, 'it plays', (each) => each.time_s! > 8.5);
  const {shift, paint_ms} = await page.evaluate(async () => {
    const shifts = await new Promise<number>((done) => {
      let sum = 0;
      new PerformanceObserver((list) => {
        for (const entry of list.getEntries()) sum += (entry as unknown as {value: number}).value;
      }).observe({type: 'layout-shift', buffered: true});
      setTimeout(() => done(sum), 200);
    });
    return {shift: shifts, paint_ms: performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0};
  });
  assert.ok(shift < 0.001, `layout shift ${shift}`);
  console.log(`first frame ${paint_ms.toFixed(0)} ms, first data ${now.firstData_ms?.toFixed(0)} ms after the script began`);
  await page.close();
});

test('without WebGL there is a map, and all else works', async () => {
  const flat = await launchFlat();
  const page = await flat.newPage({viewport: {width: 1280, height: 800}});
  const record = makeRecord();
  record.world = {parts: [{name: 'wall', shape: 'box', size_m: [1, 4, 3], p: [3, 0, 1.5], q: [1, 0, 0, 0]}], meshes: []};
  await page.goto(replay('flat', [pack(record)]));
  await until(page, 'the map', (now) => now.flat !== '');
  const [frame, map] = [(await page.locator('section.world').boundingBox())!, (await page.locator('canvas.map').boundingBox())!];
  assert.deepEqual(map, frame, 'the map has the place of the view');
  const colours = await page.evaluate(() => {
    const canvas = document.querySelector<HTMLCanvasElement>('canvas.map')!;
    const {data} = canvas.getContext('2d')!.getImageData(0, 0, canvas.width, canvas.height);
    const style = getComputedStyle(document.documentElement);
    const seen = new Set<string>();
    for (let i = 0; i < data.length; i += 4) seen.add(`#${[0, 1, 2].map((k) => data[i + k]!.toString(16).padStart(2, '0')).join('')}`);
    return ['gnd', 'grid', 't1', 't3', 'est', 'ref'].filter((name) => seen.has(style.getPropertyValue(`--${name}`).trim()));
  });
  assert.deepEqual(colours, ['gnd', 'grid', 't1', 't3', 'est', 'ref'], 'ground, lines, vehicle, wall, path, reference');
  await page.keyboard.press('Space');
  await until(page, 'it plays', (now) => now.time_s! > 8.2);
  await flat.close();
});
