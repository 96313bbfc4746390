// SPDX-License-Identifier: BSD-3-Clause
// runs.html from disk, with data as hils/runs/runs_page.cpp writes it, and the built script.
import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import type {Browser, Page} from 'playwright-core';
import {complaints, launchFlat} from './chromium.ts';

let browser: Browser;
const folder = mkdtempSync(join(tmpdir(), 'cas-runs-'));
before(async () => { browser = await launchFlat(); });
after(async () => {
  await browser.close();
  rmSync(folder, {recursive: true});
});

const run = (name: string, more: object) => ({
  folder: name, verdict: 'PASSED', scenario: 'hover', controller: '', architecture: 'direct', clock: 'virtual', seed: 1, ended_s: 1_764_000_000, why: '',
  report: `${name}/report.html`, replay: '', figures: {rms_position_m: 0.1}, settings: {}, ...more,
});
const kRuns = [
  run('calm', {ended_s: 1_764_000_300, settings: {'hilsim.plugins[wind].mean_m_s': '0'}}),
  run('a <b> gust', {verdict: 'FAILED', why: 'the vehicle hit something', figures: {rms_position_m: 0.25}, settings: {'hilsim.plugins[wind].mean_m_s': '8'}}),
  run('wall', {scenario: 'px4_wall', controller: 'PX4 1.16.0', figures: {}}),
];

async function open(javaScriptEnabled: boolean): Promise<{page: Page; errors: string[]}> {
  const file = (name: string) => readFileSync(join(process.env.CAS_PAGE!, name), 'utf8');
  const data = JSON.stringify({folder: '/out', runs: kRuns}).replaceAll('<', '\\u003c');
  writeFileSync(join(folder, 'runs.html'), `<!doctype html><meta charset="utf-8"><title>runs</title><style>:root{--ink:#111;--box:#fff;--quiet:#666}</style>
    <body><main><h1>3 runs</h1><p class="caption">plain</p><div class="scroll"><table><tr><td>plain row</td></tr></table></div></main><style>${file('runs.css')}</style>
    <script type="application/json" id="runs">${data}</script><script>${file('runs.js')}</script></body>`);
  const page = await browser.newPage({viewport: {width: 1280, height: 800}, javaScriptEnabled});
  const errors = complaints(page);
  await page.goto(`file://${join(folder, 'runs.html')}`);
  return {page, errors};
}

const scenarios = (page: Page) => page.locator('table.runs tbody tr').evaluateAll((rows) => rows.map((row) => row.children[4]!.textContent));

test('runs are sorted and filtered, and two that are ticked stand side by side', async () => {
  const {page, errors} = await open(true);
  assert.deepEqual(await scenarios(page), ['calm', 'a <b> gust', 'wall']);  // the latest first
  await page.getByRole('button', {name: 'RMS error, m'}).click();
  await page.getByRole('button', {name: 'RMS error, m'}).click();
  assert.deepEqual(await scenarios(page), ['a <b> gust', 'calm', 'wall']);  // one without the figure is last
  await page.getByRole('searchbox').fill('px4');
  assert.deepEqual(await scenarios(page), ['wall']);
  await page.getByRole('searchbox').fill('');
  await page.getByLabel('Verdict').selectOption('FAILED');
  assert.deepEqual(await scenarios(page), ['a <b> gust']);
  await page.getByLabel('Verdict').selectOption('');
  await page.getByLabel('compare a <b> gust').check();
  await page.getByLabel('compare calm').check();
  const beside = page.getByRole('region', {name: 'Comparison'});
  const text = await beside.innerText();
  assert.match(text, /A: a <b> gust · hover · FAILED · the vehicle hit something/);
  assert.match(text, /B: calm · hover · PASSED/);
  assert.match(text, /hilsim\.plugins\[wind\]\.mean_m_s\s+8\s+0/);
  assert.match(text, /rms_position_m\s+0\.25\s+0\.1\s+-0\.15\s+−60\.0/);
  assert.match(text, /hils replay '\/out\/a <b> gust' \/out\/calm --out compared\.html/);
  await page.getByLabel('compare calm').uncheck();
  assert.equal(await beside.innerText(), '');
  assert.deepEqual(errors, []);
  await page.close();
});

test('without a script the plain table of runs stays', async () => {
  const {page} = await open(false);
  assert.equal(await page.getByText('plain row').isVisible(), true);
  await page.close();
});
