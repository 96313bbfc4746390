// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing, svg} from 'lit';
import {refuseGoto} from './commands.ts';
import {rotate} from './frames.ts';
import {fixed} from './numbers.ts';
import {page, Part, sized, type Camera} from './page.ts';
import type {Tag, View3D} from './scene3d.ts';
import {colour, themeListeners} from './theme.ts';

const kCameras: [Camera, string][] = [['orbit', 'Orbit'], ['follow', 'Follow'], ['chase', 'Chase'], ['top', 'Top']];

/** Direction that the wind comes from, degrees from north. */
export function windFrom(wind: [number, number, number]): number {
  return (Math.round((Math.atan2(-wind[0], -wind[1]) * 180) / Math.PI) + 360) % 360;
}

/** Contents of the view, in a sentence. */
export function viewSentence(): string {
  const {bench} = page;
  const shown = bench.motion();
  if (!shown) return 'No vehicle.';
  const [e, n, u] = shown.motion.p;
  const reference = bench.vehicle?.reference;
  const off = reference ? `, error ${fixed(Math.hypot(e - reference.p_W[0], n - reference.p_W[1], u - reference.p_W[2]))} m` : '';
  return `Vehicle ${bench.vehicle?.system ?? 1} at ${fixed(n, 1)} m north, ${fixed(e, 1)} m east, ${fixed(u, 1)} m up${off}`;
}

/** The page is one file (build.mjs): its 3D view is a block in it, which casRun() runs, and then is casView. */
declare const kOneFile: boolean;
declare const casRun: (id: string) => Promise<void>;
declare const casView: typeof import('./scene3d.ts');

function loadView(): Promise<typeof import('./scene3d.ts')> {
  return kOneFile ? casRun('view').then(() => casView) : import('./scene3d.ts');
}

/** The 3D view with its cameras and tags; a map from above where there is no WebGL. */
export class World extends Part {
  view?: View3D;
  tags: Tag[] = [];
  /** Why there is no 3D view. */
  flat = '';
  /** Times that the vehicle is drawn larger, as shown. */
  private enlarged = 1;
  /** Lines of the map. */
  private grid_m = 1;
  private sentence = '';
  private said_s = -10;
  private loading = false;
  private readonly onTheme = () => this.view?.restyle();

  override connectedCallback(): void {
    super.connectedCallback();
    themeListeners.add(this.onTheme);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    themeListeners.delete(this.onTheme);
  }

  private async load(): Promise<void> {
    this.loading = true;
    const canvas = this.querySelector<HTMLCanvasElement>('canvas.gl')!;
    try {
      const {View3D} = await loadView();
      this.view = new View3D(canvas, (vehicle, key) => page.source.series(vehicle, key));
      this.view.setBeside((vehicle, key) => page.source.beside?.(vehicle, key));
      this.view.setCamera(page.camera);
    } catch (error) {
      this.flat = 'No WebGL here: a map from above, north up';
      console.info('no 3D view:', error);
    }
    this.requestUpdate();
  }

