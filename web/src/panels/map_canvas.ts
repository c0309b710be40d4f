// The map that is pointed at, dragged over and walked with the keyboard.

import {html} from "htm/preact";
import {useEffect, useRef} from "preact/hooks";
import type {Scale} from "../data/maps";
import {view} from "../data/view";
import {cell_at, MapPainter, type Placement} from "../draw/map_painter";
import type {ShownMap} from "./shown_map";
import {use_repaint} from "./use_repaint";

type Cell = [number, number];
const same = (a: Cell, b: Cell) => a[0] === b[0] && a[1] === b[1];

export function MapCanvas({shown, scale}: {shown: ShownMap; scale: Scale}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const painter = useRef<MapPainter | null>(null);
  const place = useRef<Placement | null>(null);
  const start = useRef<Cell | null>(null);
  const paint = () => {
    painter.current ??= new MapPainter(canvas.current!);
    if (shown.map) place.current = painter.current.paint(shown.map, shown.grid, scale, {cell: view.cell, cut: view.cut});
    else canvas.current!.getContext("2d")!.clearRect(0, 0, canvas.current!.width, canvas.current!.height);
  };
  use_repaint(canvas, paint);
  useEffect(paint);

  const under = (event: PointerEvent): Cell | null => {
    const box = canvas.current!.getBoundingClientRect();
    return place.current && cell_at(place.current, event.clientX - box.left, event.clientY - box.top);
  };
  const down = (event: PointerEvent) => {
    if (event.button !== 0) return;
    start.current = under(event);
    canvas.current!.setPointerCapture(event.pointerId);
  };
  const move = (event: PointerEvent) => {
    const cell = under(event);
    view.cell = cell;
    if (start.current && cell && !same(start.current, cell)) view.cut = [start.current, cell];
    view.changed();
  };
  const up = (event: PointerEvent) => {
    const cell = under(event);
    if (start.current && cell) view.cut = same(start.current, cell) ? null : [start.current, cell];
    start.current = null;
    view.changed();
  };
  const key = (event: KeyboardEvent) => {
    if (!shown.map) return;
    const {nx, ny} = shown.map;
    const step = ({ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]} as Record<string, Cell>)[event.key];
    const cell: Cell = view.cell ?? [nx >> 1, ny >> 1];
    if (step && event.shiftKey)
      view.cell = [Math.max(0, Math.min(nx - 1, cell[0] + step[0])), Math.max(0, Math.min(ny - 1, cell[1] + step[1]))];
    else if (event.key === "Enter") {
      view.cut = start.current ? [start.current, cell] : null;
      start.current = start.current ? null : cell;
    } else if (event.key === "Escape") {
      view.cut = null;
      start.current = null;
    } else return;
    event.preventDefault();
    view.changed();
  };
  return html`<canvas ref=${canvas} class="map" tabindex="0" role="application"
    aria-label="Map of the surface. Shift and arrows move the cell, Enter sets the ends of a section, Escape removes it."
    onPointerDown=${down} onPointerMove=${move} onPointerUp=${up} onPointerCancel=${() => { start.current = null; }} onKeyDown=${key}
    onPointerLeave=${() => { view.cell = null; view.changed(); }}></canvas>`;
}
