// Maps of a surface: the binary frame, differences, statistics and scales.

import {kMapDroplets, kMapFactor, kMapHeaderBytes, kMapPlaces, kMapRows, kMapVersion, kSurfaces, type Grid, type Surface} from "./protocol";

const kMostCells = 1 << 24;

/** Values in um, mm, droplets or a factor, row y = 0 first; NaN where nothing was seen. */
export interface SurfaceMap {
  surface: Surface;
  layer: number;
  nx: number;
  ny: number;
  flags: number;
  t_s: number;
  values: Float32Array;
  unit?: string;  // um without it
  places?: {x: Float32Array; y: Float32Array};  // of droplets in their cells, shares of the pitch from the middle
}

/** The map in the unit of its lab, where its values are heights. */
export function in_unit(map: SurfaceMap, unit: string | undefined): SurfaceMap {
  if (map.flags & kMapDroplets) return {...map, unit: "droplets"};
  if (map.flags & kMapFactor) return {...map, unit: ""};
  return unit === "mm" ? {...map, unit, values: map.values.map(um => um / 1000)} : map;
}

/** Reads a map frame, or the rows that have changed in `base`; throws with the byte and the limit that was broken. */
export function read_map(bytes: ArrayBuffer, base: SurfaceMap | null = null): SurfaceMap {
  const view = new DataView(bytes);
  if (bytes.byteLength < kMapHeaderBytes) throw new Error(`a map of ${bytes.byteLength} bytes, at least ${kMapHeaderBytes}`);
  if (view.getUint32(0, true) !== 0x50414d46) throw new Error("byte 0: not a map (FMAP)");
  if (view.getUint16(4, true) !== kMapVersion) throw new Error(`byte 4: version ${view.getUint16(4, true)}, known is ${kMapVersion}`);
  const surface = kSurfaces[view.getUint16(6, true)];
  if (!surface) throw new Error(`byte 6: surface ${view.getUint16(6, true)}, at most ${kSurfaces.length - 1}`);
  const nx = view.getUint32(12, true);
  const ny = view.getUint32(16, true);
  if (nx === 0 || ny === 0 || nx * ny > kMostCells) throw new Error(`byte 12: ${nx} x ${ny} cells`);
  const flags = view.getUint32(20, true);
  const layer = view.getUint32(8, true);
  const t_s = view.getFloat64(24, true);
  if (flags & kMapRows) return {surface, layer, nx, ny, flags: flags & ~kMapRows, t_s, values: rows_over(view, base, surface, layer, nx, ny)};
  const cells = nx * ny;
  const wanted = kMapHeaderBytes + 4 * cells * (flags & kMapPlaces ? 3 : 1);
  if (bytes.byteLength !== wanted) throw new Error(`${bytes.byteLength} bytes for ${nx} x ${ny} cells, expected ${wanted}`);
  const map: SurfaceMap = {surface, layer, nx, ny, flags, t_s, values: floats(bytes, 0, cells)};
  if (flags & kMapPlaces) map.places = {x: floats(bytes, cells, cells), y: floats(bytes, 2 * cells, cells)};
  return map;
}

/** A copy of the base's values, with rows over it: each is its number and its values. */
function rows_over(view: DataView, base: SurfaceMap | null, surface: Surface, layer: number, nx: number, ny: number): Float32Array {
  if (!base || base.surface !== surface || base.layer !== layer || base.nx !== nx || base.ny !== ny) throw new Error("rows of a map that is not here");
  const each = 4 + 4 * nx;
  if ((view.byteLength - kMapHeaderBytes) % each) throw new Error(`${view.byteLength} bytes are no rows of ${nx} cells`);
  const values = base.values.slice();
  for (let at = kMapHeaderBytes; at < view.byteLength; at += each) {
    const row = view.getUint32(at, true);
    if (row >= ny) throw new Error(`byte ${at}: row ${row} of ${ny}`);
    for (let i = 0; i < nx; ++i) values[row * nx + i] = view.getFloat32(at + 4 + 4 * i, true);
  }
  return values;
}

/** `count` numbers behind the first `from`. */
function floats(bytes: ArrayBuffer, from: number, count: number): Float32Array {
  const begin = kMapHeaderBytes + 4 * from;
  const little = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;
  if (little) return new Float32Array(bytes, begin, count);
  const view = new DataView(bytes);
  return Float32Array.from({length: count}, (_, i) => view.getFloat32(begin + 4 * i, true));
}

export function pitch_y_mm(grid: Grid): number {
  return grid.pitch_y_mm ?? grid.pitch_mm;
}

