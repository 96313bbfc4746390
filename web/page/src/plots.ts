// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing} from 'lit';
import uPlot from 'uplot';
import {fixed} from './numbers.ts';
import {page, Part} from './page.ts';
import {indexAt, type Series} from './series.ts';
import {colour, themeListeners} from './theme.ts';

interface Line {
  key: string;
  label: string;
  colour: string;
  width?: number;
  dash?: number[];
  beside?: boolean;
}

interface PlotSpec {
  id: string;
  title: string;
  lines: Line[];
  digits: number;
  /** A drawn bound with its text. */
  limit?: () => {value: number; text: string} | undefined;
  picked?: string;
}

const kLive_s = 20;
const kMostPoints = 1500;

function followed(id: string, title: string, axis: string): PlotSpec {
  return {
    id, title, digits: 1,
    lines: [
      {key: `ref.${axis}`, label: 'reference', colour: 'ref', dash: [2, 3]},
      {key: `est.${axis}`, label: 'estimate', colour: 'est', width: 1.2},
      {key: `truth.${axis}`, label: 'truth', colour: 't1', width: 1.6},
    ],
  };
}

const kRotorColours = ['t1', 'est', 'act', 'ref', 'amber', 't2', 't3', 'acc'];

/** The plots of a vehicle: those of which it has at least one line. */
export function plotSpecs(rotors: number, picked: readonly string[]): PlotSpec[] {
  const angles = (prefix: string, names: string[]): Line[] =>
    names.map((name, i) => ({key: `${prefix}.${name}`, label: name, colour: ['t1', 'est', 'act'][i]!}));
  return [
    ...picked.map((key): PlotSpec => ({
      id: `picked ${key}`, title: key, digits: 2, picked: key, lines: [{key, label: '', colour: 't1'}],
    })),
    followed('north', 'North, m', 'n'),
    followed('east', 'East, m', 'e'),
    followed('up', 'Up, m', 'u'),
    {
      id: 'error', title: 'Error against the reference, m', digits: 1,
      lines: [{key: 'error.m', label: '', colour: 't1'}],
      limit: () => ({value: page.bench.errorLimit_m, text: `limit (RMS) ${page.bench.errorLimit_m}`}),
    },
    {id: 'attitude', title: 'Attitude, °', digits: 0, lines: angles('truth', ['roll', 'pitch', 'yaw'])},
    {id: 'rates', title: 'Rates, °/s', digits: 0, lines: angles('truth', ['p', 'q', 'r'])},
    {
      id: 'rotors', title: 'Rotors, rad/s', digits: 0,
      lines: Array.from({length: rotors}, (_, i) => ({
        key: `rotor.${i + 1}`, label: String(i + 1), colour: kRotorColours[i % 8]!, width: 1.2, dash: i >= 8 ? [4, 2] : undefined,
      })),
    },
    {
      id: 'loop', title: 'Loop, ms', digits: 1,
      lines: [{key: 'loop.p99', label: '99 %', colour: 't3'}, {key: 'loop.p50', label: 'median', colour: 't1'}],
    },
  ];
}

/** So few points that a plot of this width shows the same: least and greatest of each stretch. */
export function thinned(series: Series, from: number, to: number, most = kMostPoints): Series {
  const a = Math.max(0, indexAt(series.t, from));
  const b = Math.min(series.t.length, indexAt(series.t, to) + 2);
  const stretch = Math.ceil((b - a) / (most / 2));
  if (stretch <= 2) {
    const t: number[] = [];
    const v: number[] = [];
    for (let i = a; i < b; ++i) {
      t.push(series.t[i]!);
      v.push(series.v[i]!);
    }
    return {t, v};
  }
  const t: number[] = [];
  const v: number[] = [];
  for (let i = a; i < b; i += stretch) {
    let low = i;
    let high = i;
    for (let k = i; k < Math.min(b, i + stretch); ++k) {
      if (series.v[k]! < series.v[low]!) low = k;
      if (series.v[k]! > series.v[high]!) high = k;
    }
    for (const k of low < high ? [low, high] : low > high ? [high, low] : [low]) {
      t.push(series.t[k]!);
      v.push(series.v[k]!);
    }
  }
  return {t, v};
}

/** Several series on one time axis, as uPlot wants them: undefined where one has no sample. */
function aligned(lines: Series[]): uPlot.AlignedData {
  const tables = lines.map((line): [number[], (number | null)[]] => [
    Array.from(line.t), Array.from(line.v, (v) => (Number.isFinite(v) ? v : null)),
  ]);
  return uPlot.join(tables as unknown as uPlot.AlignedData[]);
}

