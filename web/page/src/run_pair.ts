// SPDX-License-Identifier: BSD-3-Clause
// What differs between two finished runs. Pure.

/** As hils/runs/runs_page.cpp writes it. */
export interface ListedRun {
  folder: string;
  verdict: 'PASSED' | 'FAILED' | 'INVALID';
  scenario: string;
  controller: string;
  architecture: string;
  clock: string;
  seed: number;
  ended_s: number;
  why: string;
  /** Addresses; empty where there is none. */
  report: string;
  replay: string;
  figures: Record<string, number>;
  settings: Record<string, string>;
}

export interface Difference {
  name: string;
  a: string;
  b: string;
}

/** Keys of either, in order. */
function keysOf(a: object, b: object): string[] {
  return [...new Set([...Object.keys(a), ...Object.keys(b)])].sort();
}

/** Values of the configuration that are not the same; a dash where one has none. Files lie where they like. */
export function differentSettings(a: ListedRun, b: ListedRun): Difference[] {
  const own = (run: ListedRun): Record<string, string> => ({
    scenario: run.scenario, architecture: run.architecture, clock: run.clock, seed: String(run.seed), controller: run.controller, ...run.settings,
  });
  const [left, right] = [own(a), own(b)];
  const fileName = (text: string | undefined) => (text?.startsWith('/') ? text.slice(text.lastIndexOf('/') + 1) : text);
  return keysOf(left, right)
    .filter((key) => fileName(left[key]) !== fileName(right[key]))
    .map((key) => ({name: key, a: left[key] || '–', b: right[key] || '–'}));
}

export interface FigurePair {
  name: string;
  a?: number;
  b?: number;
  /** B less A, and in percent of A. */
  change?: number;
  change_pct?: number;
  same: boolean;
}

export function figurePairs(a: ListedRun, b: ListedRun): FigurePair[] {
  return keysOf(a.figures, b.figures).map((name) => {
    const [left, right] = [a.figures[name], b.figures[name]];
    const change = left === undefined || right === undefined ? undefined : right - left;
    return {name, a: left, b: right, change, change_pct: change === undefined || !left ? undefined : (100 * change) / Math.abs(left), same: change === 0};
  });
}

/** The runs that match all words of a filter, in any of their texts. */
export function matching(runs: ListedRun[], words: string, verdict: string): ListedRun[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  return runs.filter((run) => {
    if (verdict && run.verdict !== verdict) return false;
    const text = [run.folder, run.scenario, run.controller, run.architecture, run.clock, run.verdict, run.why, `seed ${run.seed}`].join(' ').toLowerCase();
    return wanted.every((word) => text.includes(word));
  });
}

/** In order of a value; those without one come last either way. */
export function sorted(runs: ListedRun[], value: (run: ListedRun) => string | number | undefined, descending: boolean): ListedRun[] {
  const sign = descending ? -1 : 1;
  return [...runs].sort((left, right) => {
    const [x, y] = [value(left), value(right)];
    if (x === undefined || y === undefined) return x === y ? 0 : x === undefined ? 1 : -1;
    if (typeof x === 'number' && typeof y === 'number') return sign * (x - y);
    return sign * String(x).localeCompare(String(y), undefined, {numeric: true});
  });
}
