// Colour maps as tables of 256 colours: cividis, and the report's blue-white-orange, whose ends differ for every kind of
// colour vision.

import {kErrorColours} from "../generated/protocol";

type Colour = readonly [number, number, number];

/** Cividis by the polynomials of d3-scale-chromatic, t from 0 to 1. */
function cividis(t: number): Colour {
  return [
    -4.54 - t * (35.34 - t * (2381.73 - t * (6402.7 - t * (7024.72 - t * 2710.57)))),
    32.49 + t * (170.73 + t * (52.82 - t * (131.46 - t * (176.58 - t * 67.37)))),
    81.24 + t * (442.36 - t * (2482.43 - t * (6167.24 - t * (6614.94 - t * 2475.67)))),
  ];
}

function between(stops: readonly Colour[], t: number): Colour {
  const at = t * (stops.length - 1);
  const i = Math.min(Math.floor(at), stops.length - 2);
  return [0, 1, 2].map(c => stops[i][c] + (stops[i + 1][c] - stops[i][c]) * (at - i)) as unknown as Colour;
}

function table(of: (t: number) => Colour): Uint8Array {
  const bytes = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) {
    const colour = of(i / 255);
    for (let c = 0; c < 3; ++c) bytes[4 * i + c] = Math.max(0, Math.min(255, Math.round(colour[c])));
    bytes[4 * i + 3] = 255;
  }
  return bytes;
}

export const kCividis = table(cividis);
export const kDiverging = table(t => between(kErrorColours, t));

export function colours(diverging: boolean): Uint8Array {
  return diverging ? kDiverging : kCividis;
}

/** A colour map as CSS, from left to right or from below. */
export function gradient(diverging: boolean, direction: string): string {
  const bytes = colours(diverging);
  const stops = Array.from({length: 17}, (_, k) => {
    const i = Math.min(255, k * 16);
    return `rgb(${bytes[4 * i]},${bytes[4 * i + 1]},${bytes[4 * i + 2]})`;
  });
  return `linear-gradient(${direction},${stops.join(",")})`;
}

/** A colour of the page's theme, for canvases. */
export function theme(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || "#888";
}
