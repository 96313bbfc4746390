// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing, type TemplateResult} from 'lit';
import {kStale_s} from './bench.ts';
import {actions} from './commands.ts';
import {age, clean, clock, fixed, minutes} from './numbers.ts';
import {page, Part} from './page.ts';
import {setTheme, theme} from './theme.ts';
import {jump, nextSpeed} from './timeline.ts';
import {actWords, shownRows, verdictText} from './verdict.ts';
import type {World} from './world.ts';

const kTabs = ['Messages', 'Plots', 'Gains', 'Log'];
/** Letters of a limit's name that fit beside its bar. */
const kShortName = 9;
/** The vehicle that [HILS] flew. */
const kPaperVehicle = 'iris_paper';
/** Acts by hand that are told in a line each. */
const kTouched = 3;

class App extends Part {
  protected override render() {
    const {bench, source} = page;
    return html`<a class="skip" href="#commands">Skip to commands</a>
      <div class="frame"><h1 class="hidden">CAS: ${clean(bench.name)}</h1>
        ${this.header()}
        <section id="link" aria-label="Links"><cas-links></cas-links></section>
        <aside class="fly" aria-label="Flight">
          <div class="sect tight"><cas-horizon></cas-horizon></div>
          ${this.limits()}
          ${source.player ? this.recordRows() : source.commands ? html`<cas-commands></cas-commands>` : html`<div class="sect" id="commands"><p>View only.</p></div>`}
          <cas-rotors></cas-rotors>
        </aside>
        <section class="world" aria-label="3D view">${this.banner()}<cas-world></cas-world></section>
        <aside class="look" aria-label="Data">${this.tabs(page.tab, kTabs, (tab) => { page.tab = tab; })}</aside>
        <aside class="two" aria-label="More data">${this.tabs(page.secondTab, kTabs, (tab) => { page.secondTab = tab; })}</aside>
        <footer class="time" aria-label="Timeline">
          <div class="ctl">${source.player ? html`<cas-player></cas-player>` : this.benchRows()}</div>
          <div class="tl"><cas-timeline></cas-timeline></div>
        </footer>
      </div>
      <div class="hidden" aria-live="polite">${this.newest()}</div>`;
  }

  private newest(): string {
    const event = page.bench.happenings.findLast((each) => each.t_s <= (page.bench.time_s ?? 0));
    return event ? clean(event.text) : '';
  }

  private header(): TemplateResult {
    const {bench} = page;
    const verdicts = [bench.verdict, bench.besideVerdict].flatMap((verdict) => (verdict ? [verdictText(verdict)] : []));
    const state = bench.vehicle?.state;
    const old = state?.heartbeat_age_s !== undefined && state.heartbeat_age_s > (state.silent_after_s ?? 3) / 2;
    const landed = state?.landed?.replace('_', ' ');
    const several = bench.vehicles.length > 1;
    return html`<header class="top">
      <span class="brand">CAS</span>${this.pill()}<span class="sep"></span>
      ${bench.besideTitle ? this.runTitle('A ', bench.name, bench.subtitle) : this.runTitle('', bench.name || '–', bench.subtitle)}
      ${bench.besideTitle ? this.runTitle('B ', bench.besideTitle.name, bench.besideTitle.differs) : nothing}
      <span class="grow"></span>
      <span class="clock">${clock(bench.time_s)}<small>${this.clockNote()}</small></span><span class="sep"></span>
      <span class="sec said">
        ${several ? html`<select aria-label="Vehicle" @change=${(event: Event) => this.select(Number((event.target as HTMLSelectElement).value))}>
          ${bench.vehicles.map((vehicle, i) => html`<option value=${i} ?selected=${i === bench.selected}>${vehicle.system} ${clean(vehicle.name)}</option>`)}</select>`
          : html`<b>${bench.vehicle?.system ?? '–'}</b>&nbsp;`}
        ${state ? html`<span class=${old ? 'stale' : ''}>${state.autopilot ?? ''}${state.hil ? ' · HIL' : ''} · <b>${state.armed ? 'armed' : 'disarmed'}</b> · ${
          clean(state.mode ?? '–')}${landed ? ` · ${landed}` : ''}${old ? ` · ${age(state.heartbeat_age_s!)}` : ''}</span>` : html`<span class="mut">no vehicle heard</span>`}
      </span><span class="grow"></span>
      ${bench.verdict?.touched.length ? html`<span class="pill amber" role="note" aria-label="A person acted in this run">touched</span>` : nothing}
      ${verdicts.map((verdict, i) => html`<span class=${`pill ${verdict.tone}`}><span>${verdict.ticked ? html`<span class="tick">✓</span> ` : ''}${
        verdicts.length > 1 ? `${'AB'[i]}: ` : ''}${clean(verdict.text)}</span></span>`)}
      <button class="ib optional" aria-label=${`Theme: ${theme()}`} @click=${() => setTheme(theme() === 'dark' ? 'light' : 'dark')}>◐</button>
      <button class="ib optional" aria-label="Keys" @click=${() => this.help()}>?</button>
    </header>`;
  }

