// SPDX-License-Identifier: BSD-3-Clause
import {html, svg, nothing, type TemplateResult} from 'lit';
import {age, delay, delayPair, fixed, grouped, rate} from './numbers.ts';
import {page, Part} from './page.ts';
import type {Hop, LoopFigures, TapePacket} from './protocol.ts';

type Tone = '' | 'amber' | 'red';

interface Row {
  label: string;
  value: string;
  tone?: Tone;
}

interface Node {
  x: number;
  y: number;
  w: number;
  h: number;
  title: string;
  sub: string;
  rows: Row[];
  missing?: boolean;
}

const kTapePlay_s = 4;

function seriesOf(id: number): string {
  const known: Record<number, string> = {107: 'est', 113: 't1', 91: 'act', 93: 'act'};
  return known[Math.abs(id)] ?? 't3';
}

/** Worst state that a hop's figures are in by the bounds of the bench. */
export function toneOfHop(hop: Hop | undefined, nominal: Record<string, number>): Tone {
  if (!hop) return '';
  if (hop.state === 'down') return 'red';
  let tone: Tone = hop.state === 'opening' ? 'amber' : '';
  for (const [name, hz] of Object.entries(hop.msgs)) {
    const wanted = nominal[name];
    if (!wanted || wanted < 20) continue;
    if (hz < 0.9 * wanted) return 'red';
    if (hz < 0.99 * wanted) tone = 'amber';
  }
  if (hop.us && hop.us.p99 > 10_000) return 'red';
  if (hop.us && hop.us.p99 > 4_000) tone = 'amber';
  if (hop.full !== undefined && hop.full >= 0.9) return 'red';
  if (hop.full !== undefined && hop.full >= 0.8) tone = 'amber';
  return tone;
}

/** HIL packets that casd dropped before the hop, for any cause. */
function droppedBy(hop: Hop): number {
  return Object.values(hop.dropped ?? {}).reduce((sum, count) => sum + count, 0);
}

/** The way of the packets: simulator, casd, controller, with the figures of the hops between them. */
class Links extends Part {
  private width = 0;
  private height = 0;
  private shownTape: unknown;
  private tapeBegan_s = 0;
  private played = -1;
  private readonly observer = new ResizeObserver(() => {
    this.width = this.clientWidth;
    this.height = this.clientHeight;
    this.requestUpdate();
  });

  override connectedCallback(): void {
    super.connectedCallback();
    this.observer.observe(this.parentElement!);
    this.width = this.parentElement!.clientWidth;
    this.height = this.parentElement!.clientHeight;
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.observer.disconnect();
  }

  /** The tape is played 200 times slower: packets that have not left yet are faint. */
  protected override frame(now_s: number): void {
    const {tape, time_s} = page.bench;
    if (tape !== this.shownTape) {
      this.shownTape = tape;
      this.tapeBegan_s = now_s;
      this.played = -1;
      this.requestUpdate();
    }
    if (!tape) return;
    const passed = page.source.player ? (time_s ?? 0) - tape.t_s : now_s - this.tapeBegan_s;
    const share = matchMedia('(prefers-reduced-motion: reduce)').matches ? 1 : Math.max(0, Math.min(1, passed / kTapePlay_s));
    const step = Math.round(share * 240);  // finer is no pixel
    if (step === this.played) return;
    this.played = step;
    for (const head of this.querySelectorAll<SVGElement>('.head')) {
      const {x0, x1} = head.dataset as {x0: string; x1: string};
      head.setAttribute('transform', `translate(${Number(x0) + share * (Number(x1) - Number(x0))} 0)`);
    }
    for (const bar of this.querySelectorAll<SVGElement>('.packet')) {
      const opacity = Number(bar.dataset.at) <= share ? '0.95' : '0.28';
      if (bar.getAttribute('opacity') !== opacity) bar.setAttribute('opacity', opacity);
    }
  }

  private hop(from: string, to: string): Hop | undefined {
    return page.bench.hops.find((hop) => hop.from === from && hop.to === to);
  }

  /** Figures of the loop, unless they are old. */
  private get loop(): LoopFigures | undefined {
    return page.bench.old.has('loop') ? undefined : page.bench.loop;
  }

