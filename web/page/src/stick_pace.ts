// SPDX-License-Identifier: BSD-3-Clause
// A gamepad's sticks as MANUAL_CONTROL, and when they are sent. Pure: time is an argument.

const kPeriod_s = 0.05;
/** After so long without an answer the sticks are let go. */
const kSilence_s = 0.5;
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

/** When sticks are sent, and when they are let go: after half a second without an answer. */
export class StickPace {
  private next_s = 0;
  private asked_s: number | null = null;
  on = false;

  start(now_s: number): void {
    this.on = true;
    this.next_s = now_s;
    this.asked_s = null;
  }
  stop(): void {
    this.on = false;
  }
  answered(): void {
    this.asked_s = null;
  }
  /** Whether to send now. */
  tick(now_s: number): boolean {
    if (!this.on) return false;
    if (this.asked_s !== null && now_s - this.asked_s > kSilence_s) {
      this.on = false;
      return false;
    }
    if (now_s < this.next_s) return false;
    this.next_s = Math.max(this.next_s + kPeriod_s, now_s);
    this.asked_s ??= now_s;
    return true;
  }
}
