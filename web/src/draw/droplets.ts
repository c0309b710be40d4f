// Droplets of a plan as dots over a map, each where it lands in its cell.

import type {SurfaceMap} from "../data/maps";
import {fit, type Placement} from "./map_painter";

/** Paints the dots once for a plan and a size; a moving cursor only copies them. */
export class DropletPainter {
  private readonly dots = document.createElement("canvas");
  private painted: SurfaceMap | null = null;
  private painted_for = "";

  paint(canvas: HTMLCanvasElement, place: Placement, plan: SurfaceMap): void {
    const {context, ratio} = fit(canvas);
    const size = `${place.pixel} ${ratio}`;
    if (this.painted !== plan || this.painted_for !== size) {
      this.dots.width = Math.ceil(place.pixel * plan.nx * ratio);
      this.dots.height = Math.ceil(place.pixel * plan.ny * ratio);
      paint_dots(this.dots.getContext("2d")!, place.pixel * ratio, plan);
      this.painted = plan;
      this.painted_for = size;
    }
    context.drawImage(this.dots, place.left, place.top, this.dots.width / ratio, this.dots.height / ratio);
  }
}

/** The middle of a cell's dot, in cells from the left and from the top. */
export function dot_at(plan: SurfaceMap, x: number, y: number): [number, number] {
  const cell = y * plan.nx + x;
  return [x + 0.5 + (plan.places?.x[cell] ?? 0), plan.ny - 0.5 - y - (plan.places?.y[cell] ?? 0)];
}

function paint_dots(context: CanvasRenderingContext2D, pixel: number, plan: SurfaceMap): void {
  context.fillStyle = "#111";
  context.strokeStyle = "#fff";
  context.lineWidth = Math.min(1, pixel / 8);
  for (let y = 0; y < plan.ny; ++y)
    for (let x = 0; x < plan.nx; ++x) {
      const count = plan.values[y * plan.nx + x];
      if (!(count > 0)) continue;
      const radius = Math.max(Math.min(0.5, 0.22 * Math.sqrt(count)) * pixel, 0.4);
      const [left, top] = dot_at(plan, x, y).map(cells => cells * pixel);
      if (pixel < 4) {
        context.fillRect(left - radius, top - radius, 2 * radius, 2 * radius);
        continue;
      }
      context.beginPath();
      context.arc(left, top, radius, 0, 7);
      context.fill();
      context.stroke();
    }
}
