// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing, svg} from 'lit';
import {kStale_s} from './bench.ts';
import {age, clean, fixed, minutes} from './numbers.ts';
import {page, Part} from './page.ts';
import {kSeverities} from './protocol.ts';
import {indexAt, type Series} from './series.ts';

/** Path of the last six seconds of a series before `t`, in a box. */
export function sparkPath(series: Series, t: number, w = 58, h = 15, window_s = 6): string {
  const from = Math.max(0, indexAt(series.t, t - window_s));
  const to = indexAt(series.t, t);
  if (to - from < 1) return '';
  let low = Infinity;
  let high = -Infinity;
  for (let i = from; i <= to; ++i) {
    low = Math.min(low, series.v[i]!);
    high = Math.max(high, series.v[i]!);
  }
  const scale = high > low ? (h - 4) / (high - low) : 0;
  const step = Math.max(1, Math.floor((to - from) / 60));
  let d = '';
  for (let i = from; i <= to; i += step) {
    const x = w - ((t - series.t[i]!) / window_s) * w;
    if (x < 0) continue;
    const y = scale > 0 ? h - 2 - (series.v[i]! - low) * scale : h / 2;
    d += `${d === '' ? 'M' : 'L'}${x.toFixed(1)} ${y.toFixed(1)}`;
  }
  return d;
}

/** Whether a quantity counts: none of a few samples has a fraction. */
function isWhole(series: Series): boolean {
  const step = Math.max(1, Math.floor(series.t.length / 50));
  for (let i = 0; i < series.v.length; i += step) {
    if (!Number.isInteger(series.v[i])) return false;
  }
  return true;
}

/** "front left", as seen from above. */
export function rotorPlace(p_B: readonly number[]): string {
  const along = p_B[0]! > 0.02 ? 'front' : p_B[0]! < -0.02 ? 'rear' : '';
  const across = p_B[1]! > 0.02 ? 'left' : p_B[1]! < -0.02 ? 'right' : '';
  return [along, across].filter(Boolean).join(' ');
}

function spark(series: Series | undefined, t: number, colour: string) {
  const d = series ? sparkPath(series, t) : '';
  return svg`<svg width="58" height="15" aria-hidden="true"><path d=${d} fill="none" stroke=${`var(--${colour})`} stroke-width="1.2"></path></svg>`;
}

const kKinds: Record<string, [string, string]> = {
  HIL_SENSOR: ['sensor', 'est'], HIL_GPS: ['gps', 't1'], HIL_CONTROLS: ['controls', 'act'], HIL_ACTUATOR_CONTROLS: ['controls', 'act'],
};

/** Names of a message's fields, from the source. */
export interface FieldNames {
  fields(message: string): string[];
  open?(message: string | null, link?: string, system?: number, component?: number): void;
}

/** Each message with its rate; one of them open with its fields. */
class Messages extends Part {
  private filter = '';
  private opened: string | null = 'LOCAL_POSITION_NED';

  protected override render() {
    const {bench, source} = page;
    const t = bench.time_s ?? 0;
    const names = source as unknown as Partial<FieldNames>;
    const list = bench.messages
      .filter((message) => message.direction === 'rx' && (message.system === bench.vehicle?.system || message.link.startsWith('sim')))
      .filter((message) => message.name.toLowerCase().includes(this.filter.toLowerCase()))
      .sort((a, b) => Number(b.name in kKinds) - Number(a.name in kKinds) || (a.name in kKinds ? b.hz - a.hz : a.name.localeCompare(b.name)));
    return html`<div>
      <div class="filter"><input type="search" aria-label="Filter messages" placeholder="Filter  /" .value=${this.filter}
        @input=${(event: Event) => {
          this.filter = (event.target as HTMLInputElement).value;
          this.requestUpdate();
        }}></div>
      <table class="messages" aria-label="Messages">
        <colgroup><col><col><col><col></colgroup>
        <thead class="hidden"><tr><th>Message</th><th>Link</th><th>Rate, per second</th><th>Last 6 s</th></tr></thead>
        ${list.map((message) => {
          const [kind, colour] = kKinds[message.name] ?? ['', 't3'];
          const fields = names.fields?.(message.name) ?? [];
          const isOpen = this.opened === message.name && fields.length > 0;
          const nominal = bench.nominal_hz[message.name];
          const slow = nominal !== undefined && nominal > 20 && message.hz < 0.99 * nominal;
          const age_s = message.age_s + (bench.old.get('messages') ?? 0);
          const stale = message.hz > 0 ? age_s > Math.max(kStale_s, 3 / message.hz) : age_s > kStale_s;
          const first = fields[0] ? source.series(bench.selected, `${message.name}.${fields[0]}`) : undefined;
          return html`<tr class=${isOpen ? 'on' : ''}>
            <td><button class=${`name ${kind}`} aria-expanded=${isOpen} @click=${() => this.open(isOpen ? null : message)}>${clean(message.name)}</button></td>
            <td class="mut">${clean(message.link)}</td>
            <td class=${`n ${slow ? 'bad' : ''}`}>${fixed(message.hz, 1)}</td>
            <td>${stale && message.hz > 0.5 ? html`<span class="stale">${age(age_s)}</span>` : spark(first, t, colour)}</td></tr>
            ${isOpen ? fields.map((field) => this.field(message.name, field, t, stale)) : nothing}`;
        })}
      </table>
      ${list.length === 0 ? html`<p class="empty">No message has come.</p>` : nothing}</div>`;
  }

