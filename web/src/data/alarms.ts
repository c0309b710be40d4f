// Alarms of a run that nobody has acknowledged, and the title that tells of them.

import type {Acknowledged, PrintEvent} from "./protocol";

/** As much of a session as the title needs. */
export interface Alarmed {
  live: boolean;
  stale: boolean;
  events: PrintEvent[];
  acknowledged: Map<string, Acknowledged>;
  ending: {words: string} | null;
  state: {words: string; layer: number; layers: number | null; paused?: boolean} | null;
  hello: {run: {label?: string; experiment: string; outcome?: string | null}};
}

/** Oldest first. */
export function open_alarms(session: Pick<Alarmed, "events" | "acknowledged">): PrintEvent[] {
  return session.events.filter(event => event.alarm && !session.acknowledged.has(event.alarm));
}

/** "(2!) paused, layer 12 of 40 · cylinder": alarms that nobody has acknowledged, what goes on, the run. */
export function title_words(session: Alarmed | null): string {
  if (!session) return "Firn";
  const {state, hello: {run}} = session;
  const open = open_alarms(session).length;
  const layers = state?.layers ? ` of ${state.layers}` : "";
  const doing = !session.live ? session.ending?.words ?? run.outcome ?? "recorded"
    : session.stale ? "no word from the print"
    : state ? `${state.paused ? "paused" : "printing"}, layer ${state.layer}${layers}` : "printing";
  return `${open ? `(${open}!) ` : ""}${doing} · ${run.label ?? run.experiment}`;
}
