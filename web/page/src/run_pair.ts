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
export function differences(left: Record<string, string>, right: Record<string, string>): Difference[] {
  const fileName = (text: string | undefined) => (text?.startsWith('/') ? text.slice(text.lastIndexOf('/') + 1) : text);
  return keysOf(left, right)
    .filter((key) => fileName(left[key]) !== fileName(right[key]))
    .map((key) => ({name: key, a: left[key] || '–', b: right[key] || '–'}));
}

export function differentSettings(a: ListedRun, b: ListedRun): Difference[] {
  const own = (run: ListedRun): Record<string, string> => ({
    scenario: run.scenario, architecture: run.architecture, clock: run.clock, seed: String(run.seed), controller: run.controller, ...run.settings,
  });
  return differences(own(a), own(b));
}

/** Where a record is from, as hils/replay/replay_page.cpp writes it beside it. */
export interface RunSource {
  path: string;
  settings: Record<string, string>;
}

/** "wind mean_m_s" for "hilsim.vehicles[iris0].plugins[wind].mean_m_s". */
function shortKey(key: string): string {
  return key.split('.').slice(-2).map((part) => /\[(.*)\]$/.exec(part)?.[1] ?? part).join(' ');
}

/** What tells two runs apart: their names, or if those are the same where they are from, and the settings that differ. */
export function titlesOf(runs: {name: string; source?: RunSource}[]): {name: string; differs: string}[] {
  const kMost = 2;
  const paths = runs.map(({name, source}) => source?.path.replace(/\/+$/, '') || name);
  const last = paths.map((path) => path.slice(path.lastIndexOf('/') + 1));
  const told = [runs.map(({name}) => name), last, paths].find((names) => new Set(names).size === names.length) ?? paths;
  const [a, b] = runs.map(({source}) => source?.settings ?? {}) as [Record<string, string>, Record<string, string>];
  const different = told[0] === runs[0]!.name ? [] : differences(a, b);
  return told.map((name, i) => ({
    name,
    differs: different.slice(0, kMost).map((each) => `${shortKey(each.name)} ${i === 0 ? each.a : each.b}`).join(', ') +
      (different.length > kMost ? ` and ${different.length - kMost} more` : ''),
  }));
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
