// SPDX-License-Identifier: BSD-3-Clause
// Frames as docs/use/frames_and_units.md has them: W east north up, N north east (up here), B forward
// left up. Quaternions are w, x, y, z. Pure.

export type Vec3 = [number, number, number];
export type Quat = [number, number, number, number];

/** Roll, pitch, yaw in radians: yaw from north, clockwise; pitch up; roll right side down. */
export interface Rpy {
  roll: number;
  pitch: number;
  yaw: number;
}

function multiply(a: Quat, b: Quat): Quat {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}

function about(axis: Vec3, angle: number): Quat {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s];
}

/** q_WB of roll, pitch and yaw: a heading of 0 is a quarter turn about up. */
export function quaternionOf(rpy: Rpy): Quat {
  const yaw = about([0, 0, 1], Math.PI / 2 - rpy.yaw);
  const pitch = about([0, 1, 0], -rpy.pitch);
  const roll = about([1, 0, 0], rpy.roll);
  return multiply(multiply(yaw, pitch), roll);
}

/** Roll, pitch and yaw of q_WB. */
export function rpyOf(q: Quat): Rpy {
  const [w, x, y, z] = q;
  const forward: Vec3 = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  const left: number = 2 * (y * z + w * x);
  const up: number = 1 - 2 * (x * x + y * y);
  return {
    roll: Math.atan2(left, up),
    pitch: Math.asin(Math.max(-1, Math.min(1, forward[2]))),
    yaw: Math.atan2(forward[0], forward[1]),
  };
}

/** From a to b along the shorter way. */
export function slerp(a: Quat, b: Quat, share: number): Quat {
  let dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = dot < 0 ? -1 : 1;
  dot *= sign;
  const angle = Math.acos(Math.min(1, dot));
  const near = angle < 1e-4;
  const ka = near ? 1 - share : Math.sin((1 - share) * angle) / Math.sin(angle);
  const kb = sign * (near ? share : Math.sin(share * angle) / Math.sin(angle));
  const q = a.map((value, i) => ka * value + kb * b[i]!) as Quat;
  const norm = Math.hypot(...q);
  return q.map((value) => value / norm) as Quat;
}

/** The vector of B in W. */
export function rotate(q: Quat, v: Vec3): Vec3 {
  const [w, x, y, z] = q;
  const tx = 2 * (y * v[2] - z * v[1]);
  const ty = 2 * (z * v[0] - x * v[2]);
  const tz = 2 * (x * v[1] - y * v[0]);
  return [v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx];
}

/** A place on Earth: degrees, metres above mean sea level. */
export interface Place {
  lat_deg: number;
  lon_deg: number;
  alt_m: number;
}

const kEarth_m = 6_371_000;  // radius of the sphere in base/earth/geodesy.cpp

/** East, north and up of a place from a home, m; good for some kilometres. */
export function fromHome(home: Place, place: Place): Vec3 {
  const degree_m = (Math.PI / 180) * kEarth_m;
  const turn = place.lon_deg - home.lon_deg;
  const east_deg = turn - 360 * Math.round(turn / 360);
  return [
    degree_m * east_deg * Math.cos((home.lat_deg * Math.PI) / 180), degree_m * (place.lat_deg - home.lat_deg),
    place.alt_m - home.alt_m,
  ];
}

export const distance = (a: Vec3, b: Vec3): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
