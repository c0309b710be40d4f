// The decision: the next layer's droplets over the error they answer, and whether the model is right.

import {html} from "htm/preact";
import {useEffect, useMemo, useRef} from "preact/hooks";
import {fitted_scale, type Scale, type SurfaceMap} from "../data/maps";
import {use_observed} from "../data/observable";
import {kMapDroplets, type Estimate, type Layer} from "../data/protocol";
import type {Session} from "../data/session";
import {view} from "../data/view";
import {height_words, in_height_unit, number, unit_words, with_unit} from "../data/words";
import {gradient} from "../draw/colours";
import {cell_at, MapPainter, type Placement} from "../draw/map_painter";
import {DropletPainter} from "../draw/droplets";
import {Plot} from "../draw/plot";
import {unit_of} from "./shown_map";
import {use_repaint} from "./use_repaint";

const kLast = 10;

export function Decision({session}: {session: Session}) {
  use_observed(session, session.maps, view);
  return html`
    <section class="panel decision" aria-labelledby="decision-title">
      <h2 id="decision-title">Decision</h2>
      <div class="cards wide">
        <${Answer} session=${session} />
        <${Model} session=${session} />
        <${Estimates} session=${session} />
      </div>
    </section>`;
}

/** The plan that was made from the map of the cursor's layer. */
function Answer({session}: {session: Session}) {
  const layer = view.shown_layer;
  const error = session.maps.get("error", layer);
  const plan = session.hello.run.deposition === "lines" ? null : session.maps.get("planned", layer);
  const counted = plan ? (plan.flags & kMapDroplets) !== 0 : session.hello.run.deposition === "droplets";
  const scale = useRef<Scale | null>(null);
  if (error) scale.current ??= fitted_scale(error, true);
  const total = plan && counted ? plan.values.reduce((sum, value) => sum + (value > 0 ? value : 0), 0) : null;
  return html`
    <div class="card">
      <h3>Answer to the error of layer ${layer}</h3>
      ${error
        ? html`<${PlanCanvas} error=${error} plan=${counted ? plan : null} grid=${session.grid} scale=${scale.current!} />
            <div class="scale row"><span>−${number(scale.current!.high)}</span>
              <span class="bar" style=${{backgroundImage: gradient(true, "to right")}}></span><span>${with_unit(scale.current!.high, unit_of(error))}</span></div>`
        : html`<p class="soft">${session.maps.missing("error", layer) ?? "loading…"}</p>`}
      <p>${plan_words(session, plan, counted, total, layer)}</p>
    </div>`;
}

function plan_words(session: Session, plan: SurfaceMap | null, counted: boolean, total: number | null, layer: number): string {
  if (!plan && !session.live && layer === session.last_layer) return "No layer follows this one.";
  if (session.hello.run.deposition === "lines") return "Each line's speed answers its cross-section; flow and shutter are learned on the way.";
  if (!plan) return session.maps.missing("planned", layer) ?? "The plan is loading…";
  if (counted) return `${number(total, 6)} droplets for layer ${layer + 1}: a dot each, larger for several${beside_words(plan)}.`;
  const seen = plan.values.filter(Number.isFinite);
  const mean = seen.length ? seen.reduce((sum, value) => sum + value, 0) / seen.length : NaN;
  return `Relative flow u of the next interval, mean ${number(mean)}; "next layer's plan" under Surface shows where.`;
}

/** How many droplets land beside the middle of their cells, where the lab has other places. */
function beside_words(plan: SurfaceMap): string {
  const places = plan.places;
  if (!places) return "";
  const beside = plan.values.reduce((sum, count, cell) => sum + (count > 0 && (places.x[cell] !== 0 || places.y[cell] !== 0) ? count : 0), 0);
  return `, where they land; ${number(beside, 6)} of them beside the middle of their cells`;
}

function PlanCanvas({error, plan, grid, scale}:
                    {error: SurfaceMap; plan: SurfaceMap | null; grid: Session["grid"]; scale: Scale}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const painter = useRef<MapPainter | null>(null);
  const droplets = useRef<DropletPainter | null>(null);
  const place = useRef<Placement | null>(null);
  const paint = () => {
    painter.current ??= new MapPainter(canvas.current!);
    droplets.current ??= new DropletPainter();
    place.current = painter.current.paint(error, grid, scale, {cell: view.cell, cut: null});
    if (plan && plan.nx === error.nx && plan.ny === error.ny) droplets.current.paint(canvas.current!, place.current, plan);
  };
  use_repaint(canvas, paint);
  useEffect(paint);
  const move = (event: PointerEvent) => {
    const box = canvas.current!.getBoundingClientRect();
    view.cell = place.current && cell_at(place.current, event.clientX - box.left, event.clientY - box.top);
    view.changed();
  };
  return html`<canvas ref=${canvas} class="plan" role="img" aria-label="Droplets of the next layer over the error that they answer"
    onPointerMove=${move} onPointerLeave=${() => { view.cell = null; view.changed(); }}></canvas>`;
}

