// What was printed: [meta] of the shown run, its tags and its notes.

import {html} from "htm/preact";
import {use_observed} from "../data/observable";
import type {Session} from "../data/session";
import {view} from "../data/view";
import {meta_words, NoteForm, TagsAndNotes} from "./notes";

export function About({session}: {session: Session}) {
  use_observed(session);
  use_observed(view);
  const {run} = session.hello;
  const meta = Object.entries(run.meta ?? {});
  return html`
    <section class="panel" aria-labelledby="about-title">
      <details>
        <summary><h2 id="about-title">What was printed</h2> <span class="soft">${meta_words(run.meta) || "no [meta]"}; ${run.tags?.length ?? 0} tags, ${run.notes?.length ?? 0} notes</span></summary>
        ${(meta.length > 0 || run.host) && html`<table aria-label="What was printed"><tbody>
          ${meta.map(([key, value]) => html`<tr key=${key}><th scope="row">${key}</th><td>${String(value)}</td></tr>`)}
          ${run.host && html`<tr><th scope="row">computer</th><td>${run.host}</td></tr>`}</tbody></table>`}
        <div class="notes"><${TagsAndNotes} run=${run} newest=${false} /></div>
        <${NoteForm} run=${run} />
      </details>
    </section>`;
}
