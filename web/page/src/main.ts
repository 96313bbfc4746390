// SPDX-License-Identifier: BSD-3-Clause
import 'uplot/dist/uPlot.min.css';
import './page.css';
import './app.ts';
import './commands.ts';
import './faults.ts';
import './horizon.ts';
import './links.ts';
import './lists.ts';
import './plots.ts';
import './sticks.ts';
import './timeline.ts';
import './world.ts';
import {addHelp} from './keys.ts';
import {LiveSource} from './live_source.ts';
import {page} from './page.ts';
import {unpack, type RunRecord} from './record.ts';
import {RecordSource} from './record_source.ts';
import type {Source} from './source.ts';
import {setTheme, theme, themeListeners} from './theme.ts';
import type {World} from './world.ts';

const kText_s = 0.1;

/** Hook for tests, which never look at pixels. */
function hook(started_ms: number) {
  return {
    scene: () => {
      const {bench} = page;
      const world = document.querySelector<World>('cas-world');
      const shown = bench.motion();
      return {
        time_s: bench.time_s, connection: bench.connection, name: bench.name, selected: bench.selected,
        vehicles: bench.vehicles.map((vehicle) => ({name: vehicle.name, p: vehicle.sim?.p, rotors: vehicle.sim?.rotors})),
        drawn: shown?.label, estimate: bench.estimate(), reference: bench.vehicle?.reference, state: bench.vehicle?.state,
        camera: page.camera, cameraAt: world?.view?.camera.position.toArray(), tags: world?.view?.tags.map((tag) => tag.id) ?? [],
        flat: world?.flat ?? '', frames: world?.view?.frames ?? 0, playing: page.source?.player?.playing, speed: page.source?.player?.speed,
        links: bench.links?.hops, loop: bench.loop, tape: bench.tape?.around, verdict: bench.verdict?.state, touched: bench.verdict?.touched,
        faults: bench.faults.map((fault) => fault.name), programs3d: world?.view?.programs, ownMeshes: world?.view?.ownMeshes ?? 0, worldParts: world?.view?.worldParts ?? 0,
        returns: world?.view?.returns ?? 0,
        happenings: bench.happenings.length, messages: bench.messages.length, question: page.question?.text, refusal: page.refusal,
        theme: theme(), firstData_ms: firstData_ms === undefined ? undefined : firstData_ms - started_ms,
      };
    },
  };
}

let firstData_ms: number | undefined;

/** The first frame is on the screen; a hidden page is never painted. */
function painted(): Promise<void> {
  const kLongest_ms = 500;
  return new Promise((done) => {
    new PerformanceObserver((_, observer) => {
      observer.disconnect();
      done();
    }).observe({type: 'paint', buffered: true});
    setTimeout(done, kLongest_ms);
  });
}

function run(source: Source): void {
  page.source = source;
  source.start(page.bench);
  // A record opens with all of the flight in view; a live bench follows the vehicles.
  page.camera = source.player ? 'orbit' : 'follow';
  page.tab = source.player ? 'Plots' : 'Messages';
  page.secondTab = source.player ? 'Messages' : 'Plots';
  document.body.append(document.createElement('cas-app'));
  themeListeners.add(() => page.redraw());
  void painted().then(() => {
    page.seen = true;
    addHelp();
    page.redraw();
  });
  let text_s = -1;
  const frame = (now_ms: number) => {
    const now_s = now_ms / 1000;
    page.now_s = now_s;
    source.tick(now_s);
    if (firstData_ms === undefined && page.bench.motion()) firstData_ms = now_ms;
    for (const each of page.frames) each(now_s);
    if (now_s - text_s >= kText_s) {
      text_s = now_s;
      page.redraw();
    }
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

/** A record that cannot be read still gets the frame, with the reason in it. */
async function records(): Promise<RunRecord[]> {
  const blocks = [...document.querySelectorAll<HTMLElement>('script.record')];
  return Promise.all(blocks.map((block) => unpack(block.textContent ?? '', block.dataset.source)));
}

async function start(): Promise<void> {
  const stored = document.documentElement.dataset.theme;
  if (!stored) setTheme(theme());
  const isReplay = document.documentElement.dataset.kind === 'replay';
  Object.assign(window, {__cas: hook(performance.now())});
  if (!isReplay) return run(new LiveSource());
  try {
    const [first, second] = await records();
    if (!first) throw new Error('There is no record in this page: `hils replay DIR --out FILE` makes one.');
    document.title = `CAS: ${first.raw.name}`;
    run(new RecordSource(first, second));
  } catch (error) {
    document.body.append(`The record cannot be read: ${error instanceof Error ? error.message : String(error)}`);
  }
}

void start();
