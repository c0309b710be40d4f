// Paints a canvas again when its size or the theme changes.

import {useEffect, useRef, type MutableRef} from "preact/hooks";

export function use_repaint(canvas: MutableRef<HTMLCanvasElement | null> | {current: HTMLCanvasElement | null}, paint: () => void): void {
  const latest = useRef(paint);
  latest.current = paint;
  useEffect(() => {
    const again = () => latest.current();
    const sized = new ResizeObserver(again);
    sized.observe(canvas.current!);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", again);
    return () => {
      sized.disconnect();
      dark.removeEventListener("change", again);
    };
  }, []);
}
