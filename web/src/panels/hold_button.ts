// The safe stop: pressed by a hold of 0.5 s with pointer or keyboard, or at once by Ctrl-Shift-Space.

import {html} from "htm/preact";
import {useEffect, useState} from "preact/hooks";
import type {Answer} from "../data/protocol";
import type {Session} from "../data/session";

/** `ended` hears that the button was held long enough: with the answer of the stop that was sent, or null where none could be. */
export function HoldButton({session, ended, disabled, words}: {session: Session; ended: (answer: Promise<Answer> | null) => void; disabled: boolean; words: string}) {
  const [holding, set_holding] = useState(false);
  const release = (at_ms: number) => {
    session.release_stop(at_ms);
    set_holding(false);
  };
  const press = (event: Event) => {
    if (disabled || holding) return;
    session.hold_stop(event.timeStamp, answer => {
      set_holding(false);
      ended(answer);
    });
    set_holding(true);
  };
  useEffect(() => {
    if (disabled) release(performance.now());
  }, [disabled]);
  useEffect(() => () => release(performance.now()), []);
  const let_go = (event: Event) => release(event.timeStamp);
  const is_key = (event: KeyboardEvent) => event.key === " " || event.key === "Enter";
  return html`
    <button type="button" class=${"safe-stop" + (holding ? " holding" : "")} disabled=${disabled} aria-describedby="hold-hint"
      onPointerDown=${(e: PointerEvent) => { if (e.button === 0) press(e); }}
      onPointerUp=${let_go} onPointerLeave=${let_go} onPointerCancel=${let_go} onBlur=${let_go}
      onContextMenu=${(e: Event) => e.preventDefault()}
      onKeyDown=${(e: KeyboardEvent) => { if (is_key(e) && !e.ctrlKey) { e.preventDefault(); if (!e.repeat) press(e); } }}
      onKeyUp=${(e: KeyboardEvent) => { if (is_key(e)) let_go(e); }}>
      <span>${holding ? "Keep holding…" : words}</span>
    </button>`;
}
