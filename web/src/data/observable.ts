// State that components watch: a change is shown with the next frame, however many messages made it.

import {useEffect, useState} from "preact/hooks";

let hushed = false;
const unshown = new Set<Observable>();

/** While this is on, no change is shown: the thread is free for the end of a hold. */
export function hush(on: boolean): void {
  hushed = on;
  if (on) return;
  for (const one of unshown) one.show();
  unshown.clear();
}

export class Observable {
  private readonly watchers = new Set<() => void>();
  private telling = false;
  changes = 0;

  watch(watcher: () => void): () => void {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }

  changed(): void {
    ++this.changes;
    if (hushed) unshown.add(this);
    else this.show();
  }

  show(): void {
    if (this.telling) return;
    this.telling = true;
    const tell = () => {
      this.telling = false;
      for (const watcher of [...this.watchers]) watcher();
    };
    // A hidden tab gets no frames; its state must not fall behind without end.
    if (document.hidden) setTimeout(tell, 250);
    else requestAnimationFrame(tell);
  }
}

/** Renders the calling component again whenever one of `sources` changes. */
export function use_observed(...sources: (Observable | null)[]): void {
  const [, again] = useState(0);
  const rendered = sources.map(source => source?.changes);
  useEffect(() => {
    const ends = sources.map(source => source?.watch(() => again(n => n + 1)));
    // What changed between the rendering and this effect would never be shown.
    if (sources.some((source, i) => source?.changes !== rendered[i])) again(n => n + 1);
    return () => ends.forEach(end => end?.());
  }, sources);
}

/** Renders the calling component every `period_ms` while `running`. */
export function use_clock(period_ms: number, running: boolean): void {
  const [, again] = useState(0);
  useEffect(() => {
    if (!running) return;
    const timer = setInterval(() => { if (!hushed) again(n => n + 1); }, period_ms);
    return () => clearInterval(timer);
  }, [period_ms, running]);
}
