// Buttons of a run that is over, in the page's head: resume, report, audit; and what they answered.

import {html} from "htm/preact";
import {useEffect, useState} from "preact/hooks";
import {use_observed} from "../data/observable";
import {audit, printed_again, resume} from "../data/orders";
import type {Session} from "../data/session";
import {view} from "../data/view";
import {with_micro} from "../data/words";
import {have_token} from "./ask_token";
import {report_address} from "./runs";

const kSure_ms = 5000;   // within which the second press counts
const kAsked_ms = 400;   // before which it is the same double click

interface Said {
  title: string;
  lines: string[];
  good: boolean;
}

export function Over({session}: {session: Session}) {
  use_observed(session);
  const [asked_ms, set_asked] = useState<number | null>(null);
  const [busy, set_busy] = useState<string | null>(null);
  const [said, set_said] = useState<Said | null>(null);
  useEffect(() => {
    if (asked_ms === null) return;
    const timer = setTimeout(() => set_asked(null), kSure_ms);
    return () => clearTimeout(timer);
  }, [asked_ms]);
  useEffect(() => { if (session.live) set_said(null); }, [session.live, said]);  // the page itself shows the print that goes on
  if (session.live) return null;

  const run = session.hello.run.id;
  const carry_out = async (what: string, work: () => Promise<Said | null>) => {
    set_busy(what);
    set_said(null);
    try {
      set_said(await work());
    } catch (error) {
      set_said({title: `${what}: ${with_micro((error as Error).message)}`, lines: [], good: false});
    }
    set_busy(null);
  };
  const press_audit = () => void carry_out("Audit", async () => {
    const {clean, text} = await audit(run);
    const lines = with_micro(text).split("\n").filter(Boolean);
    return {title: `Audit: ${lines[0]}`, lines: lines.slice(1), good: clean};
  });
  const press_resume = async () => {
    const now_ms = performance.now();
    if (asked_ms === null) return set_asked(now_ms);
    if (now_ms < asked_ms + kAsked_ms) return;
    set_asked(null);
    if (!(await have_token("To resume a print"))) return;
    void carry_out("Resume", async () => {
      const pid = await resume(run);
      if (pid !== null && await printed_again(run)) await view.open(run);
      return {title: pid === null ? "Resume: the print is over" : `Resume: process ${pid} prints`, lines: [], good: true};
    });
  };
  const can_resume = session.ending?.can_go_on && session.hello.commands.resume;
  return html`
    <div class="row orders" role="group" aria-label="This run">
      ${can_resume && html`<button type="button" class=${asked_ms === null ? "" : "main"} disabled=${busy !== null} onClick=${() => void press_resume()}>
        ${busy === "Resume" ? "Resuming…" : asked_ms === null ? "Resume" : "Resume: press again"}</button>`}
      <a class="button" href=${report_address([run])} target="_blank" rel="noopener">Report</a>
      <button type="button" disabled=${busy !== null} onClick=${press_audit}>${busy === "Audit" ? "Auditing…" : "Audit"}</button>
    </div>
    <div class="said" role="status" aria-live="polite">
      ${asked_ms !== null && html`<p class="notice">The print goes on where it ended: the instruments will move. Press Resume again to begin.</p>`}
      ${said && html`<section class=${said.good ? "notice fine" : "notice stopped"} aria-label=${said.title}>
        <p><strong class=${said.good ? "good" : "bad"}>${said.title}</strong></p>
        ${said.lines.map((line, i) => html`<p key=${i}>${line}</p>`)}
        <button type="button" class="link" onClick=${() => set_said(null)}>Close</button></section>`}
    </div>`;
}
