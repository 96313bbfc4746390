// SPDX-License-Identifier: BSD-3-Clause
import type {Bench} from './bench.ts';
import type {Series} from './series.ts';

/** Moves through the time of a record. */
export interface Player {
  readonly duration_s: number;
  readonly time_s: number;
  readonly playing: boolean;
  speed: number;
  play(on: boolean): void;
  seek(time_s: number): void;
}

/**
 * Where the page has its data from: a bench that flies (LiveSource) or a record (RecordSource).
 * Both feed the same messages of docs/develop/web_protocol.md into the Bench.
 */
export interface Source {
  readonly kind: 'live' | 'record';
  /** Begins to feed. */
  start(bench: Bench): void;
  /** Once a frame; `now_s` is a clock that only goes on. */
  tick(now_s: number): void;
  /** A call of the protocol; fails with an Error that has the other side's own words. */
  call(method: string, params?: object): Promise<unknown>;
  /** May the page change anything? */
  readonly commands: boolean;
  /** A quantity over time, by vehicle; nothing where it is not known. */
  series(vehicle: number, key: string): Series | undefined;
  /** The same of a second run beside it. */
  beside?(vehicle: number, key: string): Series | undefined;
  readonly player?: Player;
}
