// SPDX-License-Identifier: BSD-3-Clause
// The built page in front of a real bench: `hils run --web` starts hilsim, casd, the emulated controller and casweb.
import assert from 'node:assert/strict';
import {spawn, type ChildProcess} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {test} from 'node:test';
import {complaints, launch, until} from './chromium.ts';

const kBin = process.env.CAS_BIN ?? '';
const kConfig = process.env.CAS_CONFIG ?? '';

const kScenario = `schema: 1
name: seen
vehicle: ${join(kConfig, 'vehicles/iris_paper.yaml')}
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
steps:
  - hold: {duration_s: 15}
  - arm
  - takeoff: {altitude_m: 2.5}
  - hold: {duration_s: 10, measure: true}
  - land
limits: {lost: 0, rms: {x_m: 2, y_m: 2, z_m: 2}}
`;

/** Waits for a line of a program's output. */
function line(child: ChildProcess, pattern: RegExp): Promise<RegExpExecArray> {
  return new Promise((resolve, reject) => {
    let text = '';
    const look = (bytes: Buffer) => {
      text += bytes.toString();
      const found = pattern.exec(text);
      if (found) resolve(found);
    };
    child.stderr!.on('data', look);
    child.stdout!.on('data', look);
    child.on('exit', (code) => reject(new Error(`hils ended with ${code}: ${text}`)));
  });
}

const missing = ['hils', 'casweb', 'casd', 'hilsim', 'fcu_emulator'].filter((name) => !existsSync(join(kBin, name)));

test('a run is watched, touched and judged in the browser', {skip: missing.length > 0 ? `not built: ${missing.join(', ')}` : false}, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'cas-page-'));
  writeFileSync(join(folder, 'seen.yaml'), kScenario);
  const hils = spawn(join(kBin, 'hils'), ['run', join(folder, 'seen.yaml'), '--web', '--out', join(folder, 'out')], {
    env: {...process.env, CAS_RUNTIME_DIR: join(folder, 'run')},
  });
  const browser = await launch();
  try {
    const ended = new Promise<number | null>((resolve) => hils.on('exit', resolve));
    const [, file] = await line(hils, /the address with its token is in (.*)\)/);
    const page = await browser.newPage({viewport: {width: 1280, height: 800}, colorScheme: 'dark'});
    const errors = complaints(page);
    const begin = Date.now();
    await page.goto(readFileSync(file!, 'utf8').trim());
    await until(page, 'the vehicle is drawn where it truly is', (now) => now.connection === 'live' && now.drawn === 'truth' && now.frames > 0);
    console.log(`first picture after ${Date.now() - begin} ms`);
    assert.ok(!page.url().includes('#'), page.url());
    const first = await until(page, 'the run tells its limits', (now) => now.verdict === 'running' && now.name === 'seen');
    await until(page, 'time goes on', (now) => now.time_s! > first.time_s!);
    await until(page, 'both links are measured', (now) => (now.links?.length ?? 0) >= 4);

    await page.keyboard.press(' ');
    await page.getByText('paused').first().waitFor();
    await page.keyboard.press(' ');
    await page.getByLabel('Length of a fault').selectOption('0.2');
    await page.getByRole('button', {name: 'No GPS'}).click();
    await page.keyboard.press('Enter');
    await until(page, 'the fault is on the timeline', (now) => now.faults.includes('No GPS'));
    const touched = await until(page, 'the run says who touched it', (now) => (now.touched?.length ?? 0) >= 3);
    for (const act of ['sim.pause', 'sim.resume', 'fault.inject']) assert.ok(touched.touched!.some((each) => each.startsWith(act)), act);
    await page.getByText('touched', {exact: true}).waitFor();

    const flown = await until(page, 'the reference is there, and the vehicle near it', (now) => now.reference !== undefined && now.vehicles[0]!.p![2] > 1.5);
    assert.ok(Math.abs(flown.reference!.p_W[2] - 2.5) < 0.5);
    await page.getByText(/of 2 m · .* %/).first().waitFor();
    assert.deepEqual(errors, []);
    await until(page, 'the verdict is told', (now) => ['passed', 'failed', 'invalid'].includes(now.verdict ?? ''));
    await ended;
    const summary = JSON.parse(readFileSync(join(folder, 'out/summary.json'), 'utf8')) as {
      vehicles: {from_outside: boolean}[];
    };
    assert.equal(summary.vehicles[0].from_outside, true);
  } finally {
    await browser.close();
    hils.kill('SIGINT');
    rmSync(folder, {recursive: true, force: true});
  }
});