  protected override render() {
    const {links, old} = page.bench;
    const old_s = old.get('links');
    if (this.width === 0) return nothing;
    const hasCasd = !links || links.hops.some((hop) => hop.to === 'casd') || links.hops.length === 0;
    const narrow = this.width < 640;
    const drawing = narrow ? this.drawNarrow(hasCasd) : this.drawWide(hasCasd);
    const height = narrow ? this.narrowHeight(hasCasd) : this.height;
    return html`
      ${old_s === undefined ? nothing : html`<span class="stale news">links: ${age(old_s)}</span>`}
      <svg class=${old_s === undefined ? '' : 'old'} width=${this.width} height=${height} aria-hidden="true">
        <defs><pattern id="hatch" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
          <rect width="1" height="7" fill="var(--hatch)"></rect></pattern></defs>
        ${drawing}
      </svg>
      ${this.twin()}`;
  }

  /** The same as a table, for who does not see the drawing. */
  private twin(): TemplateResult {
    const {loop} = this;
    return html`<div class="twin"><table><caption>Links</caption>
      <tr><th>Hop</th><th>Rates</th><th>Delay</th><th>Lost</th></tr>
      ${page.bench.hops.map((hop) => html`<tr><td>${hop.from} to ${hop.to}</td>
        <td>${Object.entries(hop.msgs).map(([name, hz]) => `${name} ${fixed(hz, 1)} per second`).join(', ')}</td>
        <td>${hop.us ? delayPair(hop.us) : 'not measured'}</td><td>${hop.lost ?? 'not counted'}${
          Object.entries(hop.dropped ?? {}).map(([cause, count]) => `, ${count} dropped by casd (${cause})`)}</td></tr>`)}
      <tr><td>Loop</td><td></td><td>${loop ? `${fixed(loop.ms.p50)} ms, 99 % ${fixed(loop.ms.p99)} ms` : 'not measured'}</td><td></td></tr>
    </table></div>`;
  }

  private nodes(): {simulator: Row[]; casd: Row[]; controller: Row[]; subs: [string, string, string]; missing: boolean[]} {
    const {bench} = page;
    const pair = (from: string) => {
      const us = bench.forward(from);
      if (!us) return '–';
      return us.p99 < 10 ? 'under 10 µs' : `${Math.round(us.p50)} · ${Math.round(us.p99)} µs`;
    };
    const missing = (name: string) => bench.programs.some((each) => each.name === name && each.state !== 'up');
    const out = this.hop('casd', 'fcu');
    const state = bench.vehicle?.state;
    const time = bench.virtual ? 'virtual clock' : bench.rate === undefined ? '–' : `${fixed(bench.rate, 3)} × real`;
    const simulator: Row[] = [{label: 'time', value: time}];
    if (bench.lateSteps !== undefined) simulator.push({label: 'late steps', value: String(bench.lateSteps), tone: bench.lateSteps > 0 ? 'amber' : ''});
    const sensors = (this.hop('sim', 'casd') ?? this.hop('sim', 'fcu'))?.msgs.HIL_SENSOR;
    if (sensors !== undefined) simulator.push({label: 'sensors', value: rate(sensors)});
    const casd: Row[] = [{label: 'forwards →', value: pair('sim')}, {label: 'forwards ←', value: pair('fcu')}];
    if (out?.queued !== undefined) casd.push({label: 'queue', value: `${out.queued} · ${out.high_water ?? 0} at most`});
    const controller: Row[] = [];
    if (state) {
      const limit = state.silent_after_s ?? 3;
      const old = (state.heartbeat_age_s ?? 0) > limit;
      controller.push({label: 'state', value: `${state.hil ? 'HIL · ' : ''}${state.armed ? 'armed' : 'disarmed'}`, tone: old ? 'red' : ''});
      if (state.heartbeat_age_s !== undefined) {
        const s = state.heartbeat_age_s;
        controller.push({label: 'heartbeat', value: `${fixed(s, 1)} s ago`, tone: s > limit ? 'red' : s > limit / 2 ? 'amber' : ''});
      }
    }
    const controls = this.hop('fcu', 'casd') ?? this.hop('fcu', 'sim');
    const answered = controls && Object.entries(controls.msgs).find(([name]) => name.includes('CONTROLS'));
    if (answered) controller.push({label: 'controls', value: rate(answered[1])});
    return {
      simulator, casd, controller,
      subs: ['hilsim', 'per link', bench.controller || (state?.autopilot ?? '')],
      missing: [missing('hilsim'), missing('casd'), !state && !page.source.player],
    };
  }

