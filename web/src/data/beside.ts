// Maps of runs beside each other: one unit, one scale.

import {fitted_scale, type Scale, type SurfaceMap} from "./maps";

const kUmPerMm = 1000;
const converted = new WeakMap<SurfaceMap, SurfaceMap>();  // so that a map's difference is computed once

/** Heights in the unit of the run that the others are compared with; "um" or "mm". */
export function in_unit_of(map: SurfaceMap, unit: string): SurfaceMap {
  const own = map.unit ?? "um";
  if (own === unit || !["um", "mm"].includes(own)) return map;
  let other = converted.get(map);
  if (!other) {
    const factor = own === "mm" ? kUmPerMm : 1 / kUmPerMm;
    other = {...map, unit, values: map.values.map(value => value * factor)};
    converted.set(map, other);
  }
  return other;
}

/** The scale that holds all maps, in whatever order they came. */
export function common_scale(maps: SurfaceMap[], diverging: boolean): Scale {
  const scales = maps.map(map => fitted_scale(map, diverging));
  return {low: Math.min(...scales.map(s => s.low)), high: Math.max(...scales.map(s => s.high)), diverging};
}
