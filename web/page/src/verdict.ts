// SPDX-License-Identifier: BSD-3-Clause
// A run's limits and its verdict as the page says them. Pure.
import {age, fixed} from './numbers.ts';
import type {Verdict, VerdictRow} from './protocol.ts';

/** Rows for the panel: the position first, several of a kind as their worst. */
export function shownRows(rows: VerdictRow[]): VerdictRow[] {
  const bounded = rows.filter((row) => row.limit !== null);
  const share = (row: VerdictRow) => (row.value === null ? Infinity : row.least ? -row.value : row.value / Math.max(1e-12, row.limit!));
  const kinds: [RegExp, string][] = [[/ lost$/, 'lost'], [/ rate off$/, 'rate off'], [/ delivered$/, 'delivered']];
  const result: VerdictRow[] = [];
  for (const row of bounded) {
    const kind = kinds.find(([pattern]) => pattern.test(row.name));
    if (!kind) {
      result.push(row);
      continue;
    }
    const known = result.find((each) => each.name === kind[1]);
    if (!known) result.push({...row, name: kind[1]});
    else if (share(row) > share(known)) Object.assign(known, row, {name: kind[1], missed: row.missed || known.missed});
    else known.missed = known.missed || row.missed;
  }
  const order = ['north', 'east', 'up', 'yaw', 'lost'];
  const rank = (row: VerdictRow) => (order.indexOf(row.name) + 1 || order.length + 1);
  return result.sort((a, b) => rank(a) - rank(b));
}

/** Gains before this page set them: "position p 1.2" -> 1.5. */
export const kBefore = new Map<string, number>();

/** An act of a person in words: "position P 1.5 → 1.2" for "gain.set {JSON} by WHO". */
export function actWords(act: string): string {
  const [, method = act, json, refused = ''] = /^(\S+)(?: (\{.*\}))?(, refused)? by /.exec(act) ?? [];
  if (!json) return method + refused;
  let params: Record<string, unknown> = {};
  try {
    params = JSON.parse(json) as Record<string, unknown>;
  } catch {
    return method + refused;  // a long one was cut
  }
  const {loop, vehicle: _, name, for_s, north_m, east_m, down_m, ...rest} = params;
  const plain = (value: unknown) => (typeof value === 'number' ? String(Number(value.toFixed(3))) : String(value));
  const metres = (value: unknown, words: [string, string]) => {
    const text = fixed(Math.abs(Number(value)), 1);
    return Number(text) === 0 ? [] : [`${text} m ${words[Number(value) < 0 ? 1 : 0]}`];
  };
  let words = [method.replace('vehicle.', ''), ...Object.entries(rest).filter(([, value]) => typeof value !== 'object').map(([key, value]) => `${key} ${plain(value)}`)].join(' ');
  if (method === 'vehicle.goto') {
    words = `go to ${[...metres(north_m, ['north', 'south']), ...metres(east_m, ['east', 'west']), ...metres(down_m, ['down', 'up'])].join(', ')}`;
  } else if (method === 'gain.set') {
    words = `${String(loop)} ${Object.entries(rest).map(([gain, value]) => {
      const before = kBefore.get(`${String(loop)} ${gain} ${String(value)}`);
      return `${gain.toUpperCase()} ${before === undefined ? '' : plain(before)} → ${plain(value)}`.replace('  ', ' ');
    }).join(', ')}`;
  } else if (method === 'fault.inject') {
    words = `fault ${plain(name)}, ${plain(for_s)} s`;
  }
  return words + refused;
}

/** "Passed, 5 of 5 limits", over all vehicles of the run; a tick means passed. */
export function verdictText(verdict: Verdict): {text: string; tone: '' | 'red' | 'amber' | 'grey'; ticked: boolean} {
  const rows = verdict.every ?? verdict.rows;
  const bounded = rows.filter((row) => row.limit !== null);
  const missed = rows.filter((row) => row.missed).length;
  const {state} = verdict;
  if (state === 'passed') return {text: `Passed, ${bounded.length} of ${bounded.length} limits`, tone: '', ticked: true};
  if (state === 'invalid') return {text: `No verdict: ${verdict.sentences[0] ?? 'the run does not count'}`, tone: 'amber', ticked: false};
  if (state === 'lost') return {text: `Run lost, ${age(verdict.age_s ?? 0)}`, tone: 'amber', ticked: false};
  if (state === 'failed') return {text: missed > 0 ? `Failed, ${missed} missed` : 'Failed', tone: 'red', ticked: false};
  if (missed > 0) return {text: `${missed} ${missed === 1 ? 'limit' : 'limits'} missed so far`, tone: 'red', ticked: false};
  const known = bounded.filter((row) => row.value !== null).length;
  return {text: known === 0 ? 'Not measured yet' : `${known} of ${bounded.length} known, kept so far`, tone: 'grey', ticked: false};
}