  private drawNode(node: Node): TemplateResult {
    const {x, y, w, h} = node;
    return svg`<g>
      <rect x=${x} y=${y} width=${w} height=${h} rx="7" fill="var(--raised)" stroke="var(--line)"
        stroke-dasharray=${node.missing ? '4 4' : 'none'}></rect>
      ${node.missing ? svg`<rect x=${x} y=${y} width=${w} height=${h} rx="7" fill="url(#hatch)"></rect>` : nothing}
      <text x=${x + 13} y=${y + 22} fill="var(--t1)" font-size="14" font-weight="600">${node.title}</text>
      <text x=${x + w - 13} y=${y + 22} fill="var(--t3)" font-size="11" text-anchor="end">${node.sub}</text>
      ${node.rows.map((row, i) => svg`
        <text x=${x + 13} y=${y + 42 + i * 17} font-size="11" fill=${`var(--${row.tone || 't3'})`}>${row.label}</text>
        <text x=${x + w - 13} y=${y + 42 + i * 17} font-size="12" font-weight="500" text-anchor="end"
          fill=${`var(--${row.tone || 't1'})`}>${row.value}</text>`)}
    </g>` as TemplateResult;
  }

  /** An arrow from x0 to x1 (or back) as a tape of packets; true lengths and gaps. */
  private drawLane(x0: number, x1: number, y: number, h: number, back: boolean, hop: Hop | undefined, key: string): TemplateResult {
    const {tape, nominal_hz} = page.bench;
    const window_us = (tape?.ms ?? 20) * 1000;
    const tone = toneOfHop(hop, nominal_hz);
    const dead = hop?.state === 'down' || tone === 'red';
    const stroke = dead ? 'red' : 'line';
    const head = back ? x0 : x1;
    const g = back ? -1 : 1;
    // The begin of the tape is at the arrow's head: the first packet is farthest.
    const at = (t: number) => (back ? x0 + (t / window_us) * (x1 - x0) : x1 - (t / window_us) * (x1 - x0));
    const packets: TapePacket[] = tape?.hops[key] ?? [];
    return svg`<g>
      <rect x=${x0} y=${y} width=${x1 - x0} height=${h} rx="3" fill="var(--tube)" stroke=${`var(--${stroke})`}
        stroke-dasharray=${dead ? '3 4' : 'none'}></rect>
      <path d=${`M${head + g} ${y - 2}l${g * 8} ${h / 2 + 2}l${-g * 8} ${h / 2 + 2}z`} fill=${`var(--${dead ? 'red' : 'ctl'})`}></path>
      ${packets.map(([id, t, wire]) => {
        const [a, b] = [at(t), at(Math.min(window_us, t + Math.max(0, wire)))];
        const left = Math.max(x0 + 1, Math.min(a, b));
        const w = Math.min(Math.max(2.5, Math.abs(b - a)), x1 - 1 - left);
        if (w <= 0) return nothing;
        if (id < 0) {
          return svg`<rect x=${left} y=${y + 2} width="9" height=${h - 4} rx="1" fill="none" stroke="var(--red)"></rect>`;
        }
        return svg`<rect class="packet" data-at=${t / window_us} x=${left} y=${y + 2.5} width=${w} height=${h - 5} rx="1"
          fill=${`var(--${seriesOf(id)})`} opacity="0.95"></rect>`;
      })}
      ${packets.length > 0
        ? svg`<path class="head" data-x0=${back ? x0 : x1} data-x1=${back ? x1 : x0} d=${`M0 ${y + 1}v${h - 2}`} stroke="var(--t3)"></path>`
        : nothing}
    </g>` as TemplateResult;
  }

