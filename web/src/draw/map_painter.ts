// A surface map on a canvas: cells as squares, axes in mm, the cell under the cursor and the line of a section.

import type {Grid} from "../data/protocol";
import {pitch_y_mm, type Scale, type SurfaceMap} from "../data/maps";
import {colours, theme} from "./colours";

export interface Marks {
  cell: [number, number] | null;
  cut: [[number, number], [number, number]] | null;
}

/** Where the map lies in the canvas, in CSS pixels; row 0 is below. */
export interface Placement {
  left: number;
  top: number;
  pixel: number;  // size of a cell
  nx: number;
  ny: number;
}

const kMargin = {left: 44, right: 10, top: 10, bottom: 30};
const kUnseen = [0, 0, 0, 0];

export function placement(width: number, height: number, nx: number, ny: number, bare = false): Placement {
  const margin = bare ? {left: 0, right: 0, top: 0, bottom: 0} : kMargin;
  const pixel = Math.max(0.1, Math.min((width - margin.left - margin.right) / nx, (height - margin.top - margin.bottom) / ny));
  return {left: margin.left + (width - margin.left - margin.right - pixel * nx) / 2,
          top: margin.top + (height - margin.top - margin.bottom - pixel * ny) / 2, pixel, nx, ny};
}

/** The cell at a place of the canvas, or null outside of the map. */
export function cell_at(place: Placement, x: number, y: number): [number, number] | null {
  const cell: [number, number] = [Math.floor((x - place.left) / place.pixel), place.ny - 1 - Math.floor((y - place.top) / place.pixel)];
  return cell[0] >= 0 && cell[1] >= 0 && cell[0] < place.nx && cell[1] < place.ny ? cell : null;
}

/** Colours of the cells as an image, row ny - 1 first; unseen cells stay clear. */
export function image_of(map: SurfaceMap, scale: Scale): ImageData {
  const image = new ImageData(map.nx, map.ny);
  const table = colours(scale.diverging);
  const factor = 255 / (scale.high - scale.low);
  for (let y = 0; y < map.ny; ++y)
    for (let x = 0; x < map.nx; ++x) {
      const value = map.values[y * map.nx + x];
      const at = 4 * ((map.ny - 1 - y) * map.nx + x);
      if (!Number.isFinite(value)) {
        image.data.set(kUnseen, at);
        continue;
      }
      const i = 4 * Math.max(0, Math.min(255, Math.round((value - scale.low) * factor)));
      image.data[at] = table[i];
      image.data[at + 1] = table[i + 1];
      image.data[at + 2] = table[i + 2];
      image.data[at + 3] = 255;
    }
  return image;
}

export class MapPainter {
  private readonly cells = document.createElement("canvas");
  private painted: SurfaceMap | null = null;
  private painted_scale = "";

  constructor(private readonly canvas: HTMLCanvasElement, private readonly bare = false) {}

  paint(map: SurfaceMap, grid: Grid, scale: Scale, marks: Marks): Placement {
    const {width, height, context} = fit(this.canvas);
    const place = placement(width, height, map.nx, map.ny, this.bare);
    this.paint_cells(map, scale);
    context.clearRect(0, 0, width, height);
    hatch(context, place);
    context.imageSmoothingEnabled = false;
    context.drawImage(this.cells, place.left, place.top, place.pixel * map.nx, place.pixel * map.ny);
    if (this.bare) return place;
    paint_axes(context, place, grid);
    if (marks.cut) paint_cut(context, place, marks.cut);
    if (marks.cell) paint_cell(context, place, marks.cell);
    return place;
  }

  private paint_cells(map: SurfaceMap, scale: Scale): void {
    const scale_key = `${scale.low} ${scale.high} ${scale.diverging}`;
    if (this.painted === map && this.painted_scale === scale_key) return;
    this.cells.width = map.nx;
    this.cells.height = map.ny;
    this.cells.getContext("2d")!.putImageData(image_of(map, scale), 0, 0);
    this.painted = map;
    this.painted_scale = scale_key;
  }
}

/** Makes the canvas as sharp as the screen; returns its size in CSS pixels, and the screen's pixels for each. */
export function fit(canvas: HTMLCanvasElement) {
  const ratio = Math.min(window.devicePixelRatio || 1, 3);
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d")!;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return {width, height, ratio, context};
}