/** All plots of the selected vehicle, with one cursor. */
class Plots extends Part {
  private readonly plots = new Map<string, {plot: uPlot; drawn: string; range?: [number, number]}>();
  private turn = 0;
  private readonly rebuild = () => {
    for (const {plot} of this.plots.values()) plot.destroy();
    this.plots.clear();
  };
  private readonly observer = new ResizeObserver(() => this.rebuild());

  override connectedCallback(): void {
    super.connectedCallback();
    themeListeners.add(this.rebuild);
    this.observer.observe(this);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    themeListeners.delete(this.rebuild);
    this.observer.disconnect();
    this.rebuild();
  }

  /** Forgets the ranges that were widened or zoomed. */
  reset(): void {
    this.rebuild();
  }

  private specs(): (PlotSpec & {found: {line: Line; series: Series}[]})[] {
    const {bench, source} = page;
    return plotSpecs(bench.vehicle?.scene?.rotors.length ?? bench.vehicle?.sim?.rotors.length ?? 0, page.picked)
      .map((spec) => {
        const found = spec.lines.flatMap((line) => {
          const series = source.series(bench.selected, line.key);
          return series && series.t.length > 0 ? [{line, series}] : [];
        });
        for (const {line} of [...found]) {
          const other = line.colour === 'ref' ? undefined : source.beside?.(bench.selected, line.key);
          if (other && line.colour !== 'est') found.push({line: {...line, label: `${line.label} B`, dash: [4, 3], width: 1.1, beside: true}, series: other});
        }
        return {...spec, found};
      })
      .filter((spec) => spec.found.length > 0);
  }

  protected override render() {
    const specs = this.specs();
    if (specs.length === 0) return html`<p class="empty">Nothing to plot yet.</p>`;
    return html`<div class="plots">${specs.map((spec) => html`
      <section class="plot" data-id=${spec.id} aria-label=${spec.title}>
        <header><b>${spec.title}</b>
          ${spec.found.filter(({line}) => line.label).map(({line}) => html`<span class=${`c-${line.colour}`}>${line.label}</span>`)}
          ${spec.picked
            ? html`<button aria-label=${`Remove ${spec.picked}`} @click=${() => this.unpick(spec.picked!)}>✕</button>` : nothing}
        </header>
        <div class="u"></div><div class="cursor-t"></div>
      </section>`)}</div>`;
  }

  private unpick(key: string): void {
    page.picked.splice(page.picked.indexOf(key), 1);
    this.plots.get(`picked ${key}`)?.plot.destroy();
    this.plots.delete(`picked ${key}`);
    page.redraw();
  }

  private make(spec: PlotSpec & {found: {line: Line; series: Series}[]}, holder: HTMLElement): uPlot {
    const text = colour('t3');
    const grid = {stroke: colour('line'), width: 1};
    const font = `10px ${colour('sans')}`;
    return new uPlot({
      width: holder.clientWidth, height: 106, legend: {show: false}, padding: [6, 0, 0, 8],
      cursor: {sync: {key: 'cas'}, points: {show: false}, y: false, drag: {x: true, y: false, setScale: Boolean(page.source.player)}},
      scales: {x: {time: false}},
      axes: [
        {stroke: text, grid, ticks: {show: false}, font, size: 18, gap: 2, values: (u, all) => all.map((v) => (v > u.scales.x!.max! - (u.scales.x!.max! - u.scales.x!.min!) * 0.06 ? '' : String(v)))},
        {stroke: text, grid, ticks: {show: false}, font, side: 1, size: 38, gap: 4, splits: niceSplits, values: (_, all) => all.map((v) => fixed(v, Math.abs(v) < 10 && spec.digits ? spec.digits : 0))},
      ],
      series: [{}, ...spec.found.map(({line}) => ({
        stroke: colour(line.colour), width: line.width ?? 1.4, dash: line.dash, points: {show: false}, spanGaps: true,
      }))],
      hooks: {
        drawClear: [(u: uPlot) => this.drawSpans(u)],
        draw: [(u: uPlot) => this.drawLimit(u, spec)],
        ready: [(u: uPlot) => {
          u.over.addEventListener('click', (event) => {
            page.source.player?.seek(u.posToVal(event.offsetX, 'x'));
            page.redraw();
          });
        }],
      },
    }, [[0], ...spec.found.map(() => [null])] as unknown as uPlot.AlignedData, holder);
  }

  private drawSpans(u: uPlot): void {
    for (const fault of page.bench.faults) {
      const a = u.valToPos(fault.begin_s, 'x', true);
      const b = u.valToPos(fault.end_s ?? page.bench.duration_s ?? fault.begin_s, 'x', true);
      const [l, r] = [Math.max(a, u.bbox.left), Math.min(b, u.bbox.left + u.bbox.width)];
      if (r <= l) continue;
      u.ctx.save();
      u.ctx.globalAlpha = 0.16;
      u.ctx.fillStyle = colour('amber');
      u.ctx.fillRect(l, u.bbox.top, Math.max(2, r - l), u.bbox.height);
      u.ctx.restore();
    }
  }