  private labels(hop: Hop | undefined, x0: number, x1: number, y: number, lead: string): TemplateResult {
    const {nominal_hz} = page.bench;
    if (!hop) return svg`<text x=${x0} y=${y} font-size="12" fill="var(--t3)">${lead}–</text>` as TemplateResult;
    const short: Record<string, string> = {HIL_GPS: 'GPS', HIL_ACTUATOR_CONTROLS: 'HIL_ACTUATOR'};
    const colours: Record<string, string> = {HIL_SENSOR: 'est', HIL_GPS: 't1', HIL_CONTROLS: 'act', HIL_ACTUATOR_CONTROLS: 'act'};
    const main = Object.entries(hop.msgs).filter(([name]) => name.startsWith('HIL_') && name !== 'HIL_STATE_QUATERNION').sort(([, a], [, b]) => b - a);
    const other = Object.entries(hop.msgs).filter(([name]) => !name.startsWith('HIL_')).reduce((sum, [, hz]) => sum + hz, 0);
    const right = hop.state === 'down' ? 'link down'
      : hop.us ? delayPair(hop.us) : hop.measured === 'echo' ? 'measured as a loop' : 'delay not measured';
    const dropped = droppedBy(hop);
    const lost = (hop.lost ? ` · ${hop.lost} lost` : '') + (dropped ? ` · ${dropped} dropped` : '');
    const tone = toneOfHop(hop, nominal_hz);
    // Labels that do not fit are left out, the least first: the table beside the drawing has it all.
    const named = (name: string) => short[name] ?? name;
    const words = lead + main.map(([name, hz]) => `${rate(hz)} ${named(name)}`).join(' · ');
    const fits = (text: string) => (text.length + right.length + lost.length) * 6.7 + 12 < x1 - x0;
    let extra = other > 0.5 ? ` · ${Math.round(other)} other` : '';
    if (extra && !fits(words + extra)) extra = ` + ${Math.round(other)}`;
    if (extra && !fits(words + extra)) extra = '';
    const shown = fits(words + extra) ? main : main.slice(0, 1);
    const late = hop.us && hop.us.p99 > 10_000 ? 'red' : hop.us && hop.us.p99 > 4_000 ? 'amber' : 't2';
    return svg`
      <text x=${x0} y=${y} font-size="12" font-weight="500" fill=${`var(--${tone === 'red' || tone === 'amber' ? (late === 't2' ? tone : 't1') : 't1'})`}>${lead}${
        shown.map(([name, hz], i) => svg`<tspan>${i > 0 ? ' · ' : ''}${rate(hz)} </tspan><tspan fill=${`var(--${colours[name] ?? 't2'})`}>${named(name)}</tspan>`)}${extra}</text>
      <text x=${x1} y=${y} font-size="11.5" text-anchor="end" fill=${`var(--${hop.state === 'down' || lost ? 'red' : late})`}>${right}${lost}</text>` as TemplateResult;
  }

  private medium(up: Hop | undefined, down: Hop | undefined, note: string): string {
    const hop = up ?? down;
    if (!hop) return page.bench.noLinks;
    if (hop.type === 'none') return page.bench.noLinks || 'one process';
    if (hop.type !== 'serial') return hop.type === 'udp' ? `UDP${note}` : `${hop.type ?? ''}${note}`;
    const full = (each: Hop | undefined, arrow: string) => (each?.full === undefined ? '' : ` · ${arrow} ${Math.round(each.full * 100)} % full`);
    const baud = hop.baud ? ` ${grouped(hop.baud)} baud` : '';
    return `serial${baud}${full(up, '→')}${full(down, '←')}`;
  }

  private drawWide(hasCasd: boolean): TemplateResult {
    const W = this.width;
    const big = W >= 1600;
    const {simulator, casd, controller, subs, missing} = this.nodes();
    const [w1, w2, w3] = big ? [226, 262, 246] : [168, 196, 186];
    const [m, h, y] = big ? [20, 112, 18] : [14, 88, 14];
    const [x1, x3] = [m, W - m - w3];
    const x2 = (x1 + w1 + x3) / 2 - w2 / 2;
    const [lane, up, down, pad] = [big ? 20 : 16, y + (big ? 19 : 15), y + (big ? 72 : 57), 12];
    const {tape} = page.bench;
    const note = tape ? (tape.around === 'loss' ? ' · around a loss' : ` · ${tape.ms} ms, 200 × slower`) : '';
    const pairOf = (x0: number, x1: number, a: string, b: string, withNote: boolean) => {
      const [there, back] = [this.hop(a, b), this.hop(b, a)];
      return svg`
        ${this.labels(there, x0, x1 + 10, up - 7, '')}
        ${this.drawLane(x0, x1, up, lane, false, there, `${a}>${b}`)}
        <text x=${(x0 + x1) / 2 + 5} y=${(up + lane + down) / 2 + 4} font-size="11" fill="var(--t3)" text-anchor="middle">${
          this.medium(there, back, withNote ? note : '')}</text>
        ${this.drawLane(x0 + 10, x1 + 10, down, lane, true, back, `${b}>${a}`)}
        ${this.labels(back, x0, x1 + 10, down + lane + 15, '')}`;
    };
    const hops = hasCasd
      ? svg`${pairOf(x1 + w1 + pad, x2 - pad - 10, 'sim', 'casd', true)}${pairOf(x2 + w2 + pad, x3 - pad - 10, 'casd', 'fcu', false)}
          ${this.drawNode({x: x2, y, w: w2, h, title: 'casd', sub: subs[1], rows: casd, missing: missing[1]})}`
      : pairOf(x1 + w1 + pad, x3 - pad - 10, 'sim', 'fcu', true);
    return svg`
      ${this.drawNode({x: x1, y, w: w1, h, title: 'simulator', sub: subs[0], rows: simulator, missing: missing[0]})}
      ${hops}
      ${this.drawNode({x: x3, y, w: w3, h, title: 'controller', sub: subs[2], rows: controller, missing: missing[2]})}
      ${this.drawLoop(x1, x1 + w1, x1 + w1 + pad, x3 - pad, x3, y + h + (big ? 40 : 32), big ? 16 : 13)}` as TemplateResult;
  }

