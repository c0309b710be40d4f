// Events in plain words: states, faults, doubts and how they were resolved, the operator's commands; a stop comes first.

import {html} from "htm/preact";
import {useState} from "preact/hooks";
import {use_observed} from "../data/observable";
import type {Ending, PrintEvent, Weight} from "../data/protocol";
import type {Session} from "../data/session";
import {view} from "../data/view";
import {clock, safe_link, with_unit} from "../data/words";

const kMarks: Record<Weight, string> = {info: "·", notice: "○", warning: "▲", fault: "◆", stop: "■"};
const kShown = 200;

/** How the run ended if it did not print to its end; null otherwise. */
export function stop_of(session: Session): Ending | null {
  const outcome = session.ending?.outcome ?? session.hello.run.outcome;
  if (session.live || !outcome || /^(finished|out of tolerance)$/.test(outcome)) return null;
  if (session.ending) return session.ending;
  const event = [...session.events].reverse().find(one => one.severity === "stop");
  return {outcome, words: event?.words ?? `The print was ${outcome}.`, cause: event ? cause_of(event) : null, do: event?.do ?? null,
          manual: event?.manual ?? null, by_operator: false};
}

/** "ice.flow: 1.32, limit 1.25" */
function cause_of(event: PrintEvent): string | null {
  const parts = [event.cause, event.value != null ? `value ${with_unit(event.value, event.unit)}` : null,
                 event.limit != null ? `limit ${with_unit(event.limit, event.unit)}` : null].filter(Boolean);
  return parts.length ? parts.join(", ") : null;
}

function ManualLink({link}: {link: string | null}) {
  const href = safe_link(link);
  return href ? html`<a href=${href} target="_blank" rel="noopener">the manual on this</a>` : null;
}

/** A sentence whose options of commands ("--resume") are not broken behind their hyphens. */
function Advice({words}: {words: string}) {
  return html`<p class="detail"><b>What to do:</b> ${words.split(/(--[\w-]+)/).map((part, i) => i % 2 ? html`<span class="one-line">${part}</span>` : part)}</p>`;
}

export function StopBanner({session}: {session: Session}) {
  use_observed(session);
  const stop = stop_of(session);
  if (!stop) return null;
  const told = stop.words.replace(/^[^:]*: /, "");  // "stopped safely: " goes before the cause
  return html`
    <section class=${stop.by_operator ? "notice" : "notice stopped"} role="alert" aria-label="Why it stopped">
      <h2>■ ${stop.words}</h2>
      ${stop.cause && !stop.cause.endsWith(told) && html`<p><b>Cause:</b> ${stop.cause}</p>`}
      ${stop.do && html`<${Advice} words=${stop.do} />`}
      <${ManualLink} link=${stop.manual} />
    </section>`;
}

/** The layer that was being made at a time. */
function layer_at(session: Session, t_s: number): number {
  return session.layers.find(layer => layer.t_s >= t_s)?.n ?? session.last_layer;
}

export function Why({session}: {session: Session}) {
  use_observed(session, view);
  const [all, set_all] = useState(true);
  const [most, set_most] = useState(kShown);
  const until_s = view.layer == null ? Infinity : session.layer(view.shown_layer)?.t_s ?? Infinity;
  const events = session.events.filter(event => all || event.severity !== "info").reverse();
  return html`
    <section class="panel why" aria-labelledby="why-title">
      <div class="row head">
        <h2 id="why-title">Why</h2>
        <label class="check"><input type="checkbox" checked=${!all} onChange=${() => set_all(!all)} /> leave out routine</label>
      </div>
      ${events.length === 0 && html`<p class="soft">Nothing has happened yet.</p>`}
      <ol class="events" tabindex="0" aria-label="Events, newest first">
        ${events.slice(0, most).map(event => html`
          <li key=${event.n} class=${`is-${event.severity}${event.t_s > until_s ? " later" : ""}`}>
            <span class="mark" aria-hidden="true">${kMarks[event.severity] ?? "·"}</span>
            <div>
              <button type="button" class="link time" title="show this layer" onClick=${() => view.move_to(layer_at(session, event.t_s))}>
                ${clock(event.t_s)}</button>
              <span class="severity">${event.severity === "info" ? "" : `${event.severity}: `}</span>
              <span>${event.words}</span> <span class="soft">${event.source}</span>
              ${cause_of(event) && html`<p class="detail">${cause_of(event)}</p>`}
              ${event.do && html`<${Advice} words=${event.do} />`}
              <${ManualLink} link=${event.manual} />
            </div>
          </li>`)}
      </ol>
      ${events.length > most && html`<button type="button" onClick=${() => set_most(most + kShown)}>
        ${events.length - most} older events</button>`}
    </section>`;
}