  private drawLimit(u: uPlot, spec: PlotSpec): void {
    const limit = spec.limit?.();
    if (!limit) return;
    const y = u.valToPos(limit.value, 'y', true);
    if (y < u.bbox.top || y > u.bbox.top + u.bbox.height) return;
    const ratio = window.devicePixelRatio || 1;
    u.ctx.save();
    u.ctx.strokeStyle = u.ctx.fillStyle = colour('amber');
    u.ctx.lineWidth = ratio;
    u.ctx.setLineDash([4 * ratio, 3 * ratio]);
    u.ctx.beginPath();
    u.ctx.moveTo(u.bbox.left, y);
    u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
    u.ctx.stroke();
    u.ctx.font = `500 ${10 * ratio}px ${colour('sans')}`;
    u.ctx.textAlign = 'left';
    u.ctx.fillText(limit.text, u.bbox.left + 2 * ratio, y - 4 * ratio);
    u.ctx.restore();
  }

  /** One plot a frame gets new data; the cursor of time moves in all of them. */
  protected override frame(): void {
    const sections = [...this.querySelectorAll<HTMLElement>('.plot')];
    if (sections.length === 0 || this.clientWidth === 0) return;
    const t = page.bench.time_s ?? 0;
    const player = page.source.player;
    const missing = sections.filter((section) => !this.plots.has(section.dataset.id!));
    this.turn = (this.turn + 1) % sections.length;
    const due = missing.length > 0 ? missing : player ? [] : [sections[this.turn]!];
    if (due.length > 0) {
      const specs = this.specs();
      for (const section of due) {
        const spec = specs.find((each) => each.id === section.dataset.id);
        if (spec) this.fill(spec, section.querySelector<HTMLElement>('.u')!, t);
      }
    }
    for (const section of sections) {
      const entry = this.plots.get(section.dataset.id!);
      const cursor = section.querySelector<HTMLElement>('.cursor-t')!;
      const x = entry && player ? entry.plot.valToPos(t, 'x') : -1;
      const inside = entry && x >= 0 && x <= entry.plot.over.clientWidth;
      const to = inside ? `translateX(${Math.round(x + 22)}px)` : 'translateX(-9999px)';
      if (cursor.style.transform !== to) cursor.style.transform = to;
    }
  }

  private fill(spec: PlotSpec & {found: {line: Line; series: Series}[]}, holder: HTMLElement, t: number): void {
    const shape = spec.found.map(({line}) => line.key + line.label).join();
    let entry = this.plots.get(spec.id);
    if (entry && entry.drawn !== shape) {
      entry.plot.destroy();
      entry = undefined;
    }
    if (!entry) {
      holder.replaceChildren();
      entry = {plot: this.make(spec, holder), drawn: shape};
      this.plots.set(spec.id, entry);
    }
    const player = page.source.player;
    const [from, to] = player ? [0, player.duration_s] : [t - kLive_s, t];
    const shown = spec.found.map(({series}) => thinned(series, from, to));
    entry.range = widened(player ? undefined : entry.range, shown, spec.limit?.()?.value);
    entry.plot.batch(() => {
      entry.plot.setData(aligned(shown), false);
      entry.plot.setScale('x', {min: from, max: to});
      entry.plot.setScale('y', {min: entry.range![0], max: entry.range![1]});
    });
  }
}

/** Three lines: bottom, middle, top. */
function niceSplits(u: uPlot): number[] {
  const {min, max} = u.scales.y!;
  return min === undefined || max === undefined || min === null || max === null ? [] : [min, (min + max) / 2, max];
}

/** A range that holds all values, and only widens while it is live. */
export function widened(before: [number, number] | undefined, shown: Series[], also?: number): [number, number] {
  let [low, high] = before ?? [Infinity, -Infinity];
  for (const {v} of shown) {
    for (let i = 0; i < v.length; ++i) {
      const value = v[i]!;
      if (!Number.isFinite(value)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (also !== undefined) high = Math.max(high, also * 1.2);
  if (low > high) return [0, 1];
  if (also !== undefined) low = Math.min(low, 0);
  const least = Math.max(1e-3, Math.abs(high) * 0.01);
  if (high - low < least) return [low - least, high + least];
  const step = 10 ** Math.floor(Math.log10(high - low)) / 2;
  const steps = [Math.floor(low / step + 1e-9), Math.ceil(high / step - 1e-9)] as const;
  const even = (steps[1] - steps[0]) % 2 === 0 ? 0 : 1;  // the middle is a step, too
  return [steps[0] * step, (steps[1] + even) * step];
}

customElements.define('cas-plots', Plots);
