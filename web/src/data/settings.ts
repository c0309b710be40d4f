// Settings of runs: the ones that differ, never the equal ones.

import type {Setting} from "./protocol";

export interface Row {
  key: string;
  unit: string;
  values: (unknown | undefined)[];  // one for each run; undefined: the run has no such key
}

const same = (a: unknown, b: unknown) => JSON.stringify(a) === JSON.stringify(b);

/** Keys whose values are not the same in all runs, in order of key. */
export function differing(runs: Setting[][]): Row[] {
  const keys = [...new Set(runs.flatMap(run => run.map(one => one.key)))].sort();
  const tables = runs.map(run => new Map(run.map(one => [one.key, one])));
  return keys
    .map(key => ({key, unit: tables.map(t => t.get(key)?.unit).find(Boolean) ?? "", values: tables.map(t => t.get(key)?.value)}))
    .filter(row => row.values.some(value => !same(value, row.values[0])));
}

/** Settings that are not their default; all where the process names no defaults. */
export function changed(settings: Setting[]): Setting[] {
  return settings.filter(one => one.default === undefined || !same(one.value, one.default));
}

export function value_words(value: unknown): string {
  if (value === undefined) return "not set";
  if (typeof value === "string") return value.replace(/^"(.*)"$/, "$1");
  return JSON.stringify(value).replace(/,/g, ", ");
}
