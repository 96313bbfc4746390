// SPDX-License-Identifier: BSD-3-Clause
// A gamepad's sticks as MANUAL_CONTROL, and when they are sent. Pure: time is an argument.

const kPeriod_s = 0.05;
/** After so long without an answer the sticks are let go. */
const kSilence_s = 0.5;
/** So many may be without an answer: more would only lie in queues. */
const kMostOpen = 5;
const kDead = 0.06;

export interface SticksAt {
  pitch: number;
  roll: number;
  throttle: number;
  yaw: number;
}

/** Of the standard mapping, as transmitters of mode 2: left throttle and yaw, right pitch and roll. */
export function sticksOf(axes: readonly number[]): SticksAt {
  const axis = (i: number) => {
    const value = Math.max(-1, Math.min(1, axes[i] ?? 0));
    return Math.abs(value) < kDead ? 0 : value;
  };
  return {yaw: axis(0), throttle: (1 - axis(1)) / 2, roll: axis(2), pitch: 0 - axis(3)};
}

/** When sticks are sent, and when they are let go: when one has had no answer for half a second. */
export class StickPace {
  private next_s = 0;
  /** When those were sent that have no answer yet, the oldest first: answers come in their order. */
  private open_s: number[] = [];
  on = false;

  start(now_s: number): void {
    this.on = true;
    this.next_s = now_s;
    this.open_s = [];
  }
  stop(): void {
    this.on = false;
  }
  answered(): void {
    this.open_s.shift();
  }
  /** Whether to send now. */
  tick(now_s: number): boolean {
    if (!this.on) return false;
    if (now_s - (this.open_s[0] ?? now_s) > kSilence_s) {
      this.on = false;
      return false;
    }
    if (now_s < this.next_s || this.open_s.length >= kMostOpen) return false;
    this.next_s = Math.max(this.next_s + kPeriod_s, now_s);
    this.open_s.push(now_s);
    return true;
  }
}