  private runTitle(letter: string, name: string, more: string): TemplateResult {
    return html`<span class="run" title=${clean(`${name} ${more}`)}><span class="mut">${letter}</span><b>${clean(name)}</b> <span class="mut optional">&nbsp;${clean(more)}</span></span>`;
  }

  private pill(): TemplateResult {
    const {bench} = page;
    if (bench.connection === 'record') return html`<span class="pill blue"><i></i>Record</span>`;
    if (bench.connection === 'live') return html`<span class="pill"><i></i>Live</span>${bench.readOnly ? html`<span class="pill grey">view only</span>` : nothing}`;
    if (bench.runIsOver) return html`<span class="pill blue"><i></i>Run over</span>`;
    if (bench.connection === 'lost') return html`<span class="pill red"><i></i>Page lost ${Math.round(bench.waiting_s)} s</span>`;
    return html`<span class="pill grey"><i></i>Connecting</span>`;
  }

  private clockNote(): string {
    const {bench} = page;
    if (page.source.player) return `of ${minutes(page.source.player.duration_s, 1)}`;
    if (bench.simAge_s > kStale_s && bench.time_s !== null) return age(bench.simAge_s);
    return bench.paused ? 'paused' : bench.rate === undefined ? '' : `${fixed(bench.rate, 3)} ×`;
  }

  private limits(): TemplateResult {
    const {bench} = page;
    const {verdict} = bench;
    const open = verdict?.state === 'running' || verdict?.state === 'lost';
    const since = bench.measured ? 'RMS · % left' : '';
    if (!verdict || verdict.rows.length === 0) {
      return html`<div class="sect"><h2>Limits</h2><p>${verdict && bench.run ? `The run has no limits for vehicle ${bench.vehicle?.system ?? '–'}.` : page.source.player ? 'This log has no limits.' : 'No run of hils is flown here: nothing is judged.'}</p></div>`;
    }
    const words = {running: 'Limits so far', passed: 'Verdict: passed', failed: 'Verdict: failed', invalid: 'No verdict', lost: 'Limits, as heard last'};
    const other = bench.besideVerdict;
    const others = other ? shownRows(other.rows) : [];
    const title = other ? `A: ${words[verdict.state].replace('Verdict: ', '')} · B: ${words[other.state].replace('Verdict: ', '')}` : words[verdict.state];
    return html`<div class="sect"><h2>${title} <small>${other ? 'A · B' : since}</small></h2>
      <div class="rows">${shownRows(verdict.rows).map((row) => {
        const digits = row.digits === undefined ? 2 : row.unit === 'm' ? 2 : row.unit === 'rad' ? 3 : Math.min(row.digits, row.unit === 'us' ? 0 : 2);
        const share = row.value === null || row.limit === null ? 0 : row.limit === 0 ? (row.value > 0 ? 1 : 0) : row.value / row.limit;
        const beside = others.find((each) => each.name === row.name);
        return html`<div class=${`lim ${row.name.length > kShortName || (row.value === null && open) ? 'long' : ''} ${row.missed ? 'missed' : ''} `}><span class="sec">${row.name}</span>
          <span class="bar"><b .style=${`width:${(Math.min(1, Math.max(0, share)) * 100).toFixed(1)}%`}></b></span>
          ${row.value === null && open ? html`<span><em>measured at the end; limit ${row.limit}${row.unit ? ` ${row.unit}` : ''}</em></span>` : html`<span>${fixed(row.value, digits)}${
            other ? html`<em class=${beside?.missed ? 'bad' : ''}> · ${fixed(beside?.value, digits)}</em>` : nothing} <em>of ${row.limit}${
            row.unit ? ` ${row.unit}` : ''}${row.margin == null || !row.limit || other ? '' : ` · ${fixed((100 * row.margin) / Math.abs(row.limit), 0)} %`}</em></span>`}</div>`;
      })}</div>
      ${verdict.touched.slice(0, kTouched).map((act, i) => html`<p class="touched" title=${clean(act)}>${i === 0 ? 'Touched: ' : ''}${clean(actWords(act))}</p>`)}
      ${verdict.touched.length > kTouched ? html`<p class="touched">and ${verdict.touched.length - kTouched} more</p>` : nothing}
      ${open ? nothing : [verdict, ...(other ? [other] : [])].map(({sentences}, i) => sentences.slice(0, 3).map(
        (sentence) => html`<p class="bad">${other ? `${'AB'[i]}: ` : ''}${clean(sentence)}</p>`))}</div>`;
  }