/** The ground of cells that were not seen. */
function hatch(context: CanvasRenderingContext2D, place: Placement): void {
  const width = place.pixel * place.nx;
  const height = place.pixel * place.ny;
  context.save();
  context.beginPath();
  context.rect(place.left, place.top, width, height);
  context.clip();
  context.strokeStyle = theme("line");
  context.lineWidth = 1;
  context.beginPath();
  for (let x = -height; x < width; x += 7) {
    context.moveTo(place.left + x, place.top + height);
    context.lineTo(place.left + x + height, place.top);
  }
  context.stroke();
  context.restore();
}

function paint_axes(context: CanvasRenderingContext2D, place: Placement, grid: Grid): void {
  const bottom = place.top + place.pixel * place.ny;
  context.fillStyle = theme("soft");
  context.strokeStyle = theme("line");
  context.lineWidth = 1;
  context.strokeRect(place.left - 0.5, place.top - 0.5, place.pixel * place.nx + 1, place.pixel * place.ny + 1);
  context.font = "11px system-ui, sans-serif";
  const each = (from_mm: number, pitch_mm: number, count: number, put: (words: string, pixels: number) => void) => {
    const tick_mm = tick((pitch_mm * 55) / place.pixel);
    const first_mm = from_mm - pitch_mm / 2;  // outer edge of the first cell
    for (let k = Math.ceil(first_mm / tick_mm - 1e-9); ; ++k) {
      const pixels = ((k * tick_mm - first_mm) / pitch_mm) * place.pixel;
      if (pixels > place.pixel * count + 0.5) return;
      put(tick_words(k * tick_mm, tick_mm), pixels);
    }
  };
  context.textAlign = "center";
  context.textBaseline = "top";
  each(grid.x0_mm, grid.pitch_mm, place.nx, (words, x) => context.fillText(words, place.left + x, bottom + 4));
  context.textAlign = "right";
  context.textBaseline = "middle";
  each(grid.y0_mm, pitch_y_mm(grid), place.ny, (words, y) => context.fillText(words, place.left - 5, bottom - y));
  context.textAlign = "right";
  context.textBaseline = "bottom";
  context.fillText("mm", place.left + place.pixel * place.nx, bottom + 29);
}

/** The least of 1, 2, 5 times a power of ten that is at least `least`. */
function tick(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find(step => step * power >= least)!;
}

function tick_words(mm: number, tick_mm: number): string {
  return mm.toFixed(Math.max(0, -Math.floor(Math.log10(tick_mm) + 1e-9))).replace(/^-(?=0(\.0*)?$)/, "").replace("-", "−");
}

function centre(place: Placement, cell: [number, number]): [number, number] {
  return [place.left + (cell[0] + 0.5) * place.pixel, place.top + (place.ny - 0.5 - cell[1]) * place.pixel];
}

function paint_cell(context: CanvasRenderingContext2D, place: Placement, cell: [number, number]): void {
  const [x, y] = centre(place, cell);
  const size = Math.max(place.pixel, 5);
  for (const [colour, width] of [["#000", 3], ["#fff", 1.5]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.strokeRect(x - size / 2, y - size / 2, size, size);
  }
}

function paint_cut(context: CanvasRenderingContext2D, place: Placement, cut: [[number, number], [number, number]]): void {
  const [a, b] = cut.map(cell => centre(place, cell));
  for (const [colour, width] of [["#000", 4], ["#fff", 2]] as const) {
    context.strokeStyle = colour;
    context.fillStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(...(a as [number, number]));
    context.lineTo(...(b as [number, number]));
    context.stroke();
    for (const [x, y] of [a, b]) {
      context.beginPath();
      context.arc(x, y, width + 1, 0, 7);
      context.fill();
    }
  }
  context.font = "bold 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "bottom";
  for (const [word, [x, y]] of [["A", a], ["B", b]] as const) {
    context.lineWidth = 3;
    context.strokeStyle = "#000";
    context.strokeText(word, x, y - 6);
    context.fillStyle = "#fff";
    context.fillText(word, x, y - 6);
  }
}
