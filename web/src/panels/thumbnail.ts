// A run's last error map as a small picture in the list, which the process draws once the row comes into view.

import {html} from "htm/preact";
import {useEffect, useRef, useState} from "preact/hooks";
import type {RunSummary} from "../data/protocol";
import {label} from "../data/words";

export const kThumbnailWords = "Pictures: error of the last surface, blue too low, orange too high; full colour is the run's tolerance";

export function Thumbnail({run}: {run: RunSummary}) {
  const box = useRef<HTMLSpanElement>(null);
  const [in_view, set_in_view] = useState(false);
  const [none, set_none] = useState(false);
  useEffect(() => {
    const seen = new IntersectionObserver(entries => {
      if (!entries.some(one => one.isIntersecting)) return;
      seen.disconnect();
      set_in_view(true);
    }, {rootMargin: "100px"});
    seen.observe(box.current!);
    return () => seen.disconnect();
  }, []);
  const change = `${run.outcome} ${run.layers}`;
  useEffect(() => set_none(false), [change]);
  const source = `api/runs/${encodeURIComponent(run.id)}/thumbnail?${encodeURIComponent(change)}`;
  return html`<span class="thumbnail" ref=${box}>
    ${in_view && !none && !run.live && html`<img src=${source} alt=${`Error map of ${label(run)}`} onError=${() => set_none(true)} />`}</span>`;
}
