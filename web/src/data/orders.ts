// Orders to a run that is over: audit it, resume it.

import {address_of} from "./address";
import {forget, read, token} from "./token";

const kLooks = 60;
const kLook_ms = 250;

export interface Audit {
  clean: boolean;
  text: string;  // lines, as of firn audit
}

function path(run: string, what = ""): string {
  return address_of(`api/runs/${encodeURIComponent(run)}${what}`);
}

async function body_of(reply: Response): Promise<any> {
  const body = await reply.json().catch(() => null);
  if (!reply.ok) throw new Error(body?.error ?? `${reply.status} ${reply.statusText}`);
  return body;
}

/** Compares the run's records with each other and with its seals; throws with the process's own words. */
export async function audit(run: string): Promise<Audit> {
  return body_of(await read(path(run, "/audit")));
}

/** Starts the print of the run's missing layers; the process that prints, or null where it was over at once. */
export async function resume(run: string): Promise<number | null> {
  const reply = await fetch(path(run, "/resume"), {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({token: token()})});
  if (reply.status === 403) forget();
  return (await body_of(reply))?.pid ?? null;
}

/** Waits until the page's process sees the run printed: it looks for prints now and then. */
export async function printed_again(run: string): Promise<boolean> {
  for (let looks = 0; looks < kLooks; ++looks) {
    const hello = await read(path(run)).then(reply => reply.json()).catch(() => null);
    if (hello?.run?.live && !hello.run.finished) return true;
    await new Promise(resolve => setTimeout(resolve, kLook_ms));
  }
  return false;
}
