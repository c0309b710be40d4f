// Alarms: events that a person has to see, with who acknowledged which of them and when; and what tells of new ones: the title of
// the tab, and the browser's own notifications.

import {html} from "htm/preact";
import {useEffect, useState} from "preact/hooks";
import {address_of} from "../data/address";
import {open_alarms, title_words} from "../data/alarms";
import {use_clock, use_observed} from "../data/observable";
import type {PrintEvent} from "../data/protocol";
import type {Session} from "../data/session";
import {can_tell, is_telling, tell_of, want_telling} from "../data/tell";
import {forget, token} from "../data/token";
import {view} from "../data/view";
import {clock, date, label} from "../data/words";
import {have_token} from "./ask_token";

const kAuthor = "firn-author";

/** The title of the tab follows the print: what is open, alarms first. */
export function Title() {
  use_observed(view, view.session ?? view);
  use_clock(1000, view.session?.live ?? false);
  const words = title_words(view.page === "print" ? view.session : null);
  useEffect(() => { document.title = words; }, [words]);
  return null;
}

/** Tells of each new alarm and of the end, while this tab shows a live print. */
export function use_telling(session: Session): void {
  use_observed(session);
  const newest = open_alarms(session).length ? open_alarms(session).slice(-1)[0] : null;
  const end = session.ending?.words ?? null;
  const [first] = useState({alarm: newest?.n ?? 0, end});
  useEffect(() => {
    if (newest && newest.n > first.alarm) tell_of(`${label(session.hello.run)}: ${newest.severity}`, `${newest.source}: ${newest.words}`);
  }, [newest?.n]);
  useEffect(() => {
    if (end && end !== first.end) tell_of(label(session.hello.run), end);
  }, [end]);
}

export function Alarms({session}: {session: Session}) {
  use_observed(session);
  use_telling(session);
  const [author, set_author] = useState(localStorage.getItem(kAuthor) ?? "");
  const [trouble, set_trouble] = useState<string | null>(null);
  const [, redraw] = useState(0);
  const alarms = session.events.filter(event => event.alarm);
  const known = session.hello.you?.name ?? null;
  const name = known ?? author.trim();
  const may = session.hello.you ? session.hello.you.commands || session.hello.you.needs_token : true;
  const acknowledge = async (alarm: PrintEvent) => {
    if (!(await have_token("An acknowledgement"))) return;
    try {
      const reply = await fetch(address_of(`api/runs/${encodeURIComponent(session.hello.run.id)}/acknowledge`), {
        method: "POST", headers: {"Content-Type": "application/json"},
        body: JSON.stringify({token: token() ?? undefined, author: name, alarm: alarm.alarm})});
      const body = await reply.json().catch(() => null);
      if (reply.status === 403) forget();
      if (!reply.ok) throw new Error(body?.error ?? reply.statusText);
      localStorage.setItem(kAuthor, author.trim());
      set_trouble(null);
      session.take_acknowledged(body.alarms);
    } catch (error) {
      set_trouble(`not acknowledged: ${(error as Error).message}`);
    }
  };
  const ask_telling = async () => {
    await want_telling(!is_telling());
    redraw(n => n + 1);
  };
  const open = open_alarms(session).length;
  return html`
    <section class="panel alarms" aria-labelledby="alarms-title">
      <div class="row head">
        <h2 id="alarms-title">Alarms</h2>
        <span class=${open ? "bad" : "soft"} role="status">${open ? `${open} not acknowledged` : alarms.length ? "all acknowledged" : "none"}</span>
        ${session.live && html`<label class="check" title=${can_tell() ? "" : "this browser offers it to https and to localhost alone"}>
          <input type="checkbox" checked=${is_telling()} disabled=${!can_tell()} onChange=${ask_telling} /> notify me</label>`}
      </div>
      ${open > 0 && may && !known && html`<label>Your name <input name="alarm-author" autocomplete="name" maxlength="100" value=${author}
        onInput=${(e: Event) => set_author((e.target as HTMLInputElement).value)} /></label>`}
      ${alarms.length > 0 && html`<ol class="events" tabindex="0" aria-label="Alarms, newest first">
        ${[...alarms].reverse().map(alarm => {
          const seen = session.acknowledged.get(alarm.alarm!);
          return html`<li key=${alarm.n} class=${`is-${alarm.severity}`}>
            <div><span class="time">${clock(alarm.t_s)}</span> <span class="severity">${alarm.severity}: </span>
              <span>${alarm.words}</span> <span class="soft">${alarm.source}</span>
              ${seen ? html`<p class="detail">acknowledged by ${seen.author}, ${date(seen.time_utc)}</p>`
                     : may && html` <button type="button" disabled=${!name} title=${name ? "" : "by name: give yours"}
                         onClick=${() => acknowledge(alarm)}>Acknowledge</button>`}
            </div></li>`;
        })}
      </ol>`}
      ${trouble && html`<p class="bad" role="alert">${trouble}</p>`}
    </section>`;
}
