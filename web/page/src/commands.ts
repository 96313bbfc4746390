// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing} from 'lit';
import {Hold} from './hold.ts';
import {clean, fixed} from './numbers.ts';
import {page, Part} from './page.ts';
import {kBefore} from './verdict.ts';

const kModes = ['HOLD', 'POSCTL', 'ALTCTL', 'STABILIZED', 'MISSION', 'RTL', 'LAND', 'OFFBOARD'];
const kTakeoff_m = 2.5;
const kHoldDown_s = 1;
const kAskAgain_s = 5;

/** Says why no place can be gone to. */
export function refuseGoto(): void {
  page.goto = null;
  page.refusal = `Vehicle ${page.bench.vehicle?.system ?? ''} has not told where its home is: a place cannot be put into its frame.`;
  page.redraw();
}

export const actions = {
  land: () => void page.command('vehicle.land'),
  hold: () => void page.command('vehicle.hold'),
  arm: () => page.ask(`Arm vehicle ${page.bench.vehicle?.system}?`, 'Arm', (vehicle) => void page.command('vehicle.arm', {vehicle})),
  takeoff: () => page.ask(`Take off to ${fixed(kTakeoff_m, 1)} m?`, 'Take off',
    (vehicle) => void page.command('vehicle.takeoff', {vehicle, altitude_m: kTakeoff_m})),
  goto: () => {
    if (!page.bench.originOf()) return refuseGoto();
    const up = page.bench.motion()?.motion.p[2] ?? kTakeoff_m;
    page.goto = page.goto ? null : {vehicle: page.bench.vehicle?.system, north_m: 0, east_m: 0, up_m: Math.max(1, Math.round(up * 4) / 4)};
    page.redraw();
  },
  disarm: () => void page.command('vehicle.disarm'),
};

/** Arm, take off, land, hold, go to, mode; commands that reduce safety ask first. */
class Commands extends Part {
  private readonly hold = new Hold(kHoldDown_s);
  private held?: Element;
  private heldVehicle?: number;
  private asked = page.question;
  private focused: Element | null = null;
  /** No frame is drawn in a hidden tab, and no end of the press seen. */
  private readonly onHidden = () => this.hold.up();

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener('visibilitychange', this.onHidden);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener('visibilitychange', this.onHidden);
  }

  protected override frame(now_s: number): void {
    if (page.question && now_s > page.question.until_s) page.answer(false);
    if (!this.held?.isConnected || this.heldVehicle !== page.bench.vehicle?.system) this.hold.up();
    if (this.hold.tick(now_s)) void page.command('vehicle.disarm', {vehicle: this.heldVehicle, force: true});
  }

  protected override render() {
    const why = page.bench.interlock;
    return html`<div class="sect" id="commands" tabindex="-1"><h2>Commands</h2>
      ${page.question ? this.question() : nothing}
      ${why ? html`<p>${why}</p>` : this.buttons()}
      <cas-sticks></cas-sticks>
      ${page.refusal ? html`<p class="refused" role="alert">${clean(page.refusal)}</p>` : nothing}
      ${page.goto && !page.question ? html`<p>Click on the ground; the wheel changes the height, ${fixed(page.goto.up_m)} m up. Esc leaves.</p>` : nothing}
    </div>`;
  }

  /** Enter answers a question, and nothing is pressed again; then the focus goes back. */
  protected override updated(): void {
    if (this.asked === page.question) return;
    if (!this.asked) this.focused = document.activeElement;
    this.asked = page.question;
    const next = page.question ? this.querySelector('.ask .pri') : this.focused;
    (next as HTMLElement | null)?.focus({preventScroll: true});
  }

  private question() {
    const question = page.question!;
    return html`<div class="ask" role="alertdialog" aria-label=${question.text}><span>${question.text}</span>
      <button class="pri" @click=${() => page.answer(true)}>${question.yes} ↵</button>
      <button @click=${() => page.answer(false)}>No</button></div>`;
  }

  private button(text: string, key: string, method: string, act: () => void) {
    const since = page.underWay.get(method);
    return html`<button ?disabled=${since !== undefined} @click=${act}>${since === undefined ? text : `${fixed(page.now_s - since, 1)} s`}${
      key && since === undefined ? html`<kbd class="optional">${key}</kbd>` : nothing}</button>`;
  }

  private buttons() {
    const state = page.bench.vehicle?.state;
    const flying = state?.landed !== undefined && state.landed !== 'on_ground';
    const disarm = flying ? html`<button class="dng" aria-label="Disarm in the air: hold for one second" title="Hold for one second"
        @pointerdown=${this.down} @pointerup=${this.up} @pointercancel=${this.up} @lostpointercapture=${this.up}>Disarm 1 s</button>`
      : html`<button class="dng" @click=${actions.disarm}>Disarm</button>`;
    const [land, hold] = [this.button('Land', 'L', 'vehicle.land', actions.land), this.button('Hold', 'H', 'vehicle.hold', actions.hold)];
    if (page.question) return html`<div class="btns">${land}${hold}${state?.armed ? disarm : nothing}</div>`;
    return html`<div class="btns">
      ${land}
      ${hold}
      ${this.button('Go to…', 'G', 'vehicle.goto', actions.goto)}
      ${this.button('Take off', 'T', 'vehicle.takeoff', actions.takeoff)}
      <select aria-label="Mode" @change=${(event: Event) => {
        const select = event.target as HTMLSelectElement;
        if (select.value) void page.command('vehicle.mode', {mode: select.value});
        select.value = '';
      }}><option value="">Mode</option>${kModes.map((mode) => html`<option>${mode}</option>`)}</select>
      ${state?.armed ? disarm : this.button('Arm', 'A', 'vehicle.arm', actions.arm)}
    </div>`;
  }

  private readonly down = (event: PointerEvent) => {
    this.held = event.currentTarget as Element;
    this.heldVehicle = page.bench.vehicle?.system;
    this.held.setPointerCapture(event.pointerId);
    this.hold.down(page.now_s);
  };
  private readonly up = () => this.hold.up();
}
customElements.define('cas-commands', Commands);

