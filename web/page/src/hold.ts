// SPDX-License-Identifier: BSD-3-Clause
/** The most that one frame counts: a page that stood still held nothing. */
const kFrame_s = 0.1;

/** A button that acts after it was held for a time. Pure: time is an argument. */
export class Hold {
  private held_s: number | null = null;
  private last_s = 0;

  constructor(private readonly wanted_s: number) {}

  down(now_s: number): void {
    this.held_s = 0;
    this.last_s = now_s;
  }
  up(): void {
    this.held_s = null;
  }

  /** Once a frame: true once, in the frame in which it was held for long enough. */
  tick(now_s: number): boolean {
    if (this.held_s === null) return false;
    this.held_s += Math.min(kFrame_s, now_s - this.last_s);
    this.last_s = now_s;
    if (this.held_s < this.wanted_s) return false;
    this.held_s = null;
    return true;
  }
}
