// The surface: as a map or in three dimensions, with the value under the cursor and a section by dragging.

import {html} from "htm/preact";
import {useEffect} from "preact/hooks";
import {clipped_share, fitted_scale, moments, pitch_y_mm, type Scale} from "../data/maps";
import {use_observed} from "../data/observable";
import {kMapPartial, kSurfaces, kSurfaceWords} from "../data/protocol";
import type {Session} from "../data/session";
import {view, type Shown} from "../data/view";
import {label, number, unit_words, with_unit} from "../data/words";
import {gradient} from "../draw/colours";
import {MapCanvas} from "./map_canvas";
import {Section} from "./section";
import {held_scale, other_layer, shown_map, type ShownMap} from "./shown_map";
import {SolidCanvas} from "./solid_canvas";

export function Surface({session}: {session: Session}) {
  use_observed(session, session.maps, view, view.other_run, view.other_run?.maps ?? null);
  const following = session.live && view.layer == null;
  const followed = view.surface === "difference" ? "measured" : view.surface;
  useEffect(() => {
    if (session.live) session.follow(following ? followed : null);
  }, [session, session.connected, following, followed]);

  const shown = shown_map(view, session);
  const scale = held_scale(view, shown, following);
  const canvas = view.mode === "map" ? MapCanvas : SolidCanvas;
  return html`
    <section class="panel surface" aria-labelledby="surface-title">
      <div class="row head">
        <h2 id="surface-title">Surface</h2>
        <label>Show <select value=${view.surface} onChange=${(e: Event) => show((e.target as HTMLSelectElement).value as Shown)}>
          ${kSurfaces.filter(name => name !== "truth" || session.hello.run.simulated).map(name => html`
            <option key=${name} value=${name}>${kSurfaceWords[name]}</option>`)}
          <option value="difference">difference to…</option>
        </select></label>
        <span class="switch" role="group" aria-label="View">
          ${(["map", "solid"] as const).map(mode => html`
            <button key=${mode} type="button" aria-pressed=${view.mode === mode ? "true" : "false"}
              onClick=${() => { view.mode = mode; view.changed(); }}>${mode === "map" ? "Map" : "3-D"}</button>`)}
        </span>
        ${view.surface === "difference" && html`<${Other} session=${session} />`}
      </div>
      <div class="stage">
        <${canvas} shown=${shown} scale=${scale} />
        ${!shown.map && html`<p class="empty" role="status">${empty_words(session, shown)}</p>`}
      </div>
      <${ColourBar} shown=${shown} scale=${scale} />
      <${Readout} shown=${shown} />
      ${view.cut && shown.map && html`<${Section} session=${session} shown=${shown} cut=${view.cut} />`}
    </section>`;
}

function show(surface: Shown): void {
  view.surface = surface;
  view.changed();
  if (surface === "difference" && !view.runs) void view.load_runs();
}

function empty_words(session: Session, shown: ShownMap): string {
  const layer = view.shown_layer === 0 ? "the bare substrate" : `layer ${view.shown_layer}`;
  if (!shown.missing) return session.layers.length || view.layer != null ? `loading ${layer}…` : "nothing has been measured yet";
  return `${layer}: ${shown.missing}`;
}

function Other({session}: {session: Session}) {
  const runs = (view.runs ?? []).filter(run => run.id !== session.hello.run.id);
  const last = (view.other_run ?? session).last_layer;
  const take = (text: string) => {
    view.other_layer = text === "" ? null : Math.max(0, Math.min(last, Math.round(Number(text)) || 0));
    view.scales.delete("difference");
    view.changed();
  };
  return html`
    <label>Run <select value=${view.other_run?.hello.run.id ?? ""} onChange=${(e: Event) => void view.take_other((e.target as HTMLSelectElement).value || null)}>
      <option value="">this run</option>
      ${runs.map(run => html`<option key=${run.id} value=${run.id}>${label(run)}</option>`)}
    </select></label>
    <label>Layer <input class="short" type="number" min="0" max=${last} placeholder=${String(other_layer(view))}
      value=${view.other_layer ?? ""} onChange=${(e: Event) => take((e.target as HTMLInputElement).value)} /></label>`;
}

function ColourBar({shown, scale}: {shown: ShownMap; scale: Scale}) {
  const set = (changes: Partial<Scale>, by_hand = true) => {
    const next = {...scale, ...changes};
    if (Number.isFinite(next.low) && Number.isFinite(next.high) && next.low < next.high) view.scales.set(view.surface, {...next, by_hand});
    view.changed();
  };
  const value = (e: Event) => Number((e.target as HTMLInputElement).value || NaN);
  const clipped = shown.map ? clipped_share(shown.map, scale) : 0;
  const unit = unit_words(shown.unit);
  return html`
    <div class="scale row" role="group" aria-label="Colour scale, held until changed">
      ${scale.diverging
        ? html`<span>−${number(scale.high)}</span>`
        : html`<label class="bare"><span class="hidden">Lowest</span><input class="short" value=${String(scale.low)} onChange=${(e: Event) => set({low: value(e)})} /></label>`}
      <span class="bar" style=${{backgroundImage: gradient(scale.diverging, "to right")}}></span>
      <label class="bare"><span class="hidden">${scale.diverging ? "Largest size" : "Highest"}</span>
        <input class="short" value=${String(scale.high)} onChange=${(e: Event) => {
          const high = value(e);
          set(scale.diverging ? {low: -high, high} : {high});
        }} /></label>
      <span>${unit}</span>
      <button type="button" disabled=${!shown.map} onClick=${() => set(fitted_scale(shown.map!, scale.diverging), false)}>Fit</button>
      <span class="soft">${clipped > 0.0005 ? `${number(100 * clipped, 2)} % of the cells lie outside` : "scale is held"}</span>
    </div>`;
}

function Readout({shown}: {shown: ShownMap}) {
  const {map, grid, unit} = shown;
  const cell = view.cell;
  const seen = map ? moments(map) : null;
  const inside = map && cell && cell[0] < map.nx && cell[1] < map.ny;
  const value = inside ? map.values[cell[1] * map.nx + cell[0]] : NaN;
  return html`
    <p class="readout" aria-live="off">
      ${inside
        ? html`<b>${Number.isFinite(value) ? with_unit(value, unit) || number(value) : "not seen"}</b>
            ${` cell ${cell[0]}, ${cell[1]} at ${number(grid.x0_mm + cell[0] * grid.pitch_mm)}, ${number(grid.y0_mm + cell[1] * pitch_y_mm(grid))} mm`}`
        : html`<span class="soft">${view.mode === "map" ? "Point at a cell for its value; drag for a section. Keyboard: Shift-arrows move the cell, Enter sets A, then B." : "Drag to turn, wheel to zoom, point at a cell for its value."}</span>`}
      ${seen && html`<span class="soft">${` All of layer ${map!.layer}${map!.flags & kMapPartial ? ", being measured" : ""}: mean ${with_unit(seen.mean, unit)}, RMS ${with_unit(seen.rms, unit)}, ${number(seen.seen)} of ${number(map!.values.length)} cells seen`}</span>`}
    </p>`;
}
