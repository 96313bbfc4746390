// SPDX-License-Identifier: BSD-3-Clause
import {html, svg, nothing, type TemplateResult} from 'lit';
import {isMark} from './bench.ts';
import {clean, minutes, tickStep} from './numbers.ts';
import {page, Part} from './page.ts';
import type {Happening, Stage} from './protocol.ts';

/** Ticks nearer than this are drawn as one with a count. */
const kNear_px = 112;

/** Longest past that a live bench shows. */
const kLive_s = 600;

/** Moments of ticks that share a place: the first of each group, and how many there are. */
export function grouped(events: Happening[], x: (t: number) => number, near = kNear_px): {event: Happening; count: number}[] {
  const groups: {event: Happening; count: number}[] = [];
  let last = -Infinity;
  for (const event of events) {
    const at = x(event.t_s);
    if (at - last < near && groups.length > 0) {
      groups.at(-1)!.count++;
    } else {
      groups.push({event, count: 1});
      last = at;
    }
  }
  return groups;
}

/** The next mark after a moment, or the last before it. */
export function nextMark(marks: {t_s: number}[], t: number, backward = false): number | undefined {
  const times = marks.map((mark) => mark.t_s).sort((a, b) => a - b);
  return backward ? times.findLast((each) => each < t - 0.25) : times.find((each) => each > t + 0.001);
}

/** Marks of the flight, or where there is none its stages. */
export function stops(): {t_s: number}[] {
  const {marks, stages} = page.bench;
  return marks.length > 0 ? marks : stages.map((stage) => ({t_s: stage.begin_s}));
}

/** Stages, faults and events over the run; in a record it is the scrubber. */
class Timeline extends Part {
  private width = 0;
  private height = 0;
  private dragging = false;
  private readonly observer = new ResizeObserver(() => {
    this.width = this.parentElement!.clientWidth;
    this.height = this.parentElement!.clientHeight;
    this.requestUpdate();
  });

  override connectedCallback(): void {
    super.connectedCallback();
    this.observer.observe(this.parentElement!);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.observer.disconnect();
  }

  private get range(): [number, number] {
    const {duration_s, time_s} = page.bench;
    if (page.source.player) return [0, duration_s ?? 1];
    const now = time_s ?? 0;
    if (now > kLive_s) return [now - 0.9 * kLive_s, now + 0.1 * kLive_s];
    return [0, Math.max(60, Math.ceil((now + 5) / 30) * 30)];
  }
  private x(t: number): number {
    const [a, b] = this.range;
    return 14 + ((t - a) / Math.max(1e-6, b - a)) * (this.width - 28);
  }

  protected override frame(): void {
    const head = this.querySelector<SVGElement>('.playhead');
    const {time_s} = page.bench;
    if (!head || time_s === null) return;
    const to = `translate(${(Math.round(this.x(time_s) * 2) / 2).toFixed(1)} 0)`;
    if (head.getAttribute('transform') !== to) head.setAttribute('transform', to);
  }

  protected override render() {
    const {bench} = page;
    if (this.width === 0) return nothing;
    const player = page.source.player;
    const [W, H] = [this.width, this.height];
    const floor = H - 20;
    const label = player ? 'Time in the record' : 'Timeline';
    const drawing = svg`
      ${this.area(floor)}
      ${bench.stages.map((stage) => this.stage(stage))}
      ${bench.faults.map((fault) => this.fault(fault, floor))}
      ${grouped(bench.happenings.filter((event) => isMark(event) && event.kind !== 'fault'), (t) => this.x(t)).map(({event, count}) => this.event(event, count, floor))}
      ${this.axis(H)}
      <g class="playhead"><path d=${`M0 6V${floor + 2}`} stroke="var(--t1)" stroke-width="1.6"></path>
        <path d="M-5 4h10l-5 7z" fill="var(--t1)"></path></g>`;
    return player
      ? html`<svg width=${W} height=${H} role="slider" tabindex="0" aria-label=${label} aria-valuemin="0"
          aria-valuemax=${player.duration_s.toFixed(2)} aria-valuenow=${(bench.time_s ?? 0).toFixed(2)}
          aria-valuetext=${`${minutes(bench.time_s ?? 0, 2)} of ${minutes(player.duration_s, 1)}`}
          @pointerdown=${this.down} @pointermove=${this.move} @pointerup=${this.up} @pointercancel=${this.up}>${drawing}</svg>`
      : html`<svg width=${W} height=${H} role="img" aria-label=${label}>${drawing}</svg>`;
  }

  private readonly down = (event: PointerEvent) => {
    this.dragging = true;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    this.scrub(event);
  };
  private readonly move = (event: PointerEvent) => {
    if (this.dragging) this.scrub(event);
  };
  private readonly up = () => {
    this.dragging = false;
  };
  private scrub(event: PointerEvent): void {
    const [a, b] = this.range;
    const left = (event.currentTarget as Element).getBoundingClientRect().left;
    page.source.player?.seek(a + ((event.clientX - left - 14) / (this.width - 28)) * (b - a));
    page.redraw();
  }

  /** Height over time as an area. */
  private area(floor: number): TemplateResult | typeof nothing {
    const series = page.source.series(page.bench.selected, 'truth.u') ?? page.source.series(page.bench.selected, 'est.u');
    if (!series || series.t.length < 2) return nothing;
    const [a, b] = this.range;
    let most = 1;
    const step = Math.max(1, Math.floor(series.t.length / 800));
    for (let i = 0; i < series.t.length; i += step) most = Math.max(most, series.v[i]!);
    let d = '';
    let lastX = 0;
    for (let i = 0; i < series.t.length; i += step) {
      const t = series.t[i]!;
      if (t < a || t > b) continue;
      lastX = this.x(t);
      const y = floor - (Math.max(0, series.v[i]!) / most) * (floor - 52);
      d += `${d === '' ? `M${lastX.toFixed(1)} ${floor}` : ''}L${lastX.toFixed(1)} ${y.toFixed(1)}`;
    }
    return d === '' ? nothing : svg`<path d=${`${d}L${lastX.toFixed(1)} ${floor}z`} fill="var(--raised)" stroke="var(--t3)"></path>` as TemplateResult;
  }