/** a - b on a's cells; b of another grid is read by bilinear interpolation at a's cell centres, NaN outside of it. */
export function difference(a: SurfaceMap, a_grid: Grid, b: SurfaceMap, b_grid: Grid): SurfaceMap {
  const values = new Float32Array(a.values.length);
  const same = a.nx === b.nx && a.ny === b.ny && a_grid.pitch_mm === b_grid.pitch_mm &&
    pitch_y_mm(a_grid) === pitch_y_mm(b_grid) &&
    a_grid.x0_mm === b_grid.x0_mm && a_grid.y0_mm === b_grid.y0_mm;
  for (let y = 0, i = 0; y < a.ny; ++y)
    for (let x = 0; x < a.nx; ++x, ++i) {
      const other = same ? b.values[i] : value_at(b, (a_grid.x0_mm + x * a_grid.pitch_mm - b_grid.x0_mm) / b_grid.pitch_mm,
                                                  (a_grid.y0_mm + y * pitch_y_mm(a_grid) - b_grid.y0_mm) / pitch_y_mm(b_grid));
      values[i] = a.values[i] - other;
    }
  return {...a, values};
}

/** Bilinear value at fractional cell (x, y); NaN outside and beside unseen cells. */
export function value_at(map: SurfaceMap, x: number, y: number): number {
  if (!(x >= 0 && y >= 0 && x <= map.nx - 1 && y <= map.ny - 1)) return NaN;
  const x0 = Math.min(Math.floor(x), Math.max(map.nx - 2, 0));
  const y0 = Math.min(Math.floor(y), Math.max(map.ny - 2, 0));
  const fx = x - x0;
  const fy = y - y0;
  const at = (dx: number, dy: number) => map.values[Math.min(y0 + dy, map.ny - 1) * map.nx + Math.min(x0 + dx, map.nx - 1)];
  // A weight of 0 times NaN would be NaN: a value on a cell's own centre needs no neighbour.
  let sum = 0;
  for (const [weight, dx, dy] of [[(1 - fx) * (1 - fy), 0, 0], [fx * (1 - fy), 1, 0], [(1 - fx) * fy, 0, 1], [fx * fy, 1, 1]])
    if (weight > 0) sum += weight * at(dx, dy);
  return sum;
}

/** Values along the line from cell a to cell b, at most half a cell apart: nearest cells, never smoothed. */
export function section(map: SurfaceMap, a: [number, number], b: [number, number], grid: Grid) {
  const length_mm = Math.hypot((b[0] - a[0]) * grid.pitch_mm, (b[1] - a[1]) * pitch_y_mm(grid));
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
  const steps = Math.max(1, Math.ceil(2 * length));
  const along_mm: number[] = [];
  const values: (number | null)[] = [];
  for (let i = 0; i <= steps; ++i) {
    const x = Math.round(a[0] + ((b[0] - a[0]) * i) / steps);
    const y = Math.round(a[1] + ((b[1] - a[1]) * i) / steps);
    const value = x >= 0 && y >= 0 && x < map.nx && y < map.ny ? map.values[y * map.nx + x] : NaN;
    along_mm.push((length_mm * i) / steps);
    values.push(Number.isFinite(value) ? value : null);
  }
  return {along_mm, values};
}

/** Smallest and largest finite value; [0, 0] where nothing was seen. */
export function extent(map: SurfaceMap): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const value of map.values)
    if (Number.isFinite(value)) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  return low <= high ? [low, high] : [0, 0];
}

/** Mean and root mean square of the seen cells, and how many these are. */
export function moments(map: SurfaceMap): {mean: number; rms: number; seen: number} {
  let seen = 0;
  let sum = 0;
  let squares = 0;
  for (const value of map.values)
    if (Number.isFinite(value)) {
      ++seen;
      sum += value;
      squares += value * value;
    }
  return seen ? {mean: sum / seen, rms: Math.sqrt(squares / seen), seen} : {mean: NaN, rms: NaN, seen};
}

/** Next of 1, 2, 5 times a power of ten that is at least `value`. */
export function rounded_up(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 2, 5, 10]) if (step * power >= value * (1 - 1e-9)) return step * power;
  return 10 * power;
}

export interface Scale {
  low: number;
  high: number;
  diverging: boolean;
  by_hand?: boolean;  // the reader set it
}

/** A scale that holds the map: symmetric about 0 for errors and differences, else from its smallest to its largest value.
 *  Errors end at the 99.5th percentile of their size, so that one splash does not hide the rest. */
export function fitted_scale(map: SurfaceMap, diverging: boolean): Scale {
  if (!diverging) {
    const [low, high] = extent(map);
    const step = rounded_up((high - low) / 50);
    const from = Math.floor(low / step) * step;
    return {low: from, high: Math.max(Math.ceil(high / step) * step, from + step), diverging};
  }
  const sizes = map.values.filter(Number.isFinite).map(Math.abs).sort();
  const most = rounded_up(sizes.length ? sizes[Math.floor(0.995 * (sizes.length - 1))] : 1);
  return {low: -most, high: most, diverging};
}

/** Share of the seen cells outside of the scale. */
export function clipped_share(map: SurfaceMap, scale: Scale): number {
  let outside = 0;
  let seen = 0;
  for (const value of map.values)
    if (Number.isFinite(value)) {
      ++seen;
      if (value < scale.low || value > scale.high) ++outside;
    }
  return seen ? outside / seen : 0;
}
