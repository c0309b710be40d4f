// Two or more runs beside each other: surfaces at one layer and one scale, RMS curves, the settings that differ.

import {html} from "htm/preact";
import {useEffect, useMemo, useRef} from "preact/hooks";
import {difference, fitted_scale, moments, type Scale, type SurfaceMap} from "../data/maps";
import {use_observed} from "../data/observable";
import {kSurfaceWords, type Surface} from "../data/protocol";
import type {Session} from "../data/session";
import {differing, value_words} from "../data/settings";
import {view} from "../data/view";
import {number, unit_words, with_unit} from "../data/words";
import {gradient} from "../draw/colours";
import {MapPainter} from "../draw/map_painter";
import {Plot} from "../draw/plot";
import {ReportLink} from "./runs";
import {is_diverging} from "./shown_map";
import {Timeline} from "./timeline";
import {use_repaint} from "./use_repaint";

const kColours = ["one", "two", "three", "four", "five", "six"];
const kDashes = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 5], [1, 5]];
const kOffered: Surface[] = ["error", "measured", "target", "planned"];

export function Compare() {
  const sessions = view.sessions_beside();
  use_observed(view, ...Array.from({length: 6}, (_, i) => sessions[i]?.maps ?? null));
  useEffect(() => void view.load_beside(), [view.chosen.join("\n")]);
  const failed = view.chosen.map(id => [id, view.beside.get(id)] as const).filter(([, one]) => one && "error" in one);
  return html`
    <${Timeline} session=${null} />
    ${failed.map(([id, one]) => html`<p key=${id} class="bad" role="alert">${id}: ${(one as {error: string}).error}</p>`)}
    ${sessions.length < view.chosen.length - failed.length && html`<p role="status">loading…</p>`}
    ${sessions.length > 0 && html`<${Surfaces} sessions=${sessions} /><${Curves} sessions=${sessions} /><${Differences} sessions=${sessions} />`}`;
}

function Surfaces({sessions}: {sessions: Session[]}) {
  const surface: Surface = view.surface === "difference" ? "error" : view.surface;
  const layer = view.shown_layer;
  const maps = sessions.map(one => one.maps.get(surface, one.stop_at(layer)));
  const key = `beside ${surface}`;
  const first = maps.find(Boolean);
  if (first && maps.every((map, i) => map || sessions[i].maps.missing(surface, sessions[i].stop_at(layer))) && !view.scales.has(key))
    view.scales.set(key, common_scale(maps.filter((map): map is SurfaceMap => !!map), is_diverging(surface)));
  const scale = view.scales.get(key) ?? (first ? fitted_scale(first, is_diverging(surface)) : {low: 0, high: 1, diverging: false});
  const [a, b] = sessions;
  const height = sessions.length === 2 && maps[0] && maps[1];
  const rest = useMemo(() => height ? difference(maps[0]!, a.grid, maps[1]!, b.grid) : null, [maps[0], maps[1]]);
  return html`
    <section class="panel" aria-labelledby="beside-title">
      <div class="row head">
        <h2 id="beside-title">Surfaces, layer ${layer}</h2>
        <label>Show <select value=${surface} onChange=${(e: Event) => { view.surface = (e.target as HTMLSelectElement).value as Surface; view.changed(); }}>
          ${kOffered.map(name => html`<option key=${name} value=${name}>${kSurfaceWords[name]}</option>`)}</select></label>
        <span class="scale row"><span>${number(scale.low)}</span><span class="bar" style=${{backgroundImage: gradient(scale.diverging, "to right")}}></span>
          <span>${number(scale.high)} ${surface === "planned" ? "" : unit_words("um")}</span></span>
        <button type="button" onClick=${() => { view.scales.delete(key); view.changed(); }}>Fit</button>
        <${ReportLink} runs=${sessions.map(one => one.hello.run.id)} />
      </div>
      <div class="beside">
        ${sessions.map((session, i) => html`<${Tile} key=${session.hello.run.id} name=${session.hello.run.id} session=${session} map=${maps[i]} scale=${scale}
          words=${tile_words(session, maps[i], surface, layer)} />`)}
        ${rest && html`<${Tile} name="first minus second" session=${a} map=${rest} scale=${fitted_scale(rest, true)}
          words=${`RMS ${with_unit(moments(rest).rms, "um")}, scale ±${with_unit(fitted_scale(rest, true).high, "um")}`} />`}
      </div>
    </section>`;
}