  /** One loop of the median, hop by hop, with a whisker to 99 %; open, it counts to the stop. */
  private drawLoop(xl: number, xv: number, x0: number, x1: number, xr: number, y: number, h: number): TemplateResult {
    const {bench} = page;
    const open_s = bench.loopOpen_s;
    const frameBar = svg`<rect x=${x0} y=${y} width=${x1 - x0} height=${h} rx="3" fill="var(--tube)" stroke="var(--line)"></rect>`;
    if (open_s !== undefined && open_s > 0.02) {
      return svg`<text x=${xl} y=${y + h - 4} font-size="12" font-weight="600" fill="var(--red)">Loop open</text>
        <text x=${xv} y=${y + h - 3} font-size="15" font-weight="600" text-anchor="end" fill="var(--red)">${fixed(open_s)} s</text>
        ${frameBar}<text x=${x0 + 8} y=${y + h - 3} font-size="11" fill="var(--red)">no control answers a sample</text>` as TemplateResult;
    }
    const {loop} = this;
    if (!loop) {
      const old_s = bench.old.get('loop');
      const why = bench.noLinks ? `Loop: ${bench.noLinks}` : old_s === undefined ? 'Loop: not measured yet' : `Loop: no figures for ${fixed(old_s, 0)} s`;
      return svg`<text x=${xl} y=${y + h - 4} font-size="12" fill="var(--t3)">${why}</text>` as TemplateResult;
    }
    const sensor = bench.nominal_hz.HIL_SENSOR ?? 0;
    const period = sensor > 0 ? 1000 / sensor : 2;
    const scale = Math.max(2.5 * period, Math.min(loop.ms.p99 * 1.02, 20 * period));
    const x = (ms: number) => x0 + Math.min(1, ms / scale) * (x1 - x0);
    const bound = bench.bounds.loop_p99_ms ?? Infinity;
    const tone = loop.ms.p99 > bound ? 'red' : loop.ms.p99 > bound / 2 ? 'amber' : 't1';
    const parts = this.loopParts(loop.ms.p50);
    let from = 0;
    let labelled = x0;  // how far the names of the parts reach
    return svg`<text x=${xl} y=${y + h - 4} font-size="12" fill="var(--t2)">Loop closes in</text>
      <text x=${xv} y=${y + h - 3} font-size="15" font-weight="600" text-anchor="end" fill="var(--t1)">${fixed(loop.ms.p50)} ms</text>
      ${frameBar}
      ${parts.map(({name, ms, colour}) => {
        const [a, b] = [x(from), x(from + ms)];
        from += ms;
        if (b - a > 120) labelled = a + (name.length + 6) * 6;
        return svg`<rect x=${a + 0.5} y=${y + 2} width=${Math.max(1.5, b - a - 1)} height=${h - 4} fill=${`var(--${colour})`} opacity=".85"></rect>
          ${b - a > 120 ? svg`<text x=${a + 1} y=${y - 6} font-size="11" fill="var(--t3)">${name} ${fixed(ms)}</text>` : nothing}`;
      })}
      <path d=${`M${x(period)} ${y - 4}v${h + 8}`} stroke="var(--t2)" stroke-dasharray="2 2"></path>
      ${Math.abs(x(period) - x(loop.ms.p99)) > 190 && x(period) > labelled
        ? svg`<text x=${x(period) + 5} y=${y - 6} font-size="11" fill="var(--t2)">${fixed(period)} next sample</text>` : nothing}
      <path d=${`M${x(loop.ms.p50)} ${y + h / 2}H${x(loop.ms.p99)}`} stroke="var(--t2)"></path>
      <path d=${`M${x(loop.ms.p99)} ${y + 2}v${h - 4}`} stroke=${`var(--${tone})`} stroke-width="2"></path>
      <text x=${x(loop.ms.p99) - 6} y=${y - 6} font-size="11" text-anchor="end" fill=${`var(--${tone})`}>99 %  ${fixed(loop.ms.p99)}</text>
      <text x=${xr} y=${y + h - 3} font-size="11" fill=${`var(--${bench.hops.some((hop) => droppedBy(hop) > 0) ? 'red' : 't2'})`}>${this.lostText()}</text>` as TemplateResult;
  }

