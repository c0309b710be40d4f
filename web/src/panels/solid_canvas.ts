// The surface in three dimensions: turned by dragging or by buttons.

import {html} from "htm/preact";
import {useEffect, useRef, useState} from "preact/hooks";
import type {Scale} from "../data/maps";
import {view} from "../data/view";
import {number, unit_words} from "../data/words";
import {kFirstTurn, turned, type Turn} from "../draw/solid_geometry";
import {SolidPainter} from "../draw/solid_painter";
import type {ShownMap} from "./shown_map";
import {use_repaint} from "./use_repaint";

const kStep = 0.2;

export function SolidCanvas({shown, scale}: {shown: ShownMap; scale: Scale}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const painter = useRef<SolidPainter | null>(null);
  const drag = useRef<{x: number; y: number} | null>(null);
  const [turn, set_turn] = useState<Turn>(kFirstTurn);
  const [trouble, set_trouble] = useState<string | null>(null);
  useEffect(() => {
    try {
      painter.current = new SolidPainter(canvas.current!);
    } catch (error) {
      set_trouble(`No 3-D here (${(error as Error).message}); the map shows the same values.`);
    }
    return () => painter.current?.end();
  }, []);
  const paint = () => {
    if (!shown.map || !painter.current?.paint(shown.map, scale, turn, view.cell)) return;
    canvas.current!.dataset.painted = `${shown.map.surface} ${shown.map.layer}`;
  };
  use_repaint(canvas, paint);
  useEffect(paint);

  const move = (event: PointerEvent) => {
    const box = canvas.current!.getBoundingClientRect();
    if (drag.current) {
      const [dx, dy] = [event.clientX - drag.current.x, event.clientY - drag.current.y];
      drag.current = {x: event.clientX, y: event.clientY};
      set_turn(now => turned(now, -dx * 0.008, dy * 0.008, 1));
    } else if (shown.map && painter.current) {
      view.cell = painter.current.cell_at(shown.map, scale, turn, event.clientX - box.left, event.clientY - box.top);
      view.changed();
    }
  };
  const buttons: [string, string, number, number, number][] = [
    ["⟲", "Turn left", -kStep, 0, 1], ["⟳", "Turn right", kStep, 0, 1], ["⤒", "Look from above", 0, kStep, 1],
    ["⤓", "Look from the side", 0, -kStep, 1], ["+", "Nearer", 0, 0, 0.85], ["−", "Farther", 0, 0, 1.18]];
  const width_mm = shown.grid.pitch_mm * Math.max(shown.grid.nx, shown.grid.ny);
  const in_mm = shown.unit === "um" ? 1000 : shown.unit === "mm" ? 1 : null;
  const per_mm = in_mm && (turn.lift * width_mm * in_mm) / (scale.high - scale.low);
  return html`
    <canvas ref=${canvas} class="solid" role="img" aria-label="The surface in three dimensions; the map shows the same values"
      onPointerDown=${(e: PointerEvent) => { drag.current = {x: e.clientX, y: e.clientY}; canvas.current!.setPointerCapture(e.pointerId); }}
      onPointerMove=${move} onPointerUp=${() => { drag.current = null; }} onPointerCancel=${() => { drag.current = null; }}
      onPointerLeave=${() => { view.cell = null; view.changed(); }}
      onWheel=${(e: WheelEvent) => { e.preventDefault(); set_turn(now => turned(now, 0, 0, Math.exp(e.deltaY * 0.001))); }}></canvas>
    ${trouble && html`<p class="empty" role="status">${trouble}</p>`}
    <div class="turn" role="group" aria-label="Turn the surface">
      ${buttons.map(([mark, words, around, up, zoom]) => html`
        <button key=${words} type="button" aria-label=${words} title=${words} onClick=${() => set_turn(turned(turn, around, up, zoom))}>${mark}</button>`)}
      ${per_mm && html`<span class="soft">heights × ${number(per_mm, 2)}${scale.diverging ? ", 0 in the middle" : `, floor at ${number(scale.low)} ${unit_words(shown.unit)}`}</span>`}
    </div>`;
}