interface Loop {
  loop: string;
  parameters: Record<string, string>;
}
interface GainAnswer {
  loop: string;
  p?: number;
  i?: number;
  d?: number;
  before?: Record<string, number>;
}
interface StepResult {
  rise_s: number | null;
  overshoot_pct: number | null;
  settling_s: number | null;
  integrated_error_m_s: number | null;
}

/** How a step was followed between two moments: from 10 % to 90 %, most beyond, within 5 % for good. */
export function stepFigures(t: ArrayLike<number>, v: ArrayLike<number>, begin_s: number, from: number, to: number): StepResult {
  const size = to - from;
  let low: number | null = null;
  let high: number | null = null;
  let most = 0;
  let settled: number | null = null;
  let integral = 0;
  for (let k = 0; k < t.length; ++k) {
    if (t[k]! < begin_s) continue;
    const share = (v[k]! - from) / size;
    if (low === null && share >= 0.1) low = t[k]!;
    if (high === null && share >= 0.9) high = t[k]!;
    most = Math.max(most, share - 1);
    if (Math.abs(share - 1) > 0.05) settled = null;
    else settled ??= t[k]! - begin_s;
    if (k > 0 && t[k - 1]! >= begin_s) integral += Math.abs(v[k]! - to) * (t[k]! - t[k - 1]!);
  }
  return {
    rise_s: low !== null && high !== null ? high - low : null, overshoot_pct: most * 100, settling_s: settled,
    integrated_error_m_s: integral,
  };
}

/** Gains of the loops with a step response before and after. */
class Gains extends Part {
  private loops: Loop[] = [];
  private loop = '';
  private values?: GainAnswer;
  private readonly typed: Record<string, string> = {};
  /** The vehicle whose loops are shown or asked for. */
  private asked?: number;
  private askAgain_s = 0;
  private undo: Record<string, number> | null = null;
  private testing = '';
  private readonly curves: {name: string; t: number[]; v: number[]; figures: StepResult}[] = [];

