// Droplets of a plan as dots over a map.

import type {SurfaceMap} from "../data/maps";
import {fit, type Placement} from "./map_painter";

export function paint_droplets(canvas: HTMLCanvasElement, place: Placement, plan: SurfaceMap): void {
  const {context} = fit(canvas);
  context.fillStyle = "#111";
  context.strokeStyle = "#fff";
  context.lineWidth = Math.min(1, place.pixel / 8);
  for (let y = 0; y < plan.ny; ++y)
    for (let x = 0; x < plan.nx; ++x) {
      const count = plan.values[y * plan.nx + x];
      if (!(count > 0)) continue;
      const radius = Math.min(0.5, 0.22 * Math.sqrt(count)) * place.pixel;
      context.beginPath();
      context.arc(place.left + (x + 0.5) * place.pixel, place.top + (place.ny - 0.5 - y) * place.pixel, Math.max(radius, 0.4), 0, 7);
      context.fill();
      if (place.pixel > 4) context.stroke();
    }
}
