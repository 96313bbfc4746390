// SPDX-License-Identifier: BSD-3-Clause
import {html, render} from 'lit';

const kKeys: [string, string][] = [
  ['1 2 3 4', 'camera: orbit, follow, chase, top'], ['0', 'whole flight in view'], ['Space', 'play or pause'], [', .', 'one frame'],
  ['← →', '1 s (with Shift 10 s)'], ['N P', 'next, previous event'], ['- =', 'speed'], ['H L T G M', 'hold, land, take off, go to, mode'],
  ['A', 'arm'], ['/', 'filter messages'], ['[ ]', 'vehicle'], ['K', 'gains'], ['F', 'faults'], ['R', 'reset plots'], ['Shift+T', 'theme'],
  ['?', 'this list'], ['Esc', 'leaves anything'],
];

/** The list of keys, as a dialog of the page. */
export function addHelp(): void {
  const dialog = document.createElement('dialog');
  dialog.setAttribute('aria-label', 'Keys');
  render(html`<h2>Keys</h2><table>${kKeys.map(([keys, words]) => html`<tr><td><kbd>${keys}</kbd></td><td>${words}</td></tr>`)}</table>
    <form method="dialog"><button class="pri">Close</button></form>`, dialog);
  document.body.append(dialog);
}