  protected override render() {
    const {source} = page;
    if (source.player) return this.recorded();
    if (!source.commands) return html`<p class="empty">View only: gains cannot be changed here.</p>`;
    const vehicle = page.bench.vehicle;
    if (vehicle?.state && (vehicle.system !== this.asked || (this.loops.length === 0 && page.now_s >= this.askAgain_s))) void this.list(vehicle.system);
    else if (this.values && page.now_s >= this.askAgain_s) void this.refresh();
    if (this.loops.length === 0) return html`<p class="empty">The vehicle's loops are not known yet.</p>`;
    return html`<div class="sect"><h2>Gains <small>${Object.values(this.loops.find((each) => each.loop === this.loop)?.parameters ?? {}).join(' ')}</small></h2>
      <div class="btns"><select aria-label="Loop" @change=${(event: Event) => void this.choose((event.target as HTMLSelectElement).value)}>
        ${this.loops.map(({loop}) => html`<option ?selected=${loop === this.loop}>${loop}</option>`)}</select></div>
      ${(['p', 'i', 'd'] as const).map((gain) => this.values?.[gain] === undefined ? nothing : html`
        <div class="ask"><span class="mut">${gain.toUpperCase()}</span><span>${fixed(this.values[gain], 3)} →</span>
          <input aria-label=${`New ${gain.toUpperCase()}`} inputmode="decimal" size="6" .value=${this.typed[gain] ?? ''}
            @input=${(event: Event) => { this.typed[gain] = (event.target as HTMLInputElement).value; }}></div>`)}
      <div class="btns"><button class="pri" @click=${() => this.apply()}>Apply</button>
        <button ?disabled=${!this.undo} @click=${() => this.undo && this.askSet(this.undo)}>Undo</button>
        <button ?disabled=${this.testing !== ''} @click=${() => this.askTest()}>Test a step</button></div>
      ${this.testing ? html`<p>${this.testing}</p>` : nothing}</div>
      ${this.curves.length > 0 ? html`<div class="sect">${this.drawCurves()}${this.table(this.curves.map(({name, figures}) => ({name, ...figures})))}</div>` : nothing}`;
  }

  private recorded() {
    const {responses} = page.source as unknown as {responses?: (StepResult & {name: string})[]};
    if (!responses?.length) return html`<p class="empty">No step was flown in this record.</p>`;
    return html`<div class="sect"><h2>Step responses</h2>${this.table(responses)}</div>`;
  }

  private table(rows: (StepResult & {name: string})[]) {
    return html`<table><tr class="mut"><th>step</th><th class="n">rise</th><th class="n">overshoot</th><th>settles</th></tr>
      ${rows.map((row) => html`<tr><td>${clean(row.name)}</td><td class="n">${fixed(row.rise_s)} s</td>
        <td class="n">${fixed(row.overshoot_pct, 1)} %</td><td>${fixed(row.settling_s)} s</td></tr>`)}</table>`;
  }

  private drawCurves() {
    const [W, H, span] = [340, 120, 8];
    const x = (t: number) => (t / span) * W;
    const y = (v: number) => H - 10 - (v / 4) * (H - 20);
    return html`<svg width=${W} height=${H} role="img" aria-label="Step responses: the newest green, the one before grey">
      <path d=${`M0 ${y(0)}V${y(3)}H${W}`} fill="none" stroke="var(--ref)" stroke-dasharray="2 3"></path>
      ${this.curves.map((curve, i, all) => html`<svg><path fill="none" stroke-width="1.6"
        stroke=${`var(--${i === all.length - 1 && all.length > 1 ? 'act' : 't3'})`}
        d=${curve.t.map((t, k) => `${k ? 'L' : 'M'}${x(t).toFixed(1)} ${y(curve.v[k]!).toFixed(1)}`).join('')}></path></svg>`)}</svg>`;
  }

  /** Asked for each vehicle, and again while there is no answer. */
  private async list(vehicle: number): Promise<void> {
    this.asked = vehicle;
    this.askAgain_s = page.now_s + kAskAgain_s;
    this.loops = [];
    try {
      const {loops} = (await page.source.call('gain.list', {vehicle})) as {loops: Loop[]};
      if (vehicle !== this.asked) return;
      this.loops = loops;
      if (loops[0]) await this.choose(loops.find((each) => each.loop === 'position')?.loop ?? loops[0].loop);
    } catch (error) {
      page.refusal = error instanceof Error ? error.message : String(error);
    }
    this.requestUpdate();
  }

  private async choose(loop: string): Promise<void> {
    this.loop = loop;
    this.undo = null;
    this.values = undefined;
    try {
      const values = (await page.source.call('gain.get', {vehicle: this.asked, loop})) as GainAnswer;
      if (loop === this.loop) this.values = values;
    } catch (error) {
      page.refusal = error instanceof Error ? error.message : String(error);
    }
    this.requestUpdate();
  }

