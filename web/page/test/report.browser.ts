// SPDX-License-Identifier: BSD-3-Clause
// report.html from disk: drawings with their numbers beside them, as hils writes them, and the built script.
import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import type {Browser, Page} from 'playwright-core';
import {complaints, launch} from './chromium.ts';

let browser: Browser;
const folder = mkdtempSync(join(tmpdir(), 'cas-report-'));
before(async () => { browser = await launch(); });
after(async () => {
  await browser.close();
  rmSync(folder, {recursive: true});
});

function report(broken = ''): string {
  const data = {
    x_label: 'simulated time, s', y_label: 'north, m', series: [
      {name: 'reference', dashed: true, x: {k: 1, d: [0, 1, 1, 1, 1]}, y: {k: 0.1, d: [0, 0, 10, 0, 0]}},
      {name: 'truth', x: {k: 0.5, d: [0, 1, 1, 1, 1, 1, 1, 1, 1]}, y: {k: 0.1, d: [0, 1, 2, 2, 2, 2, 1, 0, 0]}},
      {name: 'best', dots: true, x: {k: 1, d: [2]}, y: {k: 0.1, d: [5]}},
    ],
    marks: [{x: 2, text: 'gust', fault: true}], shaded: [1, 3],
  };
  const figure = `<figure><svg viewBox="0 0 10 10" role="img" aria-label="drawing"><path d="M0 0h9"/></svg>` +
    `<script type="application/json" class="plot">${JSON.stringify(data)}</script></figure>`;
  const file = (name: string) => readFileSync(join(process.env.CAS_PAGE!, name), 'utf8');
  return `<!doctype html><meta charset="utf-8"><title>report</title><style>:root{--ink:#111;--line:#ddd;--quiet:#666}</style>
    <body><main>${broken}${figure}${figure}</main><style>${file('report.css')}</style><script>${file('report.js')}</script></body>`;
}

async function open(options: {javaScriptEnabled: boolean}, broken = ''): Promise<Page> {
  writeFileSync(join(folder, 'report.html'), report(broken));
  const page = await browser.newPage({viewport: {width: 900, height: 900}, ...options});
  await page.goto(`file://${join(folder, 'report.html')}`);
  return page;
}

test('a report from disk has plots that are zoomed, hidden and measured', async () => {
  const page = await open({javaScriptEnabled: true});
  const errors = complaints(page);
  await page.locator('.uplot').nth(1).waitFor();
  assert.equal(await page.getByRole('img', {name: 'drawing'}).first().isVisible(), false);
  const over = page.locator('.u-over').first();
  const box = (await over.boundingBox())!;
  // One cursor over all: the second plot's legend follows the first.
  await page.mouse.move(box.x + box.width * 0.5, box.y + 50);
  const legend = page.locator('.u-legend').nth(1);
  await page.waitForFunction(() => /[0-9]/.test(document.querySelectorAll('.u-legend')[1]!.querySelectorAll('.u-value')[0]!.textContent!));
  await page.mouse.click(box.x + box.width * 0.25, box.y + 50);
  await page.mouse.click(box.x + box.width * 0.75, box.y + 50);
  assert.match((await page.locator('figcaption').first().textContent())!, /^Between the points: 2\.0.* s, .* m/);
  await legend.getByText('truth').click();
  assert.equal(await legend.locator('.u-off').count(), 1);
  await page.mouse.move(box.x + box.width * 0.4, box.y + 60);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.6, box.y + 60, {steps: 4});
  await page.mouse.up();
  assert.deepEqual(errors, []);
  await page.close();
});

test('without a script the drawings are there', async () => {
  const page = await open({javaScriptEnabled: false});
  assert.equal(await page.getByRole('img', {name: 'drawing'}).first().isVisible(), true);
  await page.close();
});

test('a plot that cannot be drawn keeps its drawing, and the others are drawn', async () => {
  const page = await open({javaScriptEnabled: true}, '<figure><svg viewBox="0 0 10 10" role="img" aria-label="kept"><path d="M0 0h9"/></svg>' +
    '<script type="application/json" class="plot">{"x_label": "t"}</script></figure>');
  await page.locator('.uplot').nth(1).waitFor();
  assert.equal(await page.locator('.uplot').count(), 2);
  assert.equal(await page.getByRole('img', {name: 'kept'}).isVisible(), true);
  await page.close();
});
