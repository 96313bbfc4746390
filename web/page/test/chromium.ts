// SPDX-License-Identifier: BSD-3-Clause
import {existsSync} from 'node:fs';
import {chromium, type Browser, type Page} from 'playwright-core';

/** Debian's chromium; nothing where it is not installed. */
export const kChromium = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((file) => existsSync(file));

const kCommon = ['--no-sandbox', '--disable-dev-shm-usage'];

/** A browser that draws WebGL on the processor. */
export function launch(): Promise<Browser> {
  return chromium.launch({executablePath: kChromium!, args: [...kCommon, '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
}

/** A browser without WebGL. */
export function launchFlat(): Promise<Browser> {
  return chromium.launch({executablePath: kChromium!, args: [...kCommon, '--disable-3d-apis']});
}

/** The page's own report (main.ts, hook). */
export interface SceneHook {
  time_s: number | null;
  connection: string;
  name: string;
  vehicles: {name: string; p?: [number, number, number]; rotors?: number[]}[];
  drawn?: string;
  estimate?: {p: [number, number, number]; age_s: number};
  camera: string;
  cameraAt?: number[];
  tags: string[];
  flat: string;
  frames: number;
  playing?: boolean;
  speed?: number;
  links?: {from: string; to: string; lost?: number; state?: string}[];
  loop?: {ms: {p50: number}};
  tape?: string;
  verdict?: string;
  reference?: {p_W: [number, number, number]};
  touched?: string[];
  faults: string[];
  programs3d?: number[];
  ownMeshes: number;
  worldParts: number;
  returns: number;
  messages: number;
  question?: string;
  refusal: string;
  theme: string;
  firstData_ms?: number;
}

export const scene = (page: Page): Promise<SceneHook> =>
  page.evaluate(() => (window as unknown as {__cas: {scene(): unknown}}).__cas.scene()) as Promise<SceneHook>;

/** Waits until the scene is so. */
export async function until(page: Page, what: string, holds: (scene: SceneHook) => boolean): Promise<SceneHook> {
  const end = Date.now() + 60_000;
  for (;;) {
    const now = await scene(page).catch(() => undefined);
    if (now && holds(now)) return now;
    if (Date.now() > end) throw new Error(`not in 60 s: ${what}; the scene is ${JSON.stringify(now)}`);
    await page.waitForTimeout(50);
  }
}

/** All that a page complains about. */
export function complaints(page: Page): string[] {
  const list: string[] = [];
  page.on('console', (message) => {
    if (message.type() === 'error') list.push(message.text());
  });
  page.on('pageerror', (error) => list.push(error.message));
  return list;
}