function common_scale(maps: SurfaceMap[], diverging: boolean): Scale {
  const scales = maps.map(map => fitted_scale(map, diverging));
  return {low: Math.min(...scales.map(s => s.low)), high: Math.max(...scales.map(s => s.high)), diverging};
}

function tile_words(session: Session, map: SurfaceMap | null, surface: Surface, layer: number): string {
  if (layer > session.last_layer) return `has only ${session.last_layer} layers: its last is shown`;
  if (!map) return session.maps.missing(surface, session.stop_at(layer)) ?? "loading…";
  const {mean, rms} = moments(map);
  return surface === "error" ? `mean ${with_unit(mean, "um")}, RMS ${with_unit(rms, "um")}` : `mean ${number(mean)}`;
}

function Tile({name, session, map, scale, words}: {name: string; session: Session; map: SurfaceMap | null; scale: Scale; words: string}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const painter = useRef<MapPainter | null>(null);
  const paint = () => {
    painter.current ??= new MapPainter(canvas.current!);
    if (map) painter.current.paint(map, session.grid, scale, {cell: null, cut: null});
  };
  use_repaint(canvas, paint);
  useEffect(paint);
  return html`<figure><canvas ref=${canvas} class="tile" role="img" aria-label=${`${name}: ${words}`}></canvas>
    <figcaption><b>${name}</b><span>${words}</span></figcaption></figure>`;
}

function Curves({sessions}: {sessions: Session[]}) {
  const count = sessions.map(one => one.layers.length).join(" ");
  const data = useMemo(() => {
    const layers = [...new Set(sessions.flatMap(one => one.layers.map(layer => layer.n)))].sort((a, b) => a - b);
    return [layers, ...sessions.map(one => {
      const by_layer = new Map(one.layers.map(layer => [layer.n, layer.rms_um]));
      return layers.map(n => by_layer.get(n) ?? null);
    })];
  }, [sessions.map(one => one.hello.run.id).join("\n"), count]);
  return html`
    <section class="panel" aria-labelledby="curves-title">
      <h2 id="curves-title">RMS error</h2>
      <${Plot} words="RMS error of each layer, a curve for each run" x_label="layer" y_label="RMS error, µm" height=${240}
        curves=${sessions.map((one, i) => ({label: one.hello.run.id, colour: kColours[i % 6], dash: kDashes[i % 6]}))}
        data=${data} mark=${view.shown_layer} pick=${(n: number) => view.move_to(n)} />
    </section>`;
}

function Differences({sessions}: {sessions: Session[]}) {
  const rows = differing(sessions.map(one => one.hello.run.settings ?? []));
  return html`
    <section class="panel" aria-labelledby="differences-title">
      <h2 id="differences-title">Settings that differ</h2>
      ${rows.length === 0 ? html`<p>None: these runs have the same settings.</p>` : html`
        <div class="scroll" tabindex="0" role="region" aria-label="Table of differing settings"><table>
          <thead><tr><th scope="col">Key</th>${sessions.map(one => html`<th key=${one.hello.run.id} scope="col">${one.hello.run.id}</th>`)}</tr></thead>
          <tbody>${rows.map(row => html`<tr key=${row.key}><td><code>${row.key}</code></td>
            ${row.values.map((value, i) => html`<td key=${i}>${value_words(value)} ${value === undefined ? "" : unit_words(row.unit)}</td>`)}</tr>`)}</tbody>
        </table></div>`}
    </section>`;
}
