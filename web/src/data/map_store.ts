// Maps of one run, loaded as they are asked for and kept while there is room.

import {address_of} from "./address";
import {Observable} from "./observable";
import {in_unit, read_map, type SurfaceMap} from "./maps";
import {kMapPartial, kSurfaceWords, type Surface} from "./protocol";
import {read} from "./token";

const kMostBytes = 64 << 20;
const kPatience_ms = 2000;  // for a map that the process sends by itself

type Entry = SurfaceMap | {missing: string};

export class MapStore extends Observable {
  private readonly kept = new Map<string, Entry>();  // oldest use first
  private readonly loading = new Map<string, AbortController>();
  private readonly newest_frame = new Map<Surface, SurfaceMap>();
  private partial: SurfaceMap | null = null;  // as it came, in um: further rows go over it
  private coming: string | null = null;  // key of the map that the process sends by itself next
  private bytes = 0;

  constructor(private readonly run: string, private readonly height_unit: string | undefined) {
    super();
  }

  /** The map if it is here; else null, and the loading begins. Loads of layers that nobody waits for any more end. */
  get(surface: Surface, layer: number): SurfaceMap | null {
    const key = `${layer}/${surface}`;
    const found = this.kept.get(key);
    if (found) {
      this.kept.delete(key);
      this.kept.set(key, found);
      return "missing" in found ? null : found;
    }
    if (!this.loading.has(key) && key !== this.coming) void this.load(key);
    return null;
  }

  /** Why a map is not there, or null. */
  missing(surface: Surface, layer: number): string | null {
    const found = this.kept.get(`${layer}/${surface}`);
    return found && "missing" in found ? found.missing : null;
  }

  /** Ends loads of other layers than these: a cursor that moves fast asks for many. */
  only(layers: number[]): void {
    for (const [key, control] of this.loading)
      if (!layers.includes(Number(key.split("/")[0]))) control.abort();
  }

  take_frame(bytes: ArrayBuffer): void {
    try {
      const came = read_map(bytes, this.partial);
      const map = in_unit(came, this.height_unit);
      const key = `${map.layer}/${map.surface}`;
      if (map.flags & kMapPartial) this.partial = came;
      else if (key === this.coming) this.coming = null;
      this.put(key, map);
      if (map.layer >= (this.newest_frame.get(map.surface)?.layer ?? 0)) this.newest_frame.set(map.surface, map);
      this.changed();
    } catch (error) {
      console.warn("firn: a map was left out:", error);
    }
  }

  /** Maps are on their way, or none was asked for yet. */
  get busy(): boolean {
    return this.loading.size > 0 || this.kept.size === 0;
  }

  /** The newest map that the process sent by itself, or null. */
  newest(surface: Surface): SurfaceMap | null {
    return this.newest_frame.get(surface) ?? null;
  }

  private async load(key: string): Promise<void> {
    const control = new AbortController();
    this.loading.set(key, control);
    try {
      const reply = await read(address_of(`api/runs/${encodeURIComponent(this.run)}/layers/${key}`), {signal: control.signal});
      if (reply.status === 204) this.put(key, {missing: `this run has no ${kSurfaceWords[key.split("/")[1] as Surface]} of layer ${key.split("/")[0]}`});
      else if (reply.ok) this.put(key, in_unit(read_map(await reply.arrayBuffer()), this.height_unit));
      else this.put(key, {missing: (await reply.json().catch(() => null))?.error ?? `${reply.status} ${reply.statusText}`});
    } catch (error) {
      if (!control.signal.aborted) {
        this.put(key, {missing: String((error as Error).message ?? error)});
        setTimeout(() => this.drop(key), 1000);  // a lost connection is no property of the map
      }
    }
    this.loading.delete(key);
    this.changed();
  }

  private put(key: string, entry: Entry): void {
    this.drop(key);
    this.kept.set(key, entry);
    this.bytes += "missing" in entry ? 0 : entry.values.byteLength;
    for (const [oldest] of this.kept) {
      if (this.bytes <= kMostBytes || this.kept.size <= 4) break;
      this.drop(oldest);
    }
  }

  /** A layer has been measured: maps of it that were not there, or a part, are asked for again. The one of `followed`
   *  comes by itself, and is asked for if it does not. */
  layer_done(layer: number, followed: Surface | null): void {
    for (const [key, entry] of this.kept)
      if (Number(key.split("/")[0]) === layer && ("missing" in entry || entry.flags & kMapPartial)) this.drop(key);
    const key = followed && `${layer}/${followed}`;
    this.coming = key && !this.kept.has(key) ? key : null;
    if (this.coming) setTimeout(() => this.wait_no_more(key), kPatience_ms);
  }

  /** Asks for the map that was to come, if it is still this one. */
  wait_no_more(key = this.coming): void {
    if (key !== this.coming) return;
    this.coming = null;
    this.changed();
  }

  private drop(key: string): void {
    const entry = this.kept.get(key);
    if (entry && !("missing" in entry)) this.bytes -= entry.values.byteLength;
    this.kept.delete(key);
  }
}