  /** Others set gains, too: what this page set before them is not undone. */
  private async refresh(): Promise<void> {
    this.askAgain_s = page.now_s + kAskAgain_s;
    const {asked, loop, values: before} = this;
    const values = (await page.source.call('gain.get', {vehicle: asked, loop}).catch(() => null)) as GainAnswer | null;
    if (!values || loop !== this.loop || asked !== this.asked || before !== this.values) return;
    if ((['p', 'i', 'd'] as const).some((gain) => values[gain] !== before?.[gain])) this.undo = null;
    this.values = values;
    this.requestUpdate();
  }

  private apply(): void {
    const gains: Record<string, number> = {};
    page.refusal = '';
    for (const gain of ['p', 'i', 'd']) {
      const text = (this.typed[gain] ?? '').trim();
      if (text === '' || this.values?.[gain as 'p'] === undefined) continue;
      gains[gain] = Number(text.replace(',', '.'));
      if (!Number.isFinite(gains[gain])) page.refusal ||= `${gain.toUpperCase()}: "${text}" is no number.`;
    }
    if (Object.keys(gains).length === 0) page.refusal = 'No new gain was typed.';
    if (page.refusal) return page.redraw();
    this.askSet(gains);
  }

  private askSet(gains: Record<string, number>): void {
    const words = Object.entries(gains).map(([gain, value]) => `${gain.toUpperCase()} ${value}`).join(', ');
    page.ask(`Set ${this.loop} ${words}?`, 'Set', (vehicle) => void this.set(gains, vehicle));
  }

  private async set(gains: Record<string, number>, vehicle: number | undefined): Promise<void> {
    try {
      const answer = (await page.source.call('gain.set', {vehicle, loop: this.loop, ...gains})) as GainAnswer;
      this.undo = answer.before ?? null;
      for (const [gain, before] of Object.entries(answer.before ?? {})) kBefore.set(`${this.loop} ${gain} ${gains[gain]}`, before);
      this.values = answer;
    } catch (error) {
      page.refusal = error instanceof Error ? error.message : String(error);
    }
    page.redraw();
  }

  private askTest(): void {
    page.ask(`Fly 3 m north and back, 16 s?${page.bench.run ? ' The run judges it, too.' : ''}`, 'Fly', () => void this.test());
  }

  /** A step north and back by goto, looked at in the truth or the estimate. */
  private async test(): Promise<void> {
    const {bench, source} = page;
    const from = bench.vehicle?.state?.position_N;
    if (!from || from.z_m > -2) {
      page.refusal = 'A step is flown from above 2 m only.';
      page.redraw();
      return;
    }
    const begin_s = bench.time_s ?? 0;
    const name = (['p', 'i', 'd'] as const).flatMap((gain) => (this.values?.[gain] === undefined ? [] : `${gain.toUpperCase()} ${fixed(this.values[gain], 3)}`)).join(' ');
    const {x_m, y_m, z_m} = from;
    const vehicle = bench.vehicle?.system;
    const to = (north_m: number) => source.call('vehicle.goto', {vehicle, north_m: x_m + north_m, east_m: y_m, down_m: z_m});
    const wait = (until_s: number) => new Promise<void>((done) => {
      const check = (): void => {
        this.testing = `flying the step: ${fixed(Math.max(0, until_s - (bench.time_s ?? 0)), 0)} s`;
        if ((bench.time_s ?? 0) >= until_s) return done();
        setTimeout(check, 100);
      };
      check();
    });
    try {
      await to(3);
      await wait(begin_s + 8);
      const series = source.series(bench.selected, 'truth.n') ?? source.series(bench.selected, 'est.n');
      if (series) {
        const [t, v]: [number[], number[]] = [[], []];
        for (let i = 0; i < series.t.length; ++i) {
          if (series.t[i]! < begin_s) continue;
          t.push(series.t[i]! - begin_s);
          v.push(series.v[i]!);
        }
        const begin = v[0] ?? 0;  // the series counts in W, the command in N
        v.forEach((value, i) => { v[i] = value - begin; });
        this.curves.push({name, t, v, figures: stepFigures(t, v, 0, 0, 3)});
        if (this.curves.length > 2) this.curves.shift();
      }
      await to(0);
      await wait(begin_s + 16);
    } catch (error) {
      page.refusal = error instanceof Error ? error.message : String(error);
    }
    this.testing = '';
    page.redraw();
  }
}
customElements.define('cas-gains', Gains);
