// SPDX-License-Identifier: BSD-3-Clause
// Numbers and texts as the page writes them. Pure.

export const kDash = '–';

/** A number with so many decimals, a real minus sign, and a dash for NaN. */
export function fixed(value: number | null | undefined, digits = 2): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return kDash;
  const text = Math.abs(value).toFixed(digits);
  return value < 0 && Number(text) !== 0 ? '−' + text : text;
}

/** A delay: below 1 ms in us, else in ms with two decimals; where clocks end, "under 10 us". */
export function delay(us: number | undefined): string {
  if (us === undefined) return kDash;
  if (us < 10) return 'under 10 µs';
  return us < 1000 ? `${Math.round(us)} µs` : `${(us / 1000).toFixed(2)} ms`;
}

/** Median and 99 % of a hop: "33 µs · 99 % 0.20 ms". */
export function delayPair(us: {p50: number; p99: number} | undefined): string {
  if (!us) return '';
  if (us.p99 < 10) return 'under 10 µs';
  return `${delay(us.p50)} · 99 % ${delay(us.p99)}`;
}

/** Packets in a second. */
export function rate(hz: number): string {
  return `${hz >= 1000 ? hz.toFixed(0) : hz.toFixed(1)} /s`;
}

/** "T+ 01:02.50"; a dash before anything is known. */
export function clock(seconds: number | null): string {
  if (seconds === null || !Number.isFinite(seconds)) return 'T+ ––:––.––';
  return 'T+ ' + minutes(seconds, 2);
}

/** "01:02.5" with so many decimals. */
export function minutes(seconds: number, digits: number): string {
  const scale = 10 ** digits;
  const whole = Math.floor(Math.max(0, seconds) * scale + 1e-6) / scale;
  const rest = (whole % 60).toFixed(digits).padStart(digits > 0 ? 3 + digits : 2, '0');
  return `${String(Math.floor(whole / 60)).padStart(2, '0')}:${rest}`;
}

/** Seconds between the ticks of an axis: at most one in 46 px, however long the axis is. */
export function tickStep(range_s: number, width_px: number): number {
  const least_s = (range_s * 46) / Math.max(1, width_px);
  return [1, 2, 5, 10, 20, 30, 60, 120, 300, 600].find((each) => each > least_s) ?? 600 * Math.ceil(least_s / 600);
}

/** "921 600". */
export function grouped(value: number): string {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, ' ');
}

/** Text from the wire: control characters are shown as U+FFFD. */
export function clean(text: string): string {
  // eslint-disable-next-line no-control-regex
  return text.replace(/[\u0000-\u001f\u007f-\u009f\u2028\u2029\u202a-\u202e\u2066-\u2069]/g, '�');
}

/** How long ago: "0.42 s old". */
export function age(seconds: number): string {
  return seconds < 10 ? `${seconds.toFixed(2)} s old` : `${Math.round(seconds)} s old`;
}
