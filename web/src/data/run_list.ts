// Search and order of the list of runs.

import type {RunSummary} from "./protocol";
import {label} from "./words";

export type SortKey = "started_utc" | "label" | "lab" | "scheme" | "layers" | "outcome" | "rms_um" | "overspill_percent";

/** Runs in which every word of `words` occurs: in a name, [meta], a tag, a note, or as key:value ("scheme:mpc", "ink:tpgda"). */
export function found(runs: RunSummary[], words: string): RunSummary[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  return runs.filter(run => wanted.every(word => {
    const [key, value] = word.split(":", 2);
    if (value !== undefined && run.meta && key in run.meta) return String(run.meta[key]).toLowerCase().includes(value);
    if (value !== undefined && key in run) return String(run[key as keyof RunSummary]).toLowerCase().includes(value);
    if (value !== undefined && key === "tag") return run.tags.some(tag => tag.toLowerCase().includes(value));
    return [label(run), run.id, run.lab, run.experiment, run.scheme, run.outcome ?? "", run.part ?? "", ...Object.values(run.meta ?? {}).map(String),
      ...run.notes.map(note => note.text), ...run.tags].some(text => text.toLowerCase().includes(word));
  }));
}

/** True for a condition as firn runs find takes it, which the process answers: "rms_um < 2 and meta.ink ~ tpgda". */
export function is_condition(words: string): boolean {
  return /[<>=~]|^\s*(not\s+)?has\s/.test(words);
}

/** In order of a column; runs without a value come last either way. */
export function sorted(runs: RunSummary[], key: SortKey, down: boolean): RunSummary[] {
  return [...runs].sort((a, b) => {
    const [x, y] = key === "label" ? [label(a), label(b)] : [a[key], b[key]];
    if (x == null || y == null) return Number(x == null) - Number(y == null);
    const order = typeof x === "number" && typeof y === "number" ? x - y : String(x).localeCompare(String(y));
    return down ? -order : order;
  });
}
