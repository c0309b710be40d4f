// The browser's own notifications, where the reader asked for them: they show when the tab is in the background.

const kWanted = "firn-notify";

/** Browsers offer them to https and to this computer alone. */
export function can_tell(): boolean {
  return typeof Notification !== "undefined" && isSecureContext && Notification.permission !== "denied";
}

export function is_telling(): boolean {
  return can_tell() && Notification.permission === "granted" && localStorage.getItem(kWanted) === "yes";
}

/** Asks the reader for the permission, once. */
export async function want_telling(wanted: boolean): Promise<void> {
  if (wanted && can_tell() && Notification.permission === "default") await Notification.requestPermission();
  localStorage.setItem(kWanted, wanted ? "yes" : "no");
}

/** One for each title: a later one takes the place of the earlier. */
export function tell_of(title: string, body: string): void {
  if (is_telling()) new Notification(title, {body, tag: title});
}
