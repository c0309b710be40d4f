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

export function keep(text: string): void {
  sessionStorage.setItem(kKey, text.trim());
}

export function forget(): void {
  sessionStorage.removeItem(kKey);
}