  /** In a record: the paper's value of the same figure. */
  private recordRows() {
    const {bench} = page;
    const {hops} = bench;
    const hop = hops.find((each) => each.from === 'casd' && each.to === 'fcu') ?? hops.find((each) => each.from === 'sim');
    const back = hops.find((each) => each.from === 'fcu');
    const controls = back && Object.entries(back.msgs).find(([name]) => name.includes('CONTROLS'))?.[1];
    if (!hop?.msgs.HIL_SENSOR || bench.vehicle?.scene?.name !== kPaperVehicle) return html`<div id="commands" tabindex="-1"></div>`;
    return html`<div class="sect" id="commands" tabindex="-1"><h2>Beside the paper <small>TCAS, hover</small></h2>
      <table class="paper"><tr class="mut"><th></th><th class="n">now</th><th>[HILS]</th></tr>
        <tr><td>sensor rate</td><td class="n">${fixed(hop.msgs.HIL_SENSOR, 1)} Hz</td><td>431.9</td></tr>
        <tr><td>control rate</td><td class="n">${fixed(controls, 1)} Hz</td><td>342.6</td></tr></table></div>`;
  }

  private benchRows() {
    const {programs, faultKinds, verdict} = page.bench;
    if (page.bench.runIsOver) {
      return html`<h2>Results</h2><p>The run is over, and its programs with it.</p>${verdict?.out ? html`<p><code>${clean(verdict.out)}/report.html</code></p>
        <p><code>${clean(verdict.out)}/replay.html</code></p><p>How it went: <code>hils explain ${clean(verdict.out)}</code></p>` : nothing}`;
    }
    if (faultKinds.length > 0 && programs.every((program) => program.state === 'up')) return html`<cas-faults></cas-faults>`;
    return html`<h2>Programs</h2><div class="rows">${programs.map((program) => html`<div class="lim"><span class="sec">${clean(program.name)}</span><span></span>
      <span class=${program.state === 'up' ? '' : 'bad'}>${clean(program.state)}${program.version ? html` <em>${clean(program.version)}</em>` : nothing}</span></div>`)}</div>`;
  }

  private banner(): TemplateResult | typeof nothing {
    const {bench} = page;
    if (bench.faultsOfPage.length > 0) {
      return html`<div class="banner" role="alert"><b>The page cannot show this</b>${clean(bench.faultsOfPage[0]!)}</div>`;
    }
    if (bench.connection === 'connecting' && bench.waiting_s > 1) {
      return html`<div class="banner quiet"><b>Looking for hilsim and casd</b>${bench.waiting_s > 5
        ? html`Start them with <code>scripts/run</code>, and the page with <code>casweb</code>.` : nothing}</div>`;
    }
    const down = bench.links?.hops.find((hop) => hop.state === 'down');
    if (down && bench.connection === 'live') {
      return html`<div class="banner" role="alert"><b>The link ${clean(down.link ?? down.to)} is down</b>
        ${clean(down.endpoint ?? '')} is gone. casd tries again by itself.</div>`;
    }
    return nothing;
  }

