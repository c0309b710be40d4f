// Geometry of the surface in three dimensions: vertices of a map, the eye, and the cell that a ray meets first.
// The map's longer side is 1, its middle is the origin; the scale's low end lies at z = 0, its high end at `lift`.

import type {Scale, SurfaceMap} from "../data/maps";

/** Angles of the eye in rad, its distance, and the height of the colour scale in map widths. */
export interface Turn {
  around: number;
  up: number;
  distance: number;
  lift: number;
}

export const kFirstTurn: Turn = {around: -0.9, up: 0.65, distance: 2.3, lift: 0.25};
const kHalfView = Math.tan((15 * Math.PI) / 180);
const kTarget_z = 0.1;

export function turned(turn: Turn, around: number, up: number, zoom: number): Turn {
  return {...turn, around: turn.around + around, up: Math.max(0.05, Math.min(1.55, turn.up + up)),
          distance: Math.max(1, Math.min(8, turn.distance * zoom))};
}

export function eye_of(turn: Turn): [number, number, number] {
  const flat = turn.distance * Math.cos(turn.up);
  return [flat * Math.cos(turn.around), flat * Math.sin(turn.around), kTarget_z + turn.distance * Math.sin(turn.up)];
}

export function vertices(map: SurfaceMap, scale: Scale, lift: number) {
  const count = map.nx * map.ny;
  const longest = Math.max(map.nx, map.ny);
  const position = new Float32Array(3 * count);
  const shade = new Float32Array(count);
  const seen = new Float32Array(count);
  for (let y = 0, i = 0; y < map.ny; ++y)
    for (let x = 0; x < map.nx; ++x, ++i) {
      const value = map.values[i];
      const there = Number.isFinite(value);
      const t = there ? (value - scale.low) / (scale.high - scale.low) : 0;
      position[3 * i] = (x - (map.nx - 1) / 2) / longest;
      position[3 * i + 1] = (y - (map.ny - 1) / 2) / longest;
      position[3 * i + 2] = lift * Math.max(-0.5, Math.min(1.5, t));
      shade[i] = t;
      seen[i] = there ? 1 : 0;
    }
  const index = new Uint32Array(6 * (map.nx - 1) * (map.ny - 1));
  for (let y = 0, k = 0; y + 1 < map.ny; ++y)
    for (let x = 0; x + 1 < map.nx; ++x) {
      const a = y * map.nx + x;
      index.set([a, a + 1, a + map.nx, a + 1, a + map.nx + 1, a + map.nx], k);
      k += 6;
    }
  return {position, shade, seen, index};
}

type Vector = [number, number, number];

const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a: Vector): Vector => {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

/** The first cell that the ray through (right, up) in -1..1 of the picture meets, or null. Steps of a third of a cell. */
export function height_under(map: SurfaceMap, scale: Scale, turn: Turn, right: number, up: number, aspect: number): [number, number] | null {
  const eye = eye_of(turn);
  const ahead = unit(minus([0, 0, kTarget_z], eye));
  const side = unit(cross(ahead, [0, 0, 1]));
  const above = cross(side, ahead);
  const ray = unit([0, 1, 2].map(c => ahead[c] + side[c] * right * kHalfView * aspect + above[c] * up * kHalfView) as Vector);
  const longest = Math.max(map.nx, map.ny);
  const step = 1 / (3 * longest);
  for (let along = Math.max(0.1, turn.distance - 1.6); along < turn.distance + 1.6; along += step) {
    const x = Math.round((eye[0] + ray[0] * along) * longest + (map.nx - 1) / 2);
    const y = Math.round((eye[1] + ray[1] * along) * longest + (map.ny - 1) / 2);
    if (x < 0 || y < 0 || x >= map.nx || y >= map.ny) continue;
    const value = map.values[y * map.nx + x];
    if (!Number.isFinite(value)) continue;
    const t = Math.max(-0.5, Math.min(1.5, (value - scale.low) / (scale.high - scale.low)));
    if (eye[2] + ray[2] * along <= turn.lift * t) return [x, y];
  }
  return null;
}
