// Where the reader looks: page, run, layer, surface, scale. One object, one cursor for everything.

import {address_of} from "./address";
import {Observable} from "./observable";
import type {RunSummary, Surface} from "./protocol";
import type {Scale} from "./maps";
import {Session} from "./session";
import {read} from "./token";

export type Page = "print" | "runs" | "compare";
export type Shown = Surface | "difference";

export class View extends Observable {
  page: Page = "print";
  session: Session | null = null;
  opening: string | null = null;
  trouble: string | null = null;

  layer: number | null = null;  // null: the newest one
  surface: Shown = "error";
  mode: "map" | "solid" = "map";
  other_run: Session | null = null;  // of a difference; null: this run
  other_layer: number | null = null;  // null: the cursor's, or the one before it in this run
  scales = new Map<string, Scale>();  // held until asked to fit
  cell: [number, number] | null = null;
  cut: [[number, number], [number, number]] | null = null;

  runs: RunSummary[] | null = null;
  chosen: string[] = [];  // runs beside each other
  beside = new Map<string, Session | {error: string}>();

  /** Layer under the cursor. */
  get shown_layer(): number {
    return this.stops.filter(stop => stop <= (this.layer ?? Infinity)).pop() ?? 0;
  }

  /** Layers that the cursor can be at. */
  get stops(): number[] {
    if (this.page !== "compare") return this.session?.stops ?? [0];
    return [...new Set(this.sessions_beside().flatMap(one => one.stops))].sort((a, b) => a - b);
  }

  get last_layer(): number {
    return this.stops[this.stops.length - 1] ?? 0;
  }

  /** Moves the cursor by stops. */
  step(by: number): void {
    const stops = this.stops;
    const at = stops.indexOf(this.shown_layer) + by;
    this.move_to(at < 0 ? 0 : at < stops.length ? stops[at] : this.last_layer + 1);
  }

  sessions_beside(): Session[] {
    return this.chosen.map(id => this.beside.get(id)).filter((one): one is Session => one instanceof Session);
  }

  /** Moves the cursor; at the end of a live print it stays with the newest layer. */
  move_to(layer: number | null): void {
    const last = this.last_layer;
    const live = this.page === "print" && this.session?.live;
    this.layer = layer == null || (live && layer > last) ? null : Math.max(0, Math.min(layer, last));
    this.session?.maps.only([this.shown_layer, this.session.stop_at(this.shown_layer - 1), this.other_layer ?? -1]);
    this.changed();
  }

  async open(id: string): Promise<boolean> {
    this.opening = id;
    this.trouble = null;
    this.changed();
    try {
      const session = await Session.open(id);
      if (this.opening !== id) {
        session.close();
        return false;
      }
      this.session?.close();
      this.session = session;
      Object.assign(this, {page: "print", layer: null, scales: new Map(), cell: null, cut: null, other_layer: null});
      this.other_run?.close();
      this.other_run = null;
      this.opening = null;
      this.changed();
      return true;
    } catch (error) {
      if (this.opening === id) {
        this.opening = null;
        this.trouble = `${id}: ${(error as Error).message}`;
        this.changed();
      }
      return false;
    }
  }

  async load_runs(): Promise<void> {
    try {
      this.runs = await this.runs_of("");
      this.trouble = null;
    } catch (error) {
      this.trouble = `the list of runs: ${(error as Error).message}`;
    }
    this.changed();
  }

  /** Runs that meet a condition, as firn runs find takes it; all of them without one. */
  async runs_of(where: string): Promise<RunSummary[]> {
    const reply = await read(address_of(`api/runs${where && `?where=${encodeURIComponent(where)}`}`));
    const body = await reply.json();
    if (!reply.ok || body?.error) throw new Error(body?.error ?? reply.statusText);
    return body.runs ?? [];
  }

  choose(id: string, wanted: boolean): void {
    this.chosen = this.chosen.filter(one => one !== id);
    if (wanted) this.chosen.push(id);
    else this.leave(id);
    this.changed();
  }

  async load_beside(): Promise<void> {
    this.layer = null;
    await Promise.all(this.chosen.filter(id => !(this.beside.get(id) instanceof Session)).map(async id => {
      try {
        this.beside.set(id, await Session.open(id));
      } catch (error) {
        this.beside.set(id, {error: (error as Error).message});
      }
      this.changed();
    }));
  }

  private leave(id: string): void {
    const session = this.beside.get(id);
    if (session instanceof Session) session.close();
    this.beside.delete(id);
  }

  async take_other(id: string | null): Promise<void> {
    this.other_run?.close();
    this.other_run = null;
    this.scales.delete("difference");
    this.changed();
    if (id) {
      try {
        this.other_run = await Session.open(id);
      } catch (error) {
        this.trouble = `${id}: ${(error as Error).message}`;
      }
      this.changed();
    }
  }
}

export const view = new View();
