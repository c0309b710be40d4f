// The one time cursor: any layer back to the bare substrate, or live.

import {html} from "htm/preact";
import {useEffect} from "preact/hooks";
import {use_observed} from "../data/observable";
import type {Session} from "../data/session";
import {view} from "../data/view";
import {clock} from "../data/words";

const kOwnKeys = "input:not([type=range]):not([type=checkbox]), select, textarea, dialog, [role=slider]";

/** Left and right move the cursor wherever the focus is, but for fields that use these keys themselves. */
export function use_time_keys(): void {
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      if (event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
      if ((event.target as Element).closest?.(kOwnKeys)) return;
      if (event.key === "ArrowLeft") view.step(-1);
      else if (event.key === "ArrowRight") view.step(1);
      else return;
      event.preventDefault();
    };
    addEventListener("keydown", key);
    return () => removeEventListener("keydown", key);
  }, []);
}

export function Timeline({session}: {session: Session | null}) {
  use_observed(view, session);
  const stops = view.stops;
  const last = view.last_layer;
  const shown = view.shown_layer;
  const live = view.layer == null && !!session?.live;
  const at = session?.layer(shown);
  const words = shown === 0 ? "bare substrate" : `layer ${shown} of ${last}`;
  return html`
    <section class="timeline" aria-label="Time">
      <button type="button" aria-label="One layer back" disabled=${shown <= 0} onClick=${() => view.step(-1)}>◀</button>
      <input type="range" min="0" max=${stops.length - 1} step="1" value=${stops.indexOf(shown)} aria-label="Layer" aria-valuetext=${words}
        onInput=${(e: Event) => view.move_to(stops[Number((e.target as HTMLInputElement).value)])} />
      <button type="button" aria-label="One layer on" disabled=${live || (shown >= last && !session?.live)} onClick=${() => view.step(1)}>▶</button>
      <output>${words}${at ? html`<span class="soft"> at ${clock(at.t_s)}</span>` : ""}</output>
      ${session?.live && html`<button type="button" class=${live ? "on" : ""} aria-pressed=${live ? "true" : "false"}
        onClick=${() => view.move_to(null)}>● Live</button>`}
    </section>`;
}
