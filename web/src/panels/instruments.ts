// The instruments: state, link, last exchange, real or simulated, faults, and what each tells of itself.

import {html} from "htm/preact";
import {use_clock, use_observed} from "../data/observable";
import type {Instrument} from "../data/protocol";
import type {Session} from "../data/session";
import {kWaveformKeys, waveform_of, type Waveform} from "../data/waveform";
import {clock, duration, number, with_unit} from "../data/words";

const kOpen = 4;       // details that are shown at once
const kMostText = 140;

export function Instruments({session}: {session: Session}) {
  use_observed(session);
  use_clock(1000, session.live);
  const all = [...session.instruments.values()];
  return html`
    <section class=${"panel instruments" + (session.stale ? " stale" : "")} aria-labelledby="instruments-title">
      <h2 id="instruments-title">Instruments</h2>
      ${all.length === 0 && html`<p class="soft">No instrument has spoken.</p>`}
      <div class="cards">${all.map(one => html`<${Card} key=${one.name} one=${with_hours(one, session)} now_s=${session.live ? session.state?.t_s ?? null : null} />`)}</div>
    </section>`;
}

/** The lamp's hours beside what this print has added: the sum of the other runs is no message of it. */
function with_hours(one: Instrument, {lamp}: Session): Instrument {
  if (one.name !== "lamp" || !lamp?.lamp || lamp.earlier_runs === 0) return one;
  const [first, ...rest] = one.details ?? [];
  const hours: [string, unknown, string] = [`open in ${lamp.earlier_runs} earlier runs in this folder, same port`, lamp.earlier_h.toFixed(4), "h"];
  return {...one, details: first ? [first, hours, ...rest] : [hours]};
}

function Card({one, now_s}: {one: Instrument; now_s: number | null}) {
  const bad = /fault|estop|suspect|disconnected/.test(one.state);
  const waveform = waveform_of(one.details ?? []);
  const details = (one.details ?? []).filter(([name]) => !waveform || !kWaveformKeys.includes(name));
  const age = one.last && now_s != null ? Math.max(0, now_s - one.last.t_s) : null;
  return html`
    <article class=${"card" + (bad ? " faulty" : "")} aria-label=${one.name}>
      <header class="row">
        <h3>${one.name}</h3>
        <span class="tag">${one.real ? "real" : "simulated"}</span>
        <span class=${"tag state" + (bad ? " bad" : "")}>${bad ? "▲ " : ""}${one.state}</span>
      </header>
      <p>${one.words}</p>
      <dl>
        <div><dt>link</dt><dd>${one.link || "–"}</dd></div>
        <div><dt>faults</dt><dd class=${one.faults ? "bad" : ""}>${number(one.faults)}</dd></div>
        ${details.slice(0, kOpen).map(one => html`<${Detail} key=${one[0]} one=${one} />`)}
      </dl>
      ${details.length > kOpen && html`<details><summary>${details.length - kOpen} more</summary>
        <dl>${details.slice(kOpen).map(one => html`<${Detail} key=${one[0]} one=${one} />`)}</dl></details>`}
      ${waveform && html`<${Pulse} t_us=${waveform.t_us} volts=${waveform.volts} />`}
      ${one.last && html`<p class="exchange"><code title=${one.last.text}>${one.last.text.length > kMostText ? `${one.last.text.slice(0, kMostText)}…` : one.last.text}</code>
        <span class="soft"> ${age == null ? `at ${clock(one.last.t_s)}` : `${duration(age)} ago`}</span></p>`}
    </article>`;
}

function Detail({one}: {one: [string, unknown, string]}) {
  const [label, value, unit] = one;
  const text = typeof value === "string" ? value.replace(/^"(.*)"$/, "$1") : value;
  return html`<div><dt>${label.replace(/_(mm|um|us|s|v|hz|degC|mm_s|mm_s2)$/, "").replace(/_/g, " ")}</dt><dd>${with_unit(text, unit)}</dd></div>`;
}

/** Drive voltage of the jet over time. */
function Pulse({t_us, volts}: Waveform) {
  const width = 220;
  const height = 60;
  const last = t_us[t_us.length - 1] || 1;
  const low = Math.min(0, ...volts);
  const high = Math.max(0, ...volts);
  const y = (v: number) => (height - 5 - ((v - low) / (high - low || 1)) * (height - 10)).toFixed(1);
  const points = t_us.map((t, i) => `${(2 + (t / last) * (width - 4)).toFixed(1)},${y(volts[i])}`).join(" ");
  return html`
    <figure class="trend">
      <svg viewBox="0 0 ${width} ${height}" preserveAspectRatio="none" role="img"
        aria-label=${`Waveform of the jet: ${number(low)} to ${number(high)} V in ${number(last)} µs`}>
        <line x1="0" x2=${width} y1=${y(0)} y2=${y(0)} />
        <polyline points=${points} />
      </svg>
      <figcaption class="soft">waveform: ${number(low)} to ${number(high)} V in ${number(last)} µs</figcaption>
    </figure>`;
}