  private tabs(active: string, names: string[], choose: (tab: string) => void): TemplateResult {
    const keys = (event: KeyboardEvent) => {
      const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
      if (step === 0) return;
      event.stopPropagation();
      event.preventDefault();
      choose(names[(names.indexOf(active) + step + names.length) % names.length]!);
      const list = event.currentTarget as HTMLElement;
      page.redraw();
      void this.updateComplete.then(() => list.querySelector<HTMLElement>('[aria-selected=true]')?.focus());
    };
    return html`<div class="tabs" role="tablist" aria-label="Data" @keydown=${keys}>${names.map((name) => html`<button role="tab"
        aria-selected=${name === active} tabindex=${name === active ? 0 : -1} @click=${() => { choose(name); page.redraw(); }}>${name}</button>`)}</div>
      <div class="tab" role="tabpanel" aria-label=${active}>${!page.seen ? nothing
        : active === 'Messages' ? html`<cas-messages></cas-messages>` : active === 'Plots' ? html`<cas-plots></cas-plots>`
        : active === 'Gains' ? html`<cas-gains></cas-gains>` : html`<cas-log></cas-log>`}</div>`;
  }

  private select(i: number): void {
    page.bench.selected = i;
    page.redraw();
  }

  help(): void {
    const dialog = document.querySelector<HTMLDialogElement>('dialog');
    if (dialog?.open) dialog.close();
    else dialog?.showModal();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener('keydown', this.onKey);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener('keydown', this.onKey);
  }

  private readonly onKey = (event: KeyboardEvent) => {
    const target = event.target as HTMLElement;
    if (event.key === 'Escape') {
      if (page.question || page.goto) page.answer(false);
      target.blur?.();
      return;
    }
    if (event.repeat && event.key === 'Enter') return event.preventDefault();
    if (page.question && event.key === 'Enter' && target.tagName !== 'BUTTON') {
      event.preventDefault();
      return page.answer(true);
    }
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (['INPUT', 'SELECT', 'TEXTAREA'].includes(target.tagName)) return;
    if (event.key === ' ' && target.tagName === 'BUTTON') return;
    const act = this.keyOf(event);
    if (!act) return;
    event.preventDefault();
    // A key that is held goes on through a record, and commands once.
    if (event.repeat && (event.key === ' ' || !page.source.player)) return;
    act();
    page.redraw();
  };

  private keyOf(event: KeyboardEvent): (() => void) | undefined {
    const world = document.querySelector<World>('cas-world')!;
    const player = page.source.player;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const {bench} = page;
    if (event.shiftKey && key === 't') return () => setTheme(theme() === 'dark' ? 'light' : 'dark');
    const common: Record<string, () => void> = {
      '1': () => world.setCamera('orbit'), '2': () => world.setCamera('follow'), '3': () => world.setCamera('chase'),
      '4': () => world.setCamera('top'), '0': () => world.frameAll(), '?': () => this.help(),
      '/': () => {
        page.tab = 'Messages';
        page.redraw();
        void this.updateComplete.then(() => document.querySelector<HTMLElement>('.filter input')?.focus());
      },
      '[': () => { bench.selected = Math.max(0, bench.selected - 1); },
      ']': () => { bench.selected = Math.min(bench.vehicles.length - 1, bench.selected + 1); },
      k: () => { page.tab = 'Gains'; },
      f: () => document.querySelector<HTMLElement>('cas-faults button')?.focus(),
      r: () => document.querySelectorAll<HTMLElement & {reset(): void}>('cas-plots').forEach((plots) => plots.reset()),
    };
    if (common[key]) return common[key];
    if (player) {
      const step = event.shiftKey ? 10 : 1;
      const keys: Record<string, () => void> = {
        ' ': () => player.play(!player.playing), ',': () => player.seek(player.time_s - 0.02), '.': () => player.seek(player.time_s + 0.02),
        ArrowLeft: () => player.seek(player.time_s - step), ArrowRight: () => player.seek(player.time_s + step),
        Home: () => player.seek(0), End: () => player.seek(player.duration_s), n: () => jump(false), p: () => jump(true),
        '-': () => { player.speed = nextSpeed(player.speed, false); }, '=': () => { player.speed = nextSpeed(player.speed, true); },
        '+': () => { player.speed = nextSpeed(player.speed, true); },
      };
      return keys[key];
    }
    if (key === ' ') return () => void page.source.call(bench.paused ? 'sim.resume' : 'sim.pause').catch(() => undefined);
    if (!page.source.commands || page.bench.interlock) return undefined;
    const keys: Record<string, () => void> = {
      h: actions.hold, l: actions.land, t: actions.takeoff, g: actions.goto, a: actions.arm,
      m: () => document.querySelector<HTMLElement>('select[aria-label=Mode]')?.focus(),
    };
    return keys[key];
  }
}
customElements.define('cas-app', App);