  private stage(stage: Stage): TemplateResult {
    const [a, b] = [this.x(stage.begin_s), this.x(stage.end_s)];
    const undone = stage.finished === false;
    const name = clean(undone ? `${stage.name} · not done` : stage.measured ? `${stage.name} · measured` : stage.name);
    const fits = b - a > name.length * 6.2 + 12;
    const short = stage.measured && b - a > 66 ? 'measured' : '';
    return svg`<rect x=${a + 1} y="12" width=${Math.max(1, b - a - 2)} height="18" rx="3"
        fill=${`var(--${stage.measured ? 'accbg' : 'raised'})`} stroke=${`var(--${undone ? 'red' : stage.measured ? 'acc' : 'line'})`}></rect>
      ${fits || short ? svg`<text x=${a + 8} y="25" font-size="10.5" font-weight="500"
        fill=${`var(--${stage.measured ? 'acc' : 't2'})`}>${fits ? name : short}</text>` : nothing}` as TemplateResult;
  }

  private fault(fault: {name: string; begin_s: number; end_s: number | null}, floor: number): TemplateResult {
    const a = this.x(fault.begin_s);
    const b = this.x(fault.end_s ?? this.range[1]);
    const before = a > 90;
    return svg`<rect x=${a} y="34" width=${Math.max(3, b - a)} height=${floor - 34} fill="var(--amber)" opacity=".22"></rect>
      <path d=${`M${a} 34V${floor}`} stroke="var(--amber)" stroke-width="1.5"></path>
      <text x=${before ? a - 4 : b + 4} y="44" font-size="11" font-weight="600" fill="var(--amber)"
        text-anchor=${before ? 'end' : 'start'}>${clean(fault.name)}</text>` as TemplateResult;
  }

  private event(event: Happening, count: number, floor: number): TemplateResult {
    const x = this.x(event.t_s);
    const colour = event.severity <= 3 ? 'red' : event.severity === 4 ? 'amber' : 't3';
    const text = count > 1 ? `${count} events` : clean(event.text).slice(0, 20);
    const room = this.width - x > 130;
    return svg`<path d=${`M${x} 36V${floor}`} stroke=${`var(--${colour === 't3' ? 'line' : colour})`}></path>
      <text x=${room ? x + 4 : x - 4} y="44" font-size="10.5" fill=${`var(--${colour})`}
        text-anchor=${room ? 'start' : 'end'}>${text}</text>` as TemplateResult;
  }

  private axis(H: number): TemplateResult[] {
    const [a, b] = this.range;
    const step = tickStep(b - a, this.width);
    const ticks: TemplateResult[] = [];
    for (let t = Math.ceil(a / step) * step; t <= b; t += step) {
      const anchor = this.x(t) > this.width - 24 ? 'end' : 'middle';
      ticks.push(svg`<text x=${this.x(t)} y=${H - 5} font-size="10" fill="var(--t3)" text-anchor=${anchor}>${t}${t === 0 ? ' s' : ''}</text>` as TemplateResult);
    }
    return ticks;
  }
}
customElements.define('cas-timeline', Timeline);

const kSpeeds = [0.1, 0.2, 0.5, 1, 2, 5, 10];

/** Goes one speed up or down. */
export function nextSpeed(speed: number, up: boolean): number {
  return up ? (kSpeeds.find((each) => each > speed + 1e-9) ?? 10) : (kSpeeds.findLast((each) => each < speed - 1e-9) ?? 0.1);
}

/** Goes to the next or the previous mark. */
export function jump(backward: boolean): void {
  const player = page.source.player;
  const to = player && nextMark(stops(), player.time_s, backward);
  if (player) player.seek(to ?? (backward ? 0 : player.duration_s));
  page.redraw();
}

/** Play, speed and jumps of a record. */
class PlayerControls extends Part {
  protected override render() {
    const player = page.source.player;
    if (!player) return nothing;
    const icon = (d: string) => html`<svg width="14" height="14" viewBox="0 0 14 14" fill="currentColor" aria-hidden="true"><path d=${d}></path></svg>`;
    return html`<div class="play">
        <button aria-label="To the start" @click=${() => (player.seek(0), page.redraw())}>${icon('M2 2h2v10H2zM12 2v10L5 7z')}</button>
        <button class="pri run-it" aria-label=${player.playing ? 'Pause' : 'Play'} @click=${() => (player.play(!player.playing), page.redraw())}>
          ${icon(player.playing ? 'M3 2h3v10H3zM8 2h3v10H8z' : 'M3 1.5v11L12.5 7z')}</button>
        <button aria-label="To the end" @click=${() => (player.seek(player.duration_s), page.redraw())}>${icon('M10 2h2v10h-2zM2 2v10l7-5z')}</button>
        <select aria-label="Speed" .value=${String(player.speed)} @change=${(event: Event) => {
          player.speed = Number((event.target as HTMLSelectElement).value);
        }}>${kSpeeds.map((speed) => html`<option value=${speed} ?selected=${speed === player.speed}>${speed} ×</option>`)}</select>
      </div>
      <div class="play">
        <button class="text" @click=${() => jump(true)}>Previous<kbd>P</kbd></button>
        <button class="text" @click=${() => jump(false)}>Next event<kbd>N</kbd></button>
      </div>`;
  }
}
customElements.define('cas-player', PlayerControls);
