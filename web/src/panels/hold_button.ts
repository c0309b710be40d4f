// The safe stop: pressed by a hold of 0.5 s with pointer or keyboard, or at once by Ctrl-Shift-Space.

import {html} from "htm/preact";
import {useEffect, useRef, useState} from "preact/hooks";

export const kHold_ms = 500;

/** `fire` is called in the same turn in which the hold ends: 0.5 s after the press, also where a busy tab heard of it late. */
export function HoldButton({fire, disabled, words}: {fire: () => void; disabled: boolean; words: string}) {
  const [holding, set_holding] = useState(false);
  const timer = useRef(0);
  const release = () => {
    clearTimeout(timer.current);
    timer.current = 0;
    set_holding(false);
  };
  const press = (event: Event) => {
    if (disabled || timer.current) return;
    const heard_after_ms = Math.min(kHold_ms, Math.max(0, performance.now() - event.timeStamp));
    timer.current = window.setTimeout(() => {
      fire();
      release();
    }, kHold_ms - heard_after_ms);
    set_holding(true);
  };
  useEffect(() => {
    if (disabled) release();
  }, [disabled]);
  useEffect(() => release, []);
  const is_key = (event: KeyboardEvent) => event.key === " " || event.key === "Enter";
  return html`
    <button type="button" class=${"safe-stop" + (holding ? " holding" : "")} disabled=${disabled} aria-describedby="hold-hint"
      onPointerDown=${(e: PointerEvent) => { if (e.button === 0) press(e); }}
      onPointerUp=${release} onPointerLeave=${release} onPointerCancel=${release} onBlur=${release}
      onContextMenu=${(e: Event) => e.preventDefault()}
      onKeyDown=${(e: KeyboardEvent) => { if (is_key(e) && !e.ctrlKey) { e.preventDefault(); if (!e.repeat) press(e); } }}
      onKeyUp=${(e: KeyboardEvent) => { if (is_key(e)) release(); }}>
      <span>${holding ? "Keep holding…" : words}</span>
    </button>`;
}