function Model({session}: {session: Session}) {
  const layers = session.layers;
  const data = useMemo(() => [layers.map(l => l.n), layers.map(l => in_height_unit(measured_of(l), session.height_unit)), layers.map(l => in_height_unit(l.predicted_rms_um, session.height_unit))],
                       [layers.length, layers[layers.length - 1]]);
  const both = layers.filter(l => l.n <= view.shown_layer && l.predicted_rms_um != null && measured_of(l) != null).slice(-kLast);
  const predicted = layers.some(l => l.predicted_rms_um != null);
  return html`
    <div class="card">
      <h3>Is the model right?</h3>
      ${predicted
        ? html`<p>${model_words(both, session.height_unit)}</p>`
        : html`<p class="soft">This scheme predicts no error: the curve is the measured one.</p>`}
      ${layers.length > 1 && html`<${Plot} words="Measured and predicted RMS error of each layer" x_label="layer" y_label=${`RMS error, ${unit_words(session.height_unit)}`}
        curves=${predicted ? [{label: "measured", colour: "one"}, {label: "predicted", colour: "two", dash: [6, 4]}] : [{label: "measured", colour: "one"}]}
        data=${predicted ? data : data.slice(0, 2)} mark=${view.shown_layer} pick=${(n: number) => view.move_to(n)} />`}
    </div>`;
}

function measured_of(layer: Layer): number | null {
  return layer.measured_rms_um ?? layer.rms_um;
}

function model_words(both: Layer[], unit: string): string {
  if (both.length === 0) return "Nothing to compare yet.";
  const mean = (of: (layer: Layer) => number) => both.reduce((sum, layer) => sum + of(layer), 0) / both.length;
  const bias = mean(l => measured_of(l)! - l.predicted_rms_um!);
  const share = mean(l => Math.abs(measured_of(l)! - l.predicted_rms_um!)) / Math.max(mean(l => measured_of(l)!), 1e-12);
  const side = Math.abs(bias) < 1e-9 ? "as predicted" : `${height_words(Math.abs(bias), unit)} ${bias > 0 ? "above" : "below"} the prediction`;
  return `In the last ${both.length} layers the measured error was ${side} in the mean; prediction and measurement differ by ${number(100 * share, 2)} %.`;
}

function Estimates({session}: {session: Session}) {
  const names = [...new Set(session.estimates.map(one => one.name))].sort();
  if (names.length === 0) return null;
  const until_s = view.layer == null ? Infinity : session.layer(view.shown_layer)?.t_s ?? Infinity;
  return html`
    <div class="card">
      <h3>What is learned on the way</h3>
      <table>
        <thead><tr><th scope="col">Name</th><th scope="col">Estimate</th><th scope="col">95 % interval</th></tr></thead>
        <tbody>${names.map(name => {
          const one = latest(session.estimates, name, until_s);
          return one && html`<tr key=${name}><td>${name.replace(/_/g, " ")}</td><td>${with_unit(one.value, one.unit)}</td>
            <td>${one.sd == null ? "–" : `${number(one.value - 1.96 * one.sd)} to ${number(one.value + 1.96 * one.sd)}`}</td></tr>`;
        })}</tbody>
      </table>
      ${names.map(name => html`<${EstimatePlot} key=${name} name=${name} all=${session.estimates} count=${session.estimates.length} />`)}
    </div>`;
}

function latest(all: Estimate[], name: string, until_s: number): Estimate | null {
  for (let i = all.length - 1; i >= 0; --i) if (all[i].name === name && all[i].t_s <= until_s) return all[i];
  return null;
}

function EstimatePlot({name, all, count}: {name: string; all: Estimate[]; count: number}) {
  const data = useMemo(() => {
    const mine = all.filter(one => one.name === name);
    const band = (sign: number) => mine.map(one => (one.sd == null ? null : one.value + sign * 1.96 * one.sd));
    return [mine.map(one => one.t_s), band(1), band(-1), mine.map(one => one.value)];
  }, [name, count]);
  if (data[0].length < 2) return null;
  const unit = unit_words(all.find(one => one.name === name)?.unit ?? "");
  return html`<${Plot} words=${`Estimate of ${name} with its 95 % interval over time`} x_label="s" y_label=${`${name.replace(/_/g, " ")}${unit && unit !== "1" ? `, ${unit}` : ""}`}
    curves=${[{label: "97.5 %", colour: "two", edge: true}, {label: "2.5 %", colour: "two", band: true, edge: true}, {label: name.replace(/_/g, " "), colour: "one"}]}
    data=${data} height=${120} />`;
}