  protected override render() {
    const {bench} = page;
    if (page.now_s - this.said_s > 5) {
      this.said_s = page.now_s;
      this.sentence = viewSentence();
    }
    const wind = bench.wind_W && Math.hypot(...bench.wind_W);
    const hasTruth = Boolean(bench.truth());
    return html`<div class="view">
        <canvas class="gl" ?hidden=${this.flat !== ''} role="img" aria-label=${this.sentence}
          @click=${this.clicked} @wheel=${this.wheeled}></canvas>
        ${this.flat ? html`<canvas class="map" role="img" aria-label=${this.sentence}></canvas>` : nothing}
      </div>
      <div class="tags" aria-hidden="true"><svg>${this.tags.map((tag) => tag.from ? svg`<path
          d=${`M${tag.from[0].toFixed(1)} ${tag.from[1].toFixed(1)}L${(tag.x + (tag.x > tag.from[0] ? 0 : tag.text.length * 6.1 + 12)).toFixed(1)} ${(tag.y + 9).toFixed(1)}`}
          stroke=${`var(--${tag.kind})`} opacity=".7" fill="none"></path>` : nothing)}</svg>
        ${this.tags.map((tag) => html`<span class=${tag.from ? `tag ${tag.kind}` : 'axis'}
          .style=${`transform:translate(${tag.x.toFixed(1)}px,${tag.y.toFixed(1)}px)`}>${tag.text}</span>`)}
      </div>
      <div class="hud tl" role="group" aria-label="Camera">${this.flat ? nothing : kCameras.map(([mode, name], i) => html`
        <button class="chip" aria-pressed=${page.camera === mode} @click=${() => this.setCamera(mode)}>${name}<kbd class="optional">${i + 1}</kbd></button>`)}</div>
      <div class="hud tr optional">${wind !== undefined && wind > 0.05
        ? html`<span class="chip">wind ${fixed(wind, 1)} m/s from ${windFrom(bench.wind_W!)}°</span>` : nothing}</div>
      <div class="hud bl optional"><span class="chip"><i class="truth-i"></i><span>${bench.beside.length > 0 ? 'A' : hasTruth ? 'vehicle' : 'vehicle at its estimate'}</span>${
        hasTruth ? html`<i class="est-i"></i><span>estimate</span>` : nothing}${
        bench.vehicle?.reference ? html`<i class="ref-i"></i><span>reference</span>` : nothing}${
        bench.clouds.v.some(({length}) => length > 0) ? html`<i class="lidar-i"></i><span>lidar</span>` : nothing}${
        bench.beside.length > 0 ? html`<span class="c-t2">┄ B</span>` : nothing}</span></div>
      <div class="hud br optional">${this.flat ? nothing : html`<span class="chip">trail: error 0<span class="scale"></span>${bench.errorLimit_m} m</span>`}
        <span class="chip">frame W · grid ${this.view?.scale.step_m ?? this.grid_m} m${this.enlarged > 1 ? ` · vehicle × ${this.enlarged}` : ''}</span></div>
      ${this.flat ? html`<div class="hud tl"><span class="chip">${this.flat}</span></div>` : nothing}`;
  }

  setCamera(mode: Camera): void {
    page.camera = mode;
    this.view?.setCamera(mode);
    page.redraw();
  }
  frameAll(): void {
    this.setCamera('orbit');
    this.view?.frameAll(page.bench);
  }

  /** The ground under the pointer, while a place to go to is chosen. */
  private readonly clicked = (event: MouseEvent) => {
    if (!page.goto || !this.view) return;
    const hit = this.view.groundAt(event.offsetX, event.offsetY);
    if (!hit) return;
    const up_m = page.goto.up_m;
    const to = page.bench.inN([hit[0], hit[1], up_m]);
    if (!to) return refuseGoto();
    const place = `${fixed(hit[1], 1)} north, ${fixed(hit[0], 1)} east, ${fixed(up_m, 1)} up`;
    page.ask(`Go to ${place}?`, 'Go', (vehicle) => void page.command('vehicle.goto', {vehicle, ...to}));
    page.goto = {...page.goto, north_m: hit[1], east_m: hit[0], up_m};
  };
  /** The wheel changes the height of the place. */
  private readonly wheeled = (event: WheelEvent) => {
    if (!page.goto) return;
    page.goto.up_m = Math.max(0.5, page.goto.up_m - Math.sign(event.deltaY) * 0.25);
    page.redraw();
  };

  protected override frame(now_s: number): void {
    if (!this.hasUpdated || this.clientWidth === 0 || document.hidden) return;
    // Without a graphics card the shaders hold up all drawing.
    if (page.seen && !this.view && !this.loading) void this.load();
    if (this.view) {
      this.view.draw(page.bench, now_s, Boolean(page.source.player));
      const {enlarged} = this.view.scale;
      this.enlarged = enlarged > 1.1 ? Number(enlarged.toPrecision(2)) : 1;
      if (this.view.tags !== this.tags) {
        this.tags = this.view.tags;
        this.requestUpdate();
      }
    } else if (this.flat) {
      this.drawMap();
    }
  }

