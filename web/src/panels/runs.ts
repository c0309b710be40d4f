// The list of runs: search, order, tags and notes, and the choice of runs to put beside each other.

import {html} from "htm/preact";
import {useEffect, useState} from "preact/hooks";
import {use_observed} from "../data/observable";
import type {RunSummary} from "../data/protocol";
import {found, sorted, type SortKey} from "../data/run_list";
import {forget, token} from "../data/token";
import {view} from "../data/view";
import {date, number} from "../data/words";
import {go} from "../routes";
import {have_token} from "./ask_token";

const kColumns: [SortKey, string][] = [["id", "Run"], ["started_utc", "Started (UTC)"], ["lab", "Lab"], ["scheme", "Scheme"],
  ["layers", "Layers"], ["outcome", "Outcome"], ["rms_um", "RMS, µm"], ["mean_um", "Mean, µm"]];

export function Runs() {
  use_observed(view);
  const [words, set_words] = useState("");
  const [key, set_key] = useState<SortKey>("started_utc");
  const [down, set_down] = useState(true);
  const [edited, set_edited] = useState<string | null>(null);
  useEffect(() => void view.load_runs(), []);
  const runs = sorted(found(view.runs ?? [], words), key, down);
  const sort = (column: SortKey) => {
    if (column === key) set_down(!down);
    else set_key(column);
  };
  return html`
    <section class="panel runs" aria-labelledby="runs-title">
      <div class="row head">
        <h2 id="runs-title">Runs</h2>
        <label>Search <input type="search" value=${words} placeholder="mpc tag:good" onInput=${(e: Event) => set_words((e.target as HTMLInputElement).value)} /></label>
        <span class="soft" role="status">${view.runs ? `${runs.length} of ${view.runs.length}` : "loading…"}</span>
        <button type="button" class="main" disabled=${view.chosen.length < 2} onClick=${() => go({page: "compare", compare: view.chosen})}>
          Put ${view.chosen.length || ""} beside each other</button>
        ${view.chosen.length > 0 && html`<${ReportLink} runs=${view.chosen} />`}
      </div>
      <div class="scroll" tabindex="0" role="region" aria-label="Table of runs"><table class="stack">
        <thead><tr><th scope="col"><span class="hidden">Choose</span></th>
          ${kColumns.map(([column, name]) => html`<th key=${column} scope="col" aria-sort=${column !== key ? "none" : down ? "descending" : "ascending"}>
            <button type="button" class="link" onClick=${() => sort(column)}>${name}${column === key ? (down ? " ▼" : " ▲") : ""}</button></th>`)}
          <th scope="col">Tags and note</th></tr></thead>
        <tbody>${runs.map(run => html`<${Row} key=${run.id} run=${run} editing=${edited === run.id} edit=${(on: boolean) => set_edited(on ? run.id : null)} />`)}</tbody>
      </table></div>
    </section>`;
}

/** One report of these runs, which the process writes when it is asked for. */
export function ReportLink({runs}: {runs: string[]}) {
  const address = `/api/report?${runs.map(id => `run=${encodeURIComponent(id)}`).join("&")}`;
  return html`<a href=${address} target="_blank" rel="noopener">Open in report</a>`;
}

function Row({run, editing, edit}: {run: RunSummary; editing: boolean; edit: (on: boolean) => void}) {
  return html`
    <tr>
      <td><input type="checkbox" aria-label=${`Choose ${run.id}`} checked=${view.chosen.includes(run.id)}
        onChange=${(e: Event) => view.choose(run.id, (e.target as HTMLInputElement).checked)} /></td>
      <td><a href=${`#run=${encodeURIComponent(run.id)}`}>${run.id}</a>${run.live && html` <span class="tag on">live</span>`}
        ${!run.live && html` <a class="soft" href=${`/api/report?run=${encodeURIComponent(run.id)}`} target="_blank" rel="noopener">report</a>`}</td>
      <td data-name="Started (UTC)">${date(run.started_utc)}</td><td data-name="Lab">${run.lab}</td><td data-name="Scheme">${run.scheme}</td>
      <td data-name="Layers">${number(run.layers)}</td><td data-name="Outcome">${run.live ? "printing" : run.outcome ?? "–"}</td>
      <td data-name="RMS, µm">${number(run.rms_um)}</td><td data-name="Mean, µm">${number(run.mean_um)}</td>
      <td class="notes">${editing
        ? html`<${Notes} run=${run} done=${() => edit(false)} />`
        : html`${run.tags.map(tag => html`<span key=${tag} class="tag">${tag}</span> `)}<span>${run.note} </span>
            <button type="button" class="link" aria-label=${`Edit tags and note of ${run.id}`} onClick=${() => edit(true)}>edit</button>`}</td>
    </tr>`;
}

function Notes({run, done}: {run: RunSummary; done: () => void}) {
  const [tags, set_tags] = useState(run.tags.join(", "));
  const [note, set_note] = useState(run.note);
  const [trouble, set_trouble] = useState<string | null>(null);
  const save = async (event: Event) => {
    event.preventDefault();
    if (!(await have_token("A note"))) return;
    const wanted = {tags: tags.split(",").map(tag => tag.trim()).filter(Boolean), note};
    try {
      const reply = await fetch(`/api/runs/${encodeURIComponent(run.id)}/notes`, {
        method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({token: token(), ...wanted})});
      const body = await reply.json().catch(() => null);
      if (reply.status === 403) forget();
      if (!reply.ok || body?.ok === false) throw new Error(body?.error ?? reply.statusText);
      Object.assign(run, wanted);
      view.changed();
      done();
    } catch (error) {
      set_trouble(`not kept: ${(error as Error).message}`);
    }
  };
  const value = (set: (text: string) => void) => (e: Event) => set((e.target as HTMLInputElement).value);
  return html`
    <form onSubmit=${save} onKeyDown=${(e: KeyboardEvent) => { if (e.key === "Escape") done(); }}>
      <label>Tags, with commas <input value=${tags} autofocus onInput=${value(set_tags)} /></label>
      <label>Note <textarea rows="2" value=${note} onInput=${value(set_note)}></textarea></label>
      <div class="row"><button type="submit" class="main">Keep</button><button type="button" onClick=${done}>Cancel</button></div>
      ${trouble && html`<p class="bad" role="alert">${trouble}</p>`}
    </form>`;
}
