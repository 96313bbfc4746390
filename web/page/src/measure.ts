// SPDX-License-Identifier: BSD-3-Clause
import {fixed} from './numbers.ts';

export interface Point {
  x: number;
  y: number;
}

/** The way from one point to another, in the words of a plot's axes: "1.24 s, 0.31 m, 0.25 m a s". */
export function measured(a: Point, b: Point, xLabel: string, yLabel: string): string {
  const unit = (label: string) => /, ([^,]+)$/.exec(label)?.[1] ?? '';
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const slope = Math.abs(dx) > 1e-9 ? `; ${fixed(dy / dx, 4)} ${unit(yLabel)} a ${unit(xLabel) || 'unit'}` : '';
  return `Between the points: ${fixed(dx, 4)} ${unit(xLabel)}, ${fixed(dy, 4)} ${unit(yLabel)}${slope}`;
}
