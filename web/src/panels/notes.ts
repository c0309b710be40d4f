// Tags and notes of a run: shown with author and time, and added to.

import {html} from "htm/preact";
import {useState} from "preact/hooks";
import {address_of} from "../data/address";
import type {Meta, Note} from "../data/protocol";
import {forget, token} from "../data/token";
import {view} from "../data/view";
import {date} from "../data/words";
import {have_token} from "./ask_token";

const kAuthor = "firn-author";

interface Noted {
  id: string;
  meta?: Meta;
  tags?: string[];
  notes?: Note[];
}

/** "sample PCB-7, ink TPGDA" */
export function meta_words(meta?: Meta): string {
  return Object.entries(meta ?? {}).map(([key, value]) => `${key} ${value}`).join(", ");
}

function NoteText({note}: {note: Note}) {
  const who = [note.author, note.time_utc && date(note.time_utc)].filter(Boolean).join(", ");
  return html`<span class="note">${note.text}</span>${who && html` <span class="soft">${who}</span>`}`;
}

/** `newest`: of the notes the last one alone, and how many there are. */
export function TagsAndNotes({run, newest}: {run: Noted; newest: boolean}) {
  const notes = run.notes ?? [];
  const shown = newest ? notes.slice(-1) : notes;
  return html`${(run.tags ?? []).map(tag => html`<span key=${tag} class="tag">${tag}</span> `)}
    ${shown.length > 0 && html`<ul class="plain">${shown.map((note, n) => html`<li key=${n}><${NoteText} note=${note} /></li>`)}</ul>`}
    ${newest && notes.length > 1 && html`<span class="soft">and ${notes.length - 1} earlier </span>`}`;
}

export function NoteForm({run, done}: {run: Noted; done?: () => void}) {
  const before = run.tags ?? [];
  const [tags, set_tags] = useState(before.join(", "));
  const [note, set_note] = useState("");
  const [author, set_author] = useState(localStorage.getItem(kAuthor) ?? "");
  const [trouble, set_trouble] = useState<string | null>(null);
  const save = async (event: Event) => {
    event.preventDefault();
    if (!(await have_token("A note"))) return;
    const wanted = tags.split(",").map(tag => tag.trim()).filter(Boolean);
    const asked = {author: author.trim(), note: note.trim(), add_tags: wanted.filter(tag => !before.includes(tag)),
                   remove_tags: before.filter(tag => !wanted.includes(tag))};
    try {
      const reply = await fetch(address_of(`api/runs/${encodeURIComponent(run.id)}/notes`), {
        method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({token: token() ?? undefined, ...asked})});
      const body = await reply.json().catch(() => null);
      if (reply.status === 403) forget();
      if (!reply.ok) throw new Error(body?.error ?? reply.statusText);
      localStorage.setItem(kAuthor, author.trim());
      Object.assign(run, {tags: body.tags, notes: body.notes});
      set_note("");
      set_tags(body.tags.join(", "));
      set_trouble(null);
      view.changed();
      done?.();
    } catch (error) {
      set_trouble(`not kept: ${(error as Error).message}`);
    }
  };
  const value = (set: (text: string) => void) => (e: Event) => set((e.target as HTMLInputElement).value);
  return html`
    <form class="note-form" onSubmit=${save} onKeyDown=${(e: KeyboardEvent) => { if (e.key === "Escape") done?.(); }}>
      <label>Tags, with commas <input name="tags" value=${tags} autofocus=${Boolean(done)} onInput=${value(set_tags)} /></label>
      <label>New note <textarea rows="2" value=${note} onInput=${value(set_note)}></textarea></label>
      <label>Your name <input name="author" autocomplete="name" maxlength="100" value=${author} onInput=${value(set_author)} /></label>
      <div class="row"><button type="submit" class="main">Keep</button>${done && html`<button type="button" onClick=${done}>Cancel</button>`}</div>
      ${trouble && html`<p class="bad" role="alert">${trouble}</p>`}
    </form>`;
}
