// Two or more runs beside each other: surfaces at one layer and one scale, RMS curves, the settings that differ.

import {html} from "htm/preact";
import {useEffect, useMemo, useRef} from "preact/hooks";
import {common_scale, in_unit_of} from "../data/beside";
import {difference, fitted_scale, moments, type Scale, type SurfaceMap} from "../data/maps";
import {use_observed} from "../data/observable";
import {kSurfaceWords, type Surface} from "../data/protocol";
import type {Session} from "../data/session";
import {differing, value_words} from "../data/settings";
import {view} from "../data/view";
import {height_words, in_height_unit, label, number, unit_words, with_unit} from "../data/words";
import {gradient} from "../draw/colours";
import {MapPainter} from "../draw/map_painter";
import {Plot} from "../draw/plot";
import {ReportLink} from "./runs";
import {is_diverging, unit_of} from "./shown_map";
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
  const unit = sessions[0].height_unit;
  const maps = sessions.map(one => {
    const map = one.maps.get(surface, one.stop_at(layer));
    return map && in_unit_of(map, unit);
  });
  const key = `beside ${surface} ${sessions.map(one => one.hello.run.id).join(" ")}`;
  const first = maps.find(Boolean);
  if (first && maps.every((map, i) => map || sessions[i].maps.missing(surface, sessions[i].stop_at(layer))) && !view.scales.has(key))
    view.scales.set(key, common_scale(maps.filter((map): map is SurfaceMap => !!map), is_diverging(surface)));
  const scale = view.scales.get(key) ?? (first ? fitted_scale(first, is_diverging(surface)) : {low: 0, high: 1, diverging: false});
  const names = names_of(sessions);
  const rests = useMemo(() => maps.map((map, i) => i > 0 && map && maps[0] ? difference(maps[0], sessions[0].grid, map, sessions[i].grid) : null), maps);
  const apart = rests.filter((rest): rest is SurfaceMap => !!rest);
  const apart_scale = apart.length ? common_scale(apart, true) : scale;
  return html`
    <section class="panel" aria-labelledby="beside-title">
      <div class="row head">
        <h2 id="beside-title">Surfaces, layer ${layer}</h2>
        <label>Show <select value=${surface} onChange=${(e: Event) => { view.surface = (e.target as HTMLSelectElement).value as Surface; view.changed(); }}>
          ${kOffered.map(name => html`<option key=${name} value=${name}>${kSurfaceWords[name]}</option>`)}</select></label>
        <span class="scale row"><span>${number(scale.low)}</span><span class="bar" style=${{backgroundImage: gradient(scale.diverging, "to right")}}></span>
          <span>${with_unit(scale.high, unit_of(first ?? null))}</span></span>
        <button type="button" onClick=${() => { view.scales.delete(key); view.changed(); }}>Fit</button>
        <${ReportLink} runs=${sessions.map(one => one.hello.run.id)} />
      </div>
      <div class="beside">
        ${sessions.map((session, i) => html`<${Tile} key=${session.hello.run.id} name=${names[i]} session=${session} map=${maps[i]} scale=${scale}
          words=${tile_words(session, maps[i], surface, layer, unit)} />`)}
        ${rests.map((rest, i) => i > 0 && html`<${Tile} key=${`apart ${sessions[i].hello.run.id}`} name=${`${names[0]} minus ${names[i]}`} session=${sessions[0]} map=${rest}
          scale=${apart_scale} words=${rest ? rest_words(rest, apart_scale) : missing_words(sessions[maps[0] ? i : 0], surface, layer)} />`)}
      </div>
    </section>`;
}

function missing_words(session: Session, surface: Surface, layer: number): string {
  return session.maps.missing(surface, session.stop_at(layer)) ?? "loading…";
}

function rest_words(rest: SurfaceMap, scale: Scale): string {
  const {rms, seen} = moments(rest);
  return seen === 0 ? "no cell was seen in both" : `RMS ${with_unit(rms, unit_of(rest))}, scale ±${with_unit(scale.high, unit_of(rest))}`;
}

function tile_words(session: Session, map: SurfaceMap | null, surface: Surface, layer: number, unit: string): string {
  if (!map) return missing_words(session, surface, layer);
  const {mean, rms} = moments(map);
  const told = session.layer(map.layer)?.rms_um;  // over the cells by which the print is judged
  const numbers = [`mean ${with_unit(mean, unit_of(map))}`];
  if (surface === "error") numbers.push(`RMS ${told == null ? with_unit(rms, unit_of(map)) : height_words(told, unit)}`);
  return numbers.join(", ") + (layer > session.last_layer ? ` at its end, layer ${map.layer}` : "");
}

/** The scheme, and the run's own name where two runs have the same scheme. */
function names_of(sessions: Session[]): string[] {
  const scheme = (one: Session) => one.hello.run.scheme;
  return sessions.map(one => sessions.filter(other => scheme(other) === scheme(one)).length > 1 ? `${scheme(one)}: ${label(one.hello.run)}` : scheme(one));
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
      const by_layer = new Map(one.layers.map(layer => [layer.n, in_height_unit(layer.rms_um, sessions[0].height_unit) || null]));
      return layers.map(n => by_layer.get(n) ?? null);
    })];
  }, [sessions.map(one => one.hello.run.id).join("\n"), count]);
  return html`
    <section class="panel" aria-labelledby="curves-title">
      <h2 id="curves-title">RMS error</h2>
      <${Plot} words="RMS error of each layer, a curve for each run" x_label="layer" y_label=${`RMS error, ${unit_words(sessions[0].height_unit)}, logarithmic`} height=${240} logarithmic
        curves=${names_of(sessions).map((name, i) => ({label: name, colour: kColours[i % 6], dash: kDashes[i % 6]}))}
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
          <thead><tr><th scope="col">Key</th>${names_of(sessions).map(name => html`<th key=${name} scope="col">${name}</th>`)}</tr></thead>
          <tbody>${rows.map(row => html`<tr key=${row.key}><td><code>${row.key}</code></td>
            ${row.values.map((value, i) => html`<td key=${i}>${value_words(value)} ${value === undefined ? "" : unit_words(row.unit)}</td>`)}</tr>`)}</tbody>
        </table></div>`}
    </section>`;
}