  /** From above, north up: obstacles, the reference and the path so far, and the vehicles as arrows to where they head. */
  private drawMap(): void {
    const canvas = this.querySelector<HTMLCanvasElement>('canvas.map');
    if (!canvas) return;
    const {bench, source} = page;
    const g = sized(canvas);
    const [W, H] = [canvas.clientWidth, canvas.clientHeight];
    const p = bench.motion()?.motion.p ?? [0, 0, 0];
    const until_s = bench.time_s ?? 0;
    const pathOf = (names: string[], series = (key: string) => source.series(bench.selected, key)): [number, number][] => {
      const found = names.map((name) => [series(`${name}.e`), series(`${name}.n`)]).find(([e, n]) => e && n);
      const points: [number, number][] = [];
      if (found) for (let i = 0; i < found[0]!.t.length && found[0]!.t[i]! <= until_s; i += 5) points.push([found[0]!.v[i]!, found[1]!.v[i]!]);
      return points;
    };
    const flown = pathOf(['truth', 'est']);
    const reach = flown.reduce((most, [e, n]) => Math.max(most, Math.abs(e - p[0]), Math.abs(n - p[1])), 1);
    const scale = Math.min(40, (0.42 * Math.min(W, H)) / reach);
    const at = (e: number, n: number): [number, number] => [W / 2 + (e - p[0]) * scale, H / 2 - (n - p[1]) * scale];
    this.grid_m = scale > 12 ? 1 : scale > 1.2 ? 10 : 100;
    g.fillStyle = colour('gnd');
    g.fillRect(0, 0, W, H);
    const half = Math.ceil(Math.max(W, H) / 2 / scale / this.grid_m);
    for (let i = -half; i <= half; ++i) {
      const [e, n] = [p[0], p[1]].map((value) => Math.round(value / this.grid_m) + i) as [number, number];
      g.fillStyle = colour(e % 5 === 0 ? 'grid2' : 'grid');
      g.fillRect(at(e * this.grid_m, 0)[0], 0, 1, H);
      g.fillStyle = colour(n % 5 === 0 ? 'grid2' : 'grid');
      g.fillRect(0, at(0, n * this.grid_m)[1], W, 1);
    }
    g.fillStyle = colour('t3');
    for (const {p: [e, n], q, size_m, radius_m} of bench.scene?.world ?? []) {
      const outline = size_m ? [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([x, y]) => rotate(q, [(x! * size_m[0]) / 2, (y! * size_m[1]) / 2, 0]))
        : Array.from({length: 24}, (_, i) => [(radius_m ?? 0) * Math.cos((Math.PI * i) / 12), (radius_m ?? 0) * Math.sin((Math.PI * i) / 12)]);
      g.beginPath();
      for (const [x, y] of outline) g.lineTo(...at(e + x!, n + y!));
      g.fill();
    }
    const second = pathOf(['truth'], (key) => source.beside?.(bench.selected, key));
    for (const [path, name] of [[pathOf(['ref']), 'ref'], [second, 't2'], [flown, 'est']] as const) {
      g.beginPath();
      for (const point of path) g.lineTo(...at(...point));
      g.strokeStyle = colour(name);
      g.lineWidth = 2.5;
      g.stroke();
    }
    for (const vehicle of bench.vehicles) {
      const motion = bench.motion(vehicle)?.motion;
      if (!motion) continue;
      g.save();
      g.translate(...at(motion.p[0], motion.p[1]));
      g.rotate(motion.rpy.yaw);
      g.beginPath();
      for (const [x, y] of [[0, -11], [7, 8], [0, 4], [-7, 8]] as const) g.lineTo(x, y);
      g.fillStyle = colour(vehicle === bench.vehicle ? 't1' : 't2');
      g.fill();
      g.restore();
    }
  }
}
customElements.define('cas-world', World);
