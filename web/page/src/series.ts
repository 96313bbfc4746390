// SPDX-License-Identifier: BSD-3-Clause
// Numbers over time: whole columns of a record, rings of a live run. Pure.

/** Times and values of one quantity, in the order of time. */
export interface Series {
  t: ArrayLike<number>;
  v: ArrayLike<number>;
  unit?: string;
}

/** Multiples of `k`, each as the difference from the one before (hils/replay/column.hpp). */
export interface Column {
  k: number;
  /** null: a gap, where no value is. */
  d: (number | null)[];
}

export function decode(column: Column): Float64Array {
  const values = new Float64Array(column.d.length);
  let sum = 0;
  for (let i = 0; i < values.length; ++i) {
    const difference = column.d[i]!;
    sum += difference ?? 0;
    values[i] = difference === null ? NaN : sum * column.k;
  }
  return values;
}

/** Index of the last time that is not after `t`; -1 before the first. */
export function indexAt(times: ArrayLike<number>, t: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The newest value at `t`; nothing before the first. */
export function valueAt(series: Series, t: number): number | undefined {
  const i = indexAt(series.t, t);
  return i < 0 ? undefined : series.v[i];
}

/** Value between the samples about `t`; nothing beyond the ends or across a gap. */
export function between(times: ArrayLike<number>, values: ArrayLike<number>, t: number, gap = 1): number | undefined {
  const i = indexAt(times, t);
  if (i < 0) return undefined;
  if (i + 1 >= times.length) return t - times[i]! <= gap ? values[i] : undefined;
  const span = times[i + 1]! - times[i]!;
  if (span > gap) return t - times[i]! <= gap ? values[i] : undefined;
  const share = span > 0 ? (t - times[i]!) / span : 0;
  return values[i]! + share * (values[i + 1]! - values[i]!);
}

/** Spans in which a vehicle is on its way to a reference that jumped: from the jump until the error is in its limit. */
export function waysTo(reference: Series[], error: Series, limit: number): [number, number][] {
  const ways: [number, number][] = [];
  const t = reference[0]!.t;
  for (let i = 1; i < t.length; ++i) {
    if (t[i]! < (ways.at(-1)?.[1] ?? -Infinity)) continue;
    if (Math.hypot(...reference.map(({v}) => v[i]! - v[i - 1]!)) <= limit) continue;
    let k = Math.max(0, indexAt(error.t, t[i]!) + 1);
    while (k < error.t.length && !(error.v[k]! <= limit)) ++k;
    ways.push([t[i - 1]!, error.t[k] ?? Infinity]);
  }
  return ways;
}

/** The newest samples of a live quantity: 20 Hz over ten minutes, then the oldest goes. */
export class Ring implements Series {
  t: number[] = [];
  v: number[] = [];
  private static readonly kMost = 12_000;
  private static readonly kPeriod_s = 0.045;

  constructor(readonly unit?: string) {}

  push(t: number, v: number): void {
    const last = this.t.at(-1);
    if (last !== undefined && t < last) {
      this.t = [];  // the simulation began anew
      this.v = [];
    } else if (last !== undefined && t - last < Ring.kPeriod_s) {
      return;
    }
    this.t.push(t);
    this.v.push(v);
    if (this.t.length > Ring.kMost + 1000) {
      this.t.splice(0, 1000);
      this.v.splice(0, 1000);
    }
  }
}
