// Addresses behind the #: a run, the list, runs beside each other. Back and forward work.

import {view, type Page} from "./data/view";
import {take_from_address} from "./data/token";

export interface Place {
  page: Page;
  run?: string;
  compare?: string[];
}

export function go(place: Place): void {
  if (place.page === "runs") location.hash = "runs";
  else if (place.page === "compare") location.hash = `compare=${place.compare!.map(encodeURIComponent).join(",")}`;
  else location.hash = `run=${encodeURIComponent(place.run ?? "live")}`;
}

/** Follows the address: opens what it names; without a name the live print, else the list. */
export async function follow_address(): Promise<void> {
  const words = take_from_address();
  const compare = words.get("compare");
  if (compare) {
    const wanted = compare.split(",").filter(Boolean).slice(0, 6);
    for (const id of view.chosen) if (!wanted.includes(id)) view.choose(id, false);
    for (const id of wanted) view.choose(id, true);
    view.page = "compare";
    view.layer = null;
    view.changed();
    return;
  }
  if (words.has("runs")) {
    view.page = "runs";
    view.changed();
    return;
  }
  const run = words.get("run");
  const open = view.session?.hello.run;
  if (open && (open.id === run || (open.live && (!run || run === "live")))) {
    view.page = "print";
    view.changed();
    return;
  }
  view.page = "print";
  if (!(await view.open(run ?? "live")) && !run) {
    view.trouble = null;
    view.page = "runs";
    view.changed();
  }
}
