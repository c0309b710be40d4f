// The token that commands and notes need: from the address that the terminal printed, else asked for once a tab.

const kKey = "firn-token";

/** Takes the token out of the address, so that no screenshot and no history keeps it; returns the address's other words. */
export function take_from_address(): URLSearchParams {
  const words = new URLSearchParams(location.hash.replace(/^#\/?/, ""));
  const token = words.get("token");
  if (token) {
    keep(token);
    words.delete("token");
    history.replaceState(null, "", words.size ? `#${words}` : location.pathname);
  }
  return words;
}

export function token(): string | null {
  return sessionStorage.getItem(kKey);
}

/** A proxy says whose requests these are: commands need no token of the tab. */
let known = false;
export function need_no_token(none: boolean): void {
  known = none;
}
export function is_known(): boolean {
  return known;
}

// Requests show the token by a cookie, which WebSockets and links send too. Cookies are of all ports of a host.
function show(text: string | null): void {
  const safe = location.protocol === "https:" ? "; Secure" : "";
  document.cookie = `firn-${location.port}=${text ?? ""}; Path=/; SameSite=Strict${safe}${text === null ? "; Max-Age=0" : ""}`;
}

export function keep(text: string): void {
  sessionStorage.setItem(kKey, text.trim());
  show(text.trim().replace(/[^0-9A-Za-z-]/g, ""));
}

export function forget(): void {
  sessionStorage.removeItem(kKey);
  show(null);
}

/** Asks the reader for the token; the dialog sets it. */
let ask: (purpose: string) => Promise<boolean> = () => Promise.resolve(false);
export function set_asker(asker: typeof ask): void {
  ask = asker;
}

/** Reads from the process; without the right token it asks for it once. */
export async function read(path: string, init?: RequestInit): Promise<Response> {
  const secret = token();
  if (secret) show(secret);  // another page of this host may have forgotten it
  const reply = await fetch(path, init);
  if (reply.status !== 401) return reply;
  forget();
  return (await ask("Reading")) ? fetch(path, init) : reply;
}
