// SPDX-License-Identifier: BSD-3-Clause
import {html} from 'lit';
import {fixed} from './numbers.ts';
import {page, Part} from './page.ts';

interface FaultButton {
  text: string;
  /** Of the question: "Cut the line of vehicle 1 for 1 s?" */
  words: string;
  /** As an entry of a scenario's `faults`; `text` is its name. */
  params: (for_s: number) => object;
}

/** Effect of each kind of fault that is begun from the page. */
export const kFaultButtons: Record<string, FaultButton> = {
  unplug: {text: 'Cut line', words: 'Cut the line of', params: () => ({unplug: 'fcu'})},
  drop: {text: 'No GPS', words: 'Take the GPS from', params: () => ({drop: 'gps'})},
  rotor: {text: 'Weak rotor', words: 'Rotor 1 at 60 % of', params: () => ({rotor: {number: 1, thrust_share: 0.6}})},
  gust: {text: 'Gust', words: 'A gust of 5 m/s from the south on', params: (for_s) => ({gust: {amplitude_m_s: [5, 0, 0], length_m: 10, hold_s: for_s}})},
};

const kTimes_s = [0.2, 0.5, 1, 2, 5];

/** Faults by hand: each asks first, and a run in which one was begun says that it was touched. */
class Faults extends Part {
  private for_s = 1;

  protected override render() {
    const {bench} = page;
    const now = bench.time_s ?? 0;
    const locked = bench.interlock !== '' || bench.run?.state !== 'running' || page.underWay.has('fault.inject');
    return html`<h2>Faults by hand <select aria-label="Length of a fault" @change=${(event: Event) => {
        this.for_s = Number((event.target as HTMLSelectElement).value);
      }}>${kTimes_s.map((time_s) => html`<option value=${time_s} ?selected=${time_s === this.for_s}>${time_s} s</option>`)}</select></h2>
      <div class="btns four">${bench.faultKinds.filter((kind) => kind in kFaultButtons).map((kind) => {
        const {text} = kFaultButtons[kind]!;
        const on = bench.faults.find((fault) => fault.name === text && fault.begin_s <= now && now < (fault.end_s ?? 0));
        return html`<button ?disabled=${locked || on !== undefined} aria-label=${text} @click=${() => this.begin(kind)}>${
          on ? `${fixed(on.end_s! - now, 1)} s` : text}</button>`;
      })}</div>`;
  }

  private begin(kind: string): void {
    const {text, words, params} = kFaultButtons[kind]!;
    const {for_s} = this;
    page.ask(`${words} vehicle ${page.bench.vehicle?.system} for ${for_s} s?`, 'Begin',
      (vehicle) => void page.command('fault.inject', {vehicle, name: text, ...params(for_s), for_s}));
  }
}
customElements.define('cas-faults', Faults);
