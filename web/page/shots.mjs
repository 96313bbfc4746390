// SPDX-License-Identifier: BSD-3-Clause
// node shots.mjs REPLAY.html FOLDER [TIME_S]: pictures of a replay in light, dark and narrow, for docs/pictures/.
// ONLY=replay-1280 takes those of that name, CAMERA=2 presses the key of a camera before.
import {mkdirSync} from 'node:fs';
import {join, resolve} from 'node:path';
import {chromium} from 'playwright-core';

const [file, folder, time] = process.argv.slice(2);
if (!file || !folder) {
  console.error('usage: node shots.mjs REPLAY.html FOLDER [TIME_S]');
  process.exit(2);
}
mkdirSync(folder, {recursive: true});
const browser = await chromium.launch({
  executablePath: '/usr/bin/chromium', args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
});
const shots = [
  {name: 'replay-1280', width: 1280, height: 800, colorScheme: 'light'},
  {name: 'replay-dark-1280', width: 1280, height: 800, colorScheme: 'dark'},
  {name: 'replay-400', width: 400, height: 900, colorScheme: 'dark'},
  {name: 'replay-1920', width: 1920, height: 1080, colorScheme: 'dark'},
];
for (const {name, width, height, colorScheme} of shots) {
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const page = await browser.newPage({viewport: {width, height}, colorScheme});
  page.on('console', (message) => message.type() === 'error' && console.error(name, message.text()));
  page.on('pageerror', (error) => console.error(name, error.message));
  await page.goto(`file://${resolve(file)}`);
  await page.waitForFunction(() => window.__cas?.scene().frames > 2, null, {timeout: 240_000});
  if (time) {
    // To the moment by the scrubber's own way: seconds from the start.
    await page.keyboard.press('Home');
    for (let t = 0; t < Math.floor(Number(time) / 10); ++t) await page.keyboard.press('Shift+ArrowRight');
    for (let t = 0; t < Math.round(Number(time) % 10); ++t) await page.keyboard.press('ArrowRight');
  }
  if (process.env.CAMERA) await page.keyboard.press(process.env.CAMERA);
  await page.waitForTimeout(1500);
  await page.screenshot({path: join(folder, `${name}.png`), fullPage: width < 640});
  await page.close();
}
await browser.close();
