// The state of the print in words and the numbers of the layer under the cursor, each with its age.

import {html} from "htm/preact";
import {use_clock, use_observed} from "../data/observable";
import type {Layer} from "../data/protocol";
import {kOldest_s, type Session} from "../data/session";
import {view} from "../data/view";
import {duration, height_words, in_height_unit, number, unit_words} from "../data/words";

export function Now({session}: {session: Session}) {
  use_observed(session, view);
  use_clock(250, session.live);
  const layer = session.layer(view.shown_layer);
  const state = session.state;
  const newest = view.shown_layer === session.last_layer;
  return html`
    <section class=${"panel now" + (session.stale && !session.connecting ? " stale" : "")} aria-labelledby="now-title">
      <h2 id="now-title">${view.layer == null && session.live ? "Now" : `Layer ${view.shown_layer}`}</h2>
      ${layer?.rms_um != null && html`<p class="soft">Errors and edge are those of the measured surface.</p>`}
      <dl class="numbers">
        <${Value} name="RMS error" value=${in_height_unit(layer?.rms_um, session.height_unit)} unit=${session.height_unit} trend=${trend(session, "rms_um")} />
        <${Value} name="Mean error" value=${in_height_unit(layer?.mean_um, session.height_unit)} unit=${session.height_unit} trend=${trend(session, "mean_um")} />
        <${Value} name="Largest error" value=${in_height_unit(layer?.max_um, session.height_unit)} unit=${session.height_unit} />
        ${layer?.overspill_percent != null && html`<${Value} name="Overspill" value=${layer.overspill_percent} unit="percent" />`}
        ${layer?.missing_percent != null && html`<${Value} name="Missing inside" value=${layer.missing_percent} unit="percent" />`}
        ${kEdge.map(([name, key]) => layer?.[key] != null && html`
          <${Value} key=${key} name=${layer.size_cut && key.startsWith("size") ? `${name}, at least` : name} value=${in_height_unit(layer[key], session.height_unit)} unit=${session.height_unit} />`)}
        ${layer?.droplets != null && html`<${Value} name=${capital(session.hello.run.amount ?? "droplets")} value=${layer.droplets} />`}
        ${layer?.decision_ms != null && html`<${Value} name="Decision took" value=${layer.decision_ms} unit="ms" />`}
        ${newest && state?.flow && html`<${Value} name="Flow" value=${state.flow.value} unit=${state.flow.unit}
          after=${state.flow.low != null && state.flow.high != null ? `${number(state.flow.low)} to ${number(state.flow.high)}` : ""} />`}
        ${Object.entries((newest && state?.temperatures) || {}).map(([name, one]) => html`
          <${Value} key=${name} name=${words_of(name)} value=${one?.value} unit=${one?.unit} after=${one?.set == null ? "" : `set to ${number(one.set)}`} />`)}
        ${Object.entries((newest && state?.interval) || {}).map(([name, value]) => html`
          <${Value} key=${name} name=${words_of(name)} value=${value} />`)}
      </dl>
      <${Trend} session=${session} />
      ${session.live && html`<${Ages} session=${session} />`}
    </section>`;
}

// Of a part with an outline; the report has the same words.
const kEdge: [string, "first_ring_um" | "size_x_um" | "size_y_um" | "edge_width_um"][] = [["First ring", "first_ring_um"],
  ["Size error x", "size_x_um"], ["Size error y", "size_y_um"], ["Edge width", "edge_width_um"]];

function words_of(name: string): string {
  if (name === "words") return "Interval";
  const words = name.replace(/_(degC|um|mm|s)$/, "").replace(/_/g, " ");
  return capital(words);
}

function capital(words: string): string {
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function Value({name, value, unit = "", trend = "", after = ""}:
               {name: string; value: unknown; unit?: string; trend?: string; after?: string}) {
  return html`<div><dt>${name}</dt><dd><b>${number(value)}</b> ${number(value) === "–" ? "" : unit_words(unit)}
    ${after && html`<span class="soft">${after}</span>`}${trend && html`<span class="soft"> ${trend}</span>`}</dd></div>`;
}

/** How the size of a number moved over the five layers before the cursor. */
function trend(session: Session, what: "rms_um" | "mean_um"): string {
  const now = session.layer(view.shown_layer)?.[what];
  const at = session.layers.findIndex(layer => layer.n === view.shown_layer);
  const before = session.layers[at - 5]?.[what];
  if (now == null || before == null) return "";
  const change = Math.abs(now) - Math.abs(before);
  if (Math.abs(change) < 0.03 * Math.max(Math.abs(before), 1e-9)) return "→ steady";
  return change < 0 ? "↘ falling" : "↗ rising";
}

const kAges: [string, string][] = [["link_s", "print"], ["surface_s", "surface"], ["instruments_s", "instruments"], ["controller_s", "controller"]];

function Ages({session}: {session: Session}) {
  return html`<dl class="ages" aria-label="Age of the data">
    ${kAges.map(([key, name]) => {
      const age = key === "link_s" && session.connected ? session.link_age_s : session.age_s(key);
      const old = !session.connected || age == null || age > kOldest_s;
      return html`<div key=${key} class=${old ? "old" : ""}><dt>${name}</dt><dd>${age == null ? "nothing yet" : `${duration(age)} ago`}</dd></div>`;
    })}</dl>`;
}

/** RMS of every layer as a line, the cursor's layer as a point. */
function Trend({session}: {session: Session}) {
  const points = session.layers.filter((layer): layer is Layer & {rms_um: number} => layer.rms_um != null);
  if (points.length < 2) return null;
  const width = 300;
  const height = 54;
  const most = Math.max(...points.map(p => p.rms_um)) || 1;
  const first = points[0].n;
  const last = points[points.length - 1].n;
  const place = (p: {n: number; rms_um: number}) =>
    `${(4 + ((width - 8) * (p.n - first)) / (last - first)).toFixed(1)},${(height - 4 - ((height - 8) * p.rms_um) / most).toFixed(1)}`;
  const here = points.find(p => p.n === view.shown_layer);
  const [x, y] = here ? place(here).split(",") : [];
  return html`
    <figure class="trend">
      <svg viewBox="0 0 ${width} ${height}" preserveAspectRatio="none" role="img"
        aria-label=${`RMS error of layers ${first} to ${last}, at most ${height_words(most, session.height_unit)}`}>
        <polyline points=${points.map(place).join(" ")} />
        ${here && html`<circle cx=${x} cy=${y} r="3.5" />`}
      </svg>
      <figcaption class="soft">RMS error, layers ${first} to ${last}; highest ${height_words(most, session.height_unit)}</figcaption>
    </figure>`;
}
