// Commands to a running print: pause, continue, stops, doubts, settings that may change in flight.

import {html} from "htm/preact";
import {useEffect, useState} from "preact/hooks";
import {use_clock, use_observed} from "../data/observable";
import type {Answer, InFlight} from "../data/protocol";
import type {Session} from "../data/session";
import {value_words} from "../data/settings";
import {duration, unit_words, with_unit} from "../data/words";
import {have_token} from "./ask_token";
import {HoldButton} from "./hold_button";

interface Said {
  good: boolean;
  words: string;
}

const kNames: Record<string, string> = {
  pause: "Pause", continue: "Continue", stop_after_layer: "Stop after this layer", safe_stop: "Safe stop",
  accept_doubt: "The answer", set: "The setting",
};

export function Commands({session}: {session: Session}) {
  use_observed(session);
  use_clock(250, session.live);
  const [said, set_said] = useState<Said | null>(null);
  const [busy, set_busy] = useState<string | null>(null);

  const give = async (command: string, more: Record<string, unknown> = {}) => {
    if (await have_token(kNames[command] ?? command)) await hear(command, session.command(command, more));
  };
  const hear = async (command: string, coming: Promise<Answer>) => {
    set_busy(command);
    set_said({good: true, words: `${kNames[command]}: sent…`});
    const answer = await coming;
    set_busy(null);
    const failure = command === "safe_stop" ? " If the machine still moves, press its own emergency stop." : "";
    set_said(answer.ok ? {good: true, words: `${kNames[command]}: ${answer.words?.replace(/^[a-z_ -]+: /, "") || "obeyed"}`}
                       : {good: false, words: `${kNames[command]}: ${answer.error ?? "refused"}.${failure}`});
  };
  const stop = () => void give("safe_stop");

  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      if (!event.ctrlKey || !event.shiftKey || event.code !== "Space" || event.repeat) return;
      event.preventDefault();
      if (session.live) stop();
    };
    addEventListener("keydown", key, true);
    return () => removeEventListener("keydown", key, true);
  }, [session]);

  if (!session.live) return null;
  const state = session.state;
  const locked = session.stale || busy !== null;
  const can = (command: string) => session.hello.commands.allowed.includes(command) && !locked;
  const paused = !!state?.paused;
  const ending = !!state?.stopping;
  return html`
    <section class="commands" aria-label="Commands">
      <div class="row">
        <button type="button" disabled=${!can("pause") || paused || ending} title="waits where nothing is armed or wet" onClick=${() => give("pause")}>Pause</button>
        <button type="button" disabled=${!can("continue") || !paused} onClick=${() => give("continue")}>Continue</button>
        <button type="button" disabled=${!can("stop_after_layer") || ending} onClick=${() => give("stop_after_layer")}>
          Stop after this layer</button>
        <${HoldButton} words="Safe stop: hold" session=${session} disabled=${!session.connected}
          ended=${(answer: Promise<Answer> | null) => { if (answer) void hear("safe_stop", answer); else stop(); }} />
        <span id="hold-hint" class="soft">hold 0.5 s, or Ctrl-Shift-Space</span>
      </div>
      <p role="status" aria-live="polite" class=${said && !said.good ? "bad" : ""}>${said?.words ?? ""}</p>
      ${session.stale && !session.connecting && html`<p class="locked">${lock_words(session)}</p>`}
      ${state?.doubt && html`
        <div class="notice warning" role="alert">
          <strong>${state.doubt.words}</strong>
          <p>${state.doubt.question}</p>
          <div class="row">${(state.doubt.choices ?? []).map(choice => html`
            <button key=${choice} type="button" disabled=${!can("accept_doubt")} onClick=${() => give("accept_doubt", {choice})}>
              ${choice.replace(/_/g, " ")}</button>`)}</div>
        </div>`}
      ${session.hello.commands.in_flight.length > 0 && html`
        <details class="in-flight">
          <summary>Settings that may change now</summary>
          ${session.hello.commands.in_flight.map(one => html`
            <${Change} key=${one.key} setting=${one} locked=${!can("set")}
              give=${(value: string) => give("set", {key: one.key, value})} />`)}
        </details>`}
    </section>`;
}

function lock_words(session: Session): string {
  if (!session.connected)
    return "No connection to the print: what you see is old and nothing can be sent. It prints on; to stop it use the terminal or the machine's own emergency stop.";
  return `Nothing has come from the print for ${duration(session.link_age_s)}: commands are locked, the safe stop is not.`;
}

function Change({setting, locked, give}: {setting: InFlight; locked: boolean; give: (value: string) => void}) {
  const [text, set_text] = useState(value_words(setting.value));
  const numeric = setting.min != null || setting.max != null;
  const value = Number(text);
  const wrong = numeric && (text.trim() === "" || !Number.isFinite(value) ||
                            (setting.min != null && value < setting.min) || (setting.max != null && value > setting.max));
  const limits = numeric && (setting.min != null || setting.max != null)
    ? `from ${with_unit(setting.min, "")} to ${with_unit(setting.max, setting.unit)}` : "";
  const id = `set-${setting.key}`;
  const input = (e: Event) => set_text((e.target as HTMLInputElement).value);
  const submit = (event: Event) => {
    event.preventDefault();
    if (!wrong && !locked) give(text.trim());
  };
  return html`
    <form class="change" onSubmit=${submit}>
      <label for=${id}>${setting.words || setting.key} <code>${setting.key}</code></label>
      <span class="row">
        ${setting.choices?.length
          ? html`<select id=${id} value=${text} onChange=${input}>
              ${setting.choices.map(choice => html`<option key=${choice} value=${choice}>${choice}</option>`)}</select>`
          : html`<input id=${id} inputmode=${numeric ? "decimal" : "text"} value=${text} onInput=${input} aria-invalid=${wrong ? "true" : "false"} />`}
        <span class="soft">${unit_words(setting.unit || "")} ${limits}</span>
        <button type="submit" disabled=${locked || wrong}>Set</button>
      </span>
    </form>`;
}