  private open(message: {name: string; link: string; system: number; component: number} | null): void {
    this.opened = message?.name ?? null;
    (page.source as unknown as Partial<FieldNames>).open?.(this.opened, message?.link, message?.system, message?.component);
    this.requestUpdate();
  }

  private field(message: string, field: string, t: number, stale: boolean) {
    const key = `${message}.${field}`;
    const series = page.source.series(page.bench.selected, key);
    const i = series ? indexAt(series.t, t) : -1;
    const value = i >= 0 ? series!.v[i] : undefined;
    const digits = !series || isWhole(series) ? 0 : Math.abs(value ?? 0) < 1000 ? 3 : 1;
    const on = page.picked.includes(key);
    return html`<tr class="field"><td>${field}</td>
      <td><button class="plus" aria-pressed=${on} aria-label=${`Plot ${key}`} @click=${() => {
        if (on) page.picked.splice(page.picked.indexOf(key), 1);
        else page.picked.unshift(key);
        page.redraw();
      }}>${on ? '−' : '+'}</button></td>
      <td class="n"><span class=${stale ? 'stale' : ''}>${fixed(value, digits)}</span> <span class="mut">${series?.unit ?? ''}</span></td>
      <td>${spark(series, t, stale ? 't3' : 't1')}</td></tr>`;
  }
}
customElements.define('cas-messages', Messages);

/** Events and STATUSTEXT in one list; a click moves the record there. */
class Log extends Part {
  protected override render() {
    const {bench} = page;
    const shown = bench.happenings.slice(-400);
    if (shown.length === 0) return html`<p class="empty">Nothing has happened yet.</p>`;
    return html`<ol class="log" aria-label="Events">${shown.map((event) => {
      const tone = event.severity <= 3 ? 'e' : event.severity === 4 ? 'w' : 'mut';
      const by = event.by ? ` (${clean(event.by)})` : '';
      return html`<li><button @click=${() => this.go(event.t_s)} ?disabled=${!page.source.player}>
        <span class="mut">${minutes(event.t_s, 1)}</span><span class=${tone}>${kSeverities[event.severity] ?? ''}</span>
        <span>${clean(event.text)}${by}</span></button></li>`;
    })}</ol>`;
  }
  private go(t: number): void {
    page.source.player?.seek(t);
    page.redraw();
  }
}
customElements.define('cas-log', Log);

/** Thrust of each rotor. */
class Rotors extends Part {
  protected override render() {
    const {vehicle} = page.bench;
    const rotors = vehicle?.scene?.rotors ?? [];
    const omega = vehicle?.sim?.rotors;
    if (rotors.length === 0 || !omega) return nothing;
    return html`<div class="sect wide"><h2>Rotors <small>thrust, N</small></h2><div class="rows">
      ${rotors.map((rotor, i) => {
        const thrust = rotor.k_f * (omega[i] ?? 0) ** 2;
        const most = rotor.k_f * rotor.omega_max_rad_s ** 2;
        return html`<div class="lim rotor"><span class="sec">${i + 1} ${rotorPlace(rotor.p_B)}</span>
          <span class="bar"><b .style=${`width:${Math.min(100, (thrust / most) * 100).toFixed(1)}%;background:var(--act)`}></b></span>
          <span>${fixed(thrust)} <em>${Math.round(omega[i] ?? 0)} rad/s</em></span></div>`;
      })}</div></div>`;
  }
}
customElements.define('cas-rotors', Rotors);