  /** Hops of the median loop where each was measured on one clock; else one bracket. */
  private loopParts(whole: number): {name: string; ms: number; colour: string}[] {
    const us = (from: string, to: string) => this.hop(from, to)?.us?.p50;
    const forward = (from: string) => page.bench.forward(from)?.p50;
    const way: [string, number | undefined, string][] = [
      ['UDP', us('sim', 'casd'), 't3'], ['casd', forward('sim'), 'acc'], ['line to the controller', us('casd', 'fcu'), 'est'],
      ['line back', us('fcu', 'casd'), 'act'], ['casd', forward('fcu'), 'acc'],
    ];
    if (way.some(([, value]) => value === undefined)) return [{name: 'echo: there and back', ms: whole, colour: 't3'}];
    return way.map(([name, value, colour]) => ({name, ms: Math.max(0, value!) / 1000, colour}));
  }

  private lostText(): string {
    const {hops, bounds} = page.bench;
    const dropped = hops.reduce((sum, hop) => sum + droppedBy(hop), 0);
    const lost = `lost ${grouped(hops.reduce((sum, hop) => sum + (hop.lost ?? 0), 0))}`;
    if (dropped > 0) return `${lost} · casd dropped ${grouped(dropped)}`;
    return bounds.loop_p99_ms === undefined ? lost : `${lost} · bound ${bounds.loop_p99_ms} ms`;
  }

  private narrowHeight(hasCasd: boolean): number {
    return hasCasd ? 372 : 226;
  }

  private drawNarrow(hasCasd: boolean): TemplateResult {
    const W = this.width;
    const X = 16;
    const E = W - 26;
    const {casd, subs, missing} = this.nodes();
    let y = 14;
    const parts: TemplateResult[] = [];
    const node = (title: string, sub: string, h: number, isMissing: boolean, rows: Row[] = []) => {
      parts.push(this.drawNode({x: X, y, w: W - 32, h, title, sub, rows, missing: isMissing}));
      y += h;
    };
    const pair = (a: string, b: string) => {
      const [there, back] = [this.hop(a, b), this.hop(b, a)];
      parts.push(svg`${this.labels(there, X + 4, E + 8, y + 19, '↓ ')}${this.drawLane(X + 4, E, y + 26, 14, false, there, `${a}>${b}`)}
        ${this.drawLane(X + 14, E + 8, y + 48, 14, true, back, `${b}>${a}`)}${this.labels(back, X + 4, E + 8, y + 79, '↑ ')}` as TemplateResult);
      y += 92;
    };
    node('simulator', subs[0], 34, missing[0]!);
    pair('sim', hasCasd ? 'casd' : 'fcu');
    if (hasCasd) {
      node('casd', '', 52, missing[1]!, [{label: 'forwards', value: casd.slice(0, 2).map((row, i) => `${'↓↑'[i]} ${row.value}`).join('  ')}]);
      pair('casd', 'fcu');
    }
    node('controller', subs[2], 34, missing[2]!);
    const {loop} = this;
    parts.push(svg`<text x=${X} y=${y + 23} font-size="12" fill="var(--t2)">Loop closes in</text>
      <text x=${X + 92} y=${y + 23} font-size="13" font-weight="600" fill="var(--t1)">${loop ? delay(loop.ms.p50 * 1000) : '–'}</text>
      <text x=${W - X} y=${y + 23} font-size="11" text-anchor="end" fill="var(--t2)">99 %: ${loop ? delay(loop.ms.p99 * 1000) : '–'}</text>` as TemplateResult);
    return svg`${parts}` as TemplateResult;
  }
}

customElements.define('cas-links', Links);
