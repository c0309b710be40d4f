// The list of runs: search, order, what was printed, tags and notes, and the choice of runs to put beside each other.

import {html} from "htm/preact";
import {useEffect, useRef, useState} from "preact/hooks";
import {use_observed} from "../data/observable";
import type {RunSummary} from "../data/protocol";
import {found, is_condition, sorted, type SortKey} from "../data/run_list";
import {view} from "../data/view";
import {date, height_words, label, number, with_micro} from "../data/words";
import {go} from "../routes";
import {meta_words, NoteForm, TagsAndNotes} from "./notes";
import {kThumbnailWords, Thumbnail} from "./thumbnail";

const kColumns: [SortKey, string][] = [["label", "Run"], ["started_utc", "Started (UTC)"], ["lab", "Lab"], ["scheme", "Scheme"],
  ["layers", "Layers"], ["outcome", "End and verdict"], ["rms_um", "RMS"], ["overspill_percent", "Overspill, %"]];
const kOfMap = "RMS and overspill are those of the last measured surface";
const kRowsAtOnce = 60;
const kAsk_ms = 250;  // after the last letter of a condition

export function Runs() {
  use_observed(view);
  const [words, set_words] = useState("");
  const [key, set_key] = useState<SortKey>("started_utc");
  const [down, set_down] = useState(true);
  const [edited, set_edited] = useState<string | null>(null);
  const [rows, set_rows] = useState(kRowsAtOnce);
  useEffect(() => void view.load_runs(), []);
  useEffect(() => set_rows(kRowsAtOnce), [words, key, down]);
  const asked = is_condition(words) ? words : "";
  const [answer, set_answer] = useState<{asked: string; ids: Set<string>; trouble: string | null} | null>(null);
  useEffect(() => {
    if (!asked) return;
    const timer = setTimeout(() => void view.runs_of(asked).then(
      all => set_answer({asked, ids: new Set(all.map(run => run.id)), trouble: null}),
      error => set_answer({asked, ids: new Set(), trouble: (error as Error).message})), kAsk_ms);
    return () => clearTimeout(timer);
  }, [asked]);
  const all = view.runs ?? [];
  const met = asked ? all.filter(run => answer?.ids.has(run.id)) : found(all, words);
  const runs = sorted(met, key, down);
  const sort = (column: SortKey) => {
    if (column === key) set_down(!down);
    else set_key(column);
  };
  return html`
    <section class="panel runs" aria-labelledby="runs-title">
      <div class="row head">
        <h2 id="runs-title">Runs</h2>
        <label>Search <input type="search" value=${words} placeholder="words, or rms_um < 2" title="words such as mpc tag:good ink:tpgda, or a condition such as rms_um < 2 and meta.ink ~ tpgda" onInput=${(e: Event) => set_words((e.target as HTMLInputElement).value)} /></label>
        <span class="soft" role="status">${view.runs ? `${runs.length} of ${view.runs.length}` : "loading…"}</span>
        <button type="button" class="main" disabled=${view.chosen.length < 2} onClick=${() => go({page: "compare", compare: view.chosen})}>
          Put ${view.chosen.length || ""} beside each other</button>
        ${view.chosen.length > 0 && html`<${ReportLink} runs=${view.chosen} />`}
      </div>
      ${asked && answer?.asked === asked && answer.trouble && html`<p class="bad" role="alert">${answer.trouble}</p>`}
      ${view.runs?.length === 0 && html`<p>No print yet: <code>firn print EXPERIMENT</code> begins one, and it is shown here.</p>`}
      <p class="soft">${kThumbnailWords}. ${kOfMap}.</p>
      <div class="scroll" tabindex="0" role="region" aria-label="Table of runs"><table class="stack">
        <thead><tr><th scope="col"><span class="hidden">Choose</span></th>
          ${kColumns.map(([column, name]) => html`<th key=${column} scope="col" aria-sort=${column !== key ? "none" : down ? "descending" : "ascending"}>
            <button type="button" class="link" onClick=${() => sort(column)}>${name}${column === key ? (down ? " ▼" : " ▲") : ""}</button></th>`)}
          <th scope="col">What was printed, tags and notes</th></tr></thead>
        <tbody>${runs.slice(0, rows).map(run => html`<${Row} key=${run.id} run=${run} editing=${edited === run.id} edit=${(on: boolean) => set_edited(on ? run.id : null)} />`)}
          ${runs.length > rows && html`<${MoreRows} left=${runs.length - rows} show=${() => set_rows(rows + kRowsAtOnce)} />`}</tbody>
      </table></div>
    </section>`;
}

export function report_address(runs: string[]): string {
  return `api/report?${runs.map(id => `run=${encodeURIComponent(id)}`).join("&")}`;
}

/** One report of these runs, which the process writes when it is asked for. */
export function ReportLink({runs}: {runs: string[]}) {
  return html`<a href=${report_address(runs)} target="_blank" rel="noopener">Open in report</a>`;
}

/** The end of the rows that are drawn. It draws more when it comes into view, or by its button. */
function MoreRows({left, show}: {left: number; show: () => void}) {
  const row = useRef<HTMLTableRowElement>(null);
  useEffect(() => {
    const seen = new IntersectionObserver(entries => { if (entries.some(one => one.isIntersecting)) show(); }, {rootMargin: "400px"});
    seen.observe(row.current!);
    return () => seen.disconnect();
  }, [left]);
  return html`<tr ref=${row}><td colspan="10"><button type="button" class="link" onClick=${show}>Show more of ${left}</button></td></tr>`;
}

function Row({run, editing, edit}: {run: RunSummary; editing: boolean; edit: (on: boolean) => void}) {
  return html`
    <tr>
      <td><input type="checkbox" aria-label=${`Choose ${label(run)}`} checked=${view.chosen.includes(run.id)}
        onChange=${(e: Event) => view.choose(run.id, (e.target as HTMLInputElement).checked)} /></td>
      <td><div class="named"><${Thumbnail} run=${run} />
        <div><a href=${`#run=${encodeURIComponent(run.id)}`}>${label(run)}</a>${run.live && html` <span class="tag on">live</span>`}
        <div class="soft">${run.part} ${!run.live && html`<a class="soft" href=${report_address([run.id])} target="_blank" rel="noopener">report</a>`}</div></div></div></td>
      <td data-name="Started (UTC)">${date(run.started_utc)}</td><td data-name="Lab">${run.lab}</td><td data-name="Scheme">${run.scheme}</td>
      <td data-name="Layers">${number(run.layers)}</td>
      <td class="verdict" data-name="End and verdict">${run.live ? run.state ?? "running" : run.outcome ?? "–"}
        ${run.verdict && html`<div class=${run.within === false ? "bad" : "soft"}>${with_micro(run.verdict)}</div>`}
        ${run.audit && html`<div class="soft">audit: ${run.audit}</div>`}</td>
      <td class="one-line" data-name="RMS">${height_words(run.rms_um, run.height_unit)}</td><td data-name="Overspill, %">${number(run.overspill_percent)}</td>
      <td class="notes">${editing
        ? html`<${NoteForm} run=${run} done=${() => edit(false)} />`
        : html`${meta_words(run.meta) && html`<div class="soft">${meta_words(run.meta)}</div>`}
            <${TagsAndNotes} run=${run} newest=${true} />
            <button type="button" class="link" aria-label=${`Add tags and a note to ${label(run)}`} onClick=${() => edit(true)}>add</button>`}</td>
    </tr>`;
}
