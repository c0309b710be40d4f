// Which map the reader sees: the one under the cursor, or the last that came while the next is on its way.

import {difference, extent, fitted_scale, clipped_share, type Scale, type SurfaceMap} from "../data/maps";
import {kMapFactor, type Grid} from "../data/protocol";
import type {Session} from "../data/session";
import type {Shown, View} from "../data/view";

const kMostClipped = 0.02;  // share of cells
const kMostWide = 8;         // times the fitted scale

export interface ShownMap {
  map: SurfaceMap | null;
  grid: Grid;
  unit: string;
  diverging: boolean;
  missing: string | null;
}

export function is_diverging(shown: Shown): boolean {
  return shown === "error" || shown === "difference";
}

export function unit_of(map: SurfaceMap | null): string {
  return map?.unit ?? "um";
}

/** The layer that a difference is taken to: as chosen, else the cursor's layer of another run, else the one before. */
export function other_layer(view: View): number {
  return view.other_layer ?? (view.other_run ? view.shown_layer : view.session?.stop_at(view.shown_layer - 1) ?? 0);
}

let last_difference: {a: SurfaceMap; b: SurfaceMap; map: SurfaceMap} | null = null;

export function shown_map(view: View, session: Session): ShownMap {
  const grid = session.grid;
  const diverging = is_diverging(view.surface);
  const newest = view.layer == null && session.live;
  const surface = view.surface === "difference" ? "measured" : view.surface;
  const a = (newest ? session.maps.newest(surface) : null) ?? session.maps.get(surface, view.shown_layer);
  let missing = session.maps.missing(surface, view.shown_layer);
  if (view.surface !== "difference" || !a)
    return {map: a, grid, unit: unit_of(a), diverging: diverging || !!(a && a.flags & kMapFactor && extent(a)[0] < 0), missing: a ? null : missing};

  const other = view.other_run ?? session;
  const b = other.maps.get("measured", other_layer(view));
  missing = other.maps.missing("measured", other_layer(view));
  if (!b) return {map: null, grid, unit: unit_of(a), diverging, missing};
  if (last_difference?.a !== a || last_difference.b !== b)
    last_difference = {a, b, map: difference(a, grid, b, other.grid)};
  return {map: last_difference.map, grid, unit: unit_of(a), diverging, missing: null};
}

/** The held scale. The first map sets it; after that it changes by the reader's hand, or while the cursor follows a live
 *  print that has grown out of it or become far smaller. */
export function held_scale(view: View, shown: ShownMap, following: boolean): Scale {
  const held = view.scales.get(view.surface);
  if (!shown.map) return held ?? {low: 0, high: 1, diverging: shown.diverging};
  if (held && (held.by_hand || !following)) return held;
  const fitted = fitted_scale(shown.map, shown.diverging);
  const fits = held && clipped_share(shown.map, held) <= kMostClipped && held.high - held.low < kMostWide * (fitted.high - fitted.low);
  const scale = fits ? held : fitted;
  view.scales.set(view.surface, scale);
  return scale;
}
