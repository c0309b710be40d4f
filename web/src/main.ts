// The page: head, time cursor, panels.

import "uplot/dist/uPlot.min.css";
import "./page.css";

import {html, render} from "htm/preact";
import {use_clock, use_observed} from "./data/observable";
import type {Session} from "./data/session";
import {view} from "./data/view";
import {duration, height_words, label, with_micro, with_unit} from "./data/words";
import {TokenDialog} from "./panels/ask_token";
import {About} from "./panels/about";
import {Alarms, Title} from "./panels/alarms";
import {Commands} from "./panels/commands";
import {Compare} from "./panels/compare";
import {Decision} from "./panels/decision";
import {Instruments} from "./panels/instruments";
import {Now} from "./panels/now";
import {Over} from "./panels/over";
import {Runs} from "./panels/runs";
import {Settings} from "./panels/settings";
import {Surface} from "./panels/surface";
import {Timeline, use_time_keys} from "./panels/timeline";
import {StopBanner, Why} from "./panels/why";
import {follow_address} from "./routes";

function Page() {
  use_observed(view);
  use_time_keys();
  const {page, session} = view;
  return html`
    <header class="top">
      <h1>Firn</h1>
      <nav aria-label="Pages">
        <a href=${`#run=${encodeURIComponent(session?.hello.run.id ?? "live")}`} aria-current=${page === "print" ? "page" : "false"}>Print</a>
        <a href="#runs" aria-current=${page === "runs" ? "page" : "false"}>Runs</a>
        ${view.chosen.length > 1 && html`<a href=${`#compare=${view.chosen.map(encodeURIComponent).join(",")}`}
          aria-current=${page === "compare" ? "page" : "false"}>Beside</a>`}
      </nav>
      ${page === "print" && session && html`<${Status} session=${session} /><${Over} key=${session.hello.run.id} session=${session} />`}
    </header>
    <main>
      ${view.trouble && html`<p class="notice warning" role="alert">${view.trouble}</p>`}
      ${page === "print" && !session && html`<p role="status">${view.opening ? `opening ${view.opening === "live" ? "the live print" : view.opening}…` : "No run is open."}</p>`}
      ${page === "print" && session && html`<${Print} key=${session.hello.run.id} session=${session} />`}
      ${page === "runs" && html`<${Runs} />`}
      ${page === "compare" && html`<${Compare} />`}
    </main>
    <${Title} /><${TokenDialog} />`;
}

function Status({session}: {session: Session}) {
  use_observed(session);
  use_clock(250, session.live);
  const {run} = session.hello;
  const state = session.state;
  const layers = state?.layers ?? run.layers_planned ?? run.layers_expected;
  const kind = session.live ? (session.stale && !session.connecting ? "old" : "live") : "past";
  return html`
    <div class=${`status ${kind}`}>
      <span class="tag">${kind === "live" ? "● live" : kind === "old" ? "○ old" : "recorded"}</span>
      <strong>${session.live ? state?.words ?? "waiting for the print" : session.ending?.words ?? state?.words ?? run.outcome ?? "recorded run"}</strong>
      ${session.hello.you?.name && html`<span class="soft">${session.hello.you.name}${session.hello.you.commands ? "" : ", observer"}</span>`}
      ${session.live && state && html`<span>layer ${state.layer}${layers ? ` of about ${layers}` : ""}${state.eta_s != null ? `, ${duration(state.eta_s)} left` : ""}</span>`}
      ${session.ending?.verdict && html`<span class=${session.ending.within === false ? "bad" : "good"}>${with_micro(session.ending.verdict)}</span>`}
      ${!session.live && !session.ending?.verdict && html`<span>${last_error_words(session)}</span>`}
      <span class="soft">${label(run)} · ${run.lab_words}, ${run.scheme}${run.simulated ? ", simulated" : ""}${goal_words(session)}</span>
    </div>`;
}

/** Of a run that has no verdict, since some of its layers are not printed. */
function last_error_words(session: Session): string {
  const last = session.layer(session.last_layer);
  return last?.rms_um == null ? "" : `RMS ${height_words(last.rms_um, session.height_unit)} after layer ${last.n}`;
}

function goal_words(session: Session): string {
  const goal = session.hello.run.goal;
  return goal && goal.value != null ? ` · goal: RMS of at most ${with_unit(goal.value, goal.unit)}` : "";
}

function Print({session}: {session: Session}) {
  use_observed(session);
  return html`
    <${StopBanner} session=${session} />
    <${Commands} session=${session} />
    <${Timeline} session=${session} />
    ${[session.refused, session.trouble, session.hello.run.trouble].filter(Boolean).map(words => html`<p key=${words} class="notice warning" role="alert">${words}</p>`)}
    <div class="grid">
      <${Surface} session=${session} />
      <div class="side"><${Result} session=${session} /><${Now} session=${session} /><${Alarms} session=${session} /><${Why} session=${session} /></div>
    </div>
    <${Decision} session=${session} />
    <${Instruments} session=${session} />
    <${About} session=${session} />
    <${Settings} session=${session} />`;
}

/** The result as the terminal and the report give it. */
function Result({session}: {session: Session}) {
  const facts = session.ending?.facts ?? [];
  return facts.length === 0 ? null : html`
    <section class="panel" aria-labelledby="result-title">
      <h2 id="result-title">Result</h2>
      ${facts.map(fact => html`<p key=${fact}>${with_micro(fact)}</p>`)}
    </section>`;
}

addEventListener("hashchange", () => void follow_address());
render(html`<${Page} />`, document.getElementById("page")!);
void follow_address();
