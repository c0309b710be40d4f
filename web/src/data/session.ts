// One run as the page knows it: what the process told of it, live over a WebSocket or once by HTTP.

import {address_of, refusal_of_socket, socket_address} from "./address";
import {CommandLine} from "./command_line";
import {MapStore} from "./map_store";
import {Observable} from "./observable";
import {kProtocol, parse_message} from "./protocol";
import type {Acknowledged, Answer, Ending, Estimate, Grid, Hello, Instrument, LampHours, Layer, PrintEvent, PrintState, ServerMessage, Surface} from "./protocol";
import {forget, is_known, need_no_token, read, token} from "./token";

const kRetry_ms = [500, 1000, 2000, 5000];
const kAnswer_ms = 5000;
const kLater_ms = 1500;  // for slow answers: the surface comes first
export const kOldest_s = 1;  // older words lock the commands

export class Session extends Observable {
  hello: Hello;
  state: PrintState | null;
  layers: Layer[] = [];
  events: PrintEvent[] = [];
  instruments = new Map<string, Instrument>();
  estimates: Estimate[] = [];
  ending: Ending | null = null;
  acknowledged = new Map<string, Acknowledged>();  // by alarm
  connected = false;
  trouble: string | null = null;
  refused: string | null = null;  // why there is no live connection, where somebody said so
  lamp: LampHours | null = null;
  readonly maps: MapStore;

  private socket: WebSocket | null = null;
  private line: CommandLine | null = null;  // for commands alone, once there is a token: no map is before them
  private was_connected = false;
  private readonly opened_at_ms = performance.now();
  private retries = 0;
  private retry_timer = 0;
  private later_timer = 0;
  private closed = false;
  private state_at_ms = performance.now();
  private next_id = 1;
  private asked_grid = false;
  private followed: Surface | null = null;
  private readonly waiting = new Map<number, (answer: Answer) => void>();

  constructor(hello: Hello) {
    super();
    this.hello = hello;
    this.state = hello.state;
    this.maps = new MapStore(hello.run.id, hello.run.height_unit);
    this.take_hello(hello);
    if (hello.run.live) {
      this.line = new CommandLine(socket_address(this.path("command")), text => {
        const message = parse_message(text);
        if (message?.type === "answer") this.take(message);
        this.changed();
      }, () => this.answer_none());
      this.connect();
    }
    this.later_timer = window.setTimeout(() => void this.load_later(), kLater_ms);
  }

  /** Reads a run by HTTP; throws with the process's own words. */
  static async open(id: string): Promise<Session> {
    const reply = await read(address_of(`api/runs/${encodeURIComponent(id)}`));
    if (reply.status === 204) throw new Error("this page is part of no print: the list has its runs");
    const body = await reply.json().catch(() => null);
    if (!reply.ok || body?.type === "error") throw new Error(body?.error ?? `${reply.status} ${reply.statusText}`);
    if (body?.protocol !== kProtocol)
      throw new Error(`this page speaks protocol ${kProtocol}, the process speaks ${body?.protocol}: load the page again`);
    return new Session(body);
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.retry_timer);
    clearTimeout(this.later_timer);
    this.socket?.close();
    this.line?.end();
  }

  get live(): boolean {
    return this.hello.run.live && !this.hello.run.finished && !this.ending;
  }

  /** Unit of heights in this run's lab: "um" or "mm". */
  get height_unit(): string {
    return this.hello.run.height_unit ?? "um";
  }

  /** The grid of the maps; a guess of 1 mm before the process knows it. */
  get grid(): Grid {
    return this.hello.run.grid ?? {nx: 1, ny: 1, pitch_mm: 1, x0_mm: 0, y0_mm: 0};
  }

  /** Number of the newest layer that was measured. */
  get last_layer(): number {
    return this.layers.length ? this.layers[this.layers.length - 1].n : 0;
  }

  /** Layers that the cursor can be at: the bare substrate, and each that was measured (in ice, one of several). */
  get stops(): number[] {
    return [...new Set([0, ...this.layers.map(layer => layer.n)])];
  }

  /** The newest stop that is not above `n`. */
  stop_at(n: number): number {
    return this.stops.filter(stop => stop <= n).pop() ?? 0;
  }

  layer(n: number): Layer | null {
    const guess = this.layers[n - (this.layers[0]?.n ?? 0)];
    return guess?.n === n ? guess : this.layers.find(layer => layer.n === n) ?? null;
  }

  /** Seconds since a datum arrived, by the process and by the time since it told so; null where there is none. */
  age_s(what: string): number | null {
    const told = this.state?.ages?.[what];
    return told == null ? null : told + (performance.now() - this.state_at_ms) / 1000;
  }

  /** Seconds since anything came from the print; infinite without a connection. */
  get link_age_s(): number {
    if (!this.connected) return Infinity;
    return Math.max(this.age_s("link_s") ?? 0, (performance.now() - this.state_at_ms) / 1000);
  }

  /** The first connection is on its way, and that is no trouble yet. */
  get connecting(): boolean {
    return this.live && !this.was_connected && performance.now() - this.opened_at_ms < 1000 * kOldest_s;
  }

  get stale(): boolean {
    return this.live && this.link_age_s > kOldest_s;
  }

  /** The lamp's earlier hours, and of a run that is over the last bytes on the instruments' lines: both lie in large files. */
  private async load_later(): Promise<void> {
    if (this.maps.busy && !this.live) {
      this.later_timer = window.setTimeout(() => void this.load_later(), kLater_ms);
      return;
    }
    if (!this.live) {
      for (const {name, text} of (await this.ask("exchanges"))?.exchanges ?? []) {
        const one = this.instruments.get(name);
        if (one) this.instruments.set(name, {...one, last: {t_s: one.last?.t_s ?? this.state?.t_s ?? 0, text}});
      }
    }
    this.lamp = await this.ask("lamp");
    this.changed();
  }

  /** A slow answer about this run; null where none came. */
  private async ask(what: string): Promise<any> {
    const reply = await read(address_of(`api/runs/${encodeURIComponent(this.hello.run.id)}/${what}`)).catch(() => null);
    return reply?.ok ? reply.json().catch(() => null) : null;
  }

  follow(surface: Surface | null): void {
    if (surface !== this.followed) this.maps.wait_no_more();
    this.followed = surface;
    this.send({type: "follow", surface, layer: null});
  }

  /** Sends a command; the answer says whether it was obeyed, also where none came. */
  command(command: string, more: Record<string, unknown> = {}): Promise<Answer> {
    const {id, text} = this.order(command, more);
    if (this.line?.is_open) this.line.send(text);
    else if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(text);
    else return Promise.resolve({id, ok: false, error: "no connection to the print: nothing was sent"});
    return this.answer_to(id);
  }

  /** The stop button went down at `pressed_ms` of performance.now(). Once it was held long enough the stop is sent, and
   *  `ended` gets its answer; null: no line for commands was open. */
  hold_stop(pressed_ms: number, ended: (answer: Promise<Answer> | null) => void): void {
    const {id, text} = this.order("safe_stop");
    this.line?.press(pressed_ms, text, sent => ended(sent ? this.answer_to(id) : null));
  }

  release_stop(at_ms: number): void {
    this.line?.release(at_ms);
  }

  private order(command: string, more: Record<string, unknown> = {}): {id: number; text: string} {
    const id = this.next_id++;
    return {id, text: JSON.stringify({type: "command", id, token: token() ?? undefined, command, ...more})};
  }

  private answer_to(id: number): Promise<Answer> {
    return new Promise(resolve => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        resolve({id, ok: false, error: `no answer within ${kAnswer_ms / 1000} s: it may not have been obeyed`});
      }, kAnswer_ms);
      this.waiting.set(id, answer => {
        clearTimeout(timer);
        if (!answer.ok && /token/i.test(answer.error ?? "")) forget();
        else this.open_line();
        resolve(answer);
      });
    });
  }

  private send(message: object): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private path(way: string): string {
    return `${way}?run=${encodeURIComponent(this.hello.run.id)}`;
  }

  /** Opens the line for commands, if there is a token and it is not open. */
  private open_line(): void {
    const secret = token() ?? (is_known() ? "" : null);
    if (secret !== null && !this.closed) this.line?.open(secret);
  }

  private answer_none(): void {
    for (const [id, answered] of this.waiting) answered({id, ok: false, error: "the connection ended before the answer"});
    this.waiting.clear();
    this.changed();
  }

  private connect(): void {
    const socket = new WebSocket(socket_address(this.path("ws")));
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.retries = 0;
      this.connected = true;
      this.refused = null;
      this.was_connected = true;
      if (this.followed) this.follow(this.followed);
      this.open_line();
      this.changed();
    };
    socket.onmessage = event => {
      if (typeof event.data === "string") this.take(parse_message(event.data));
      else this.take_map(event.data);
      this.changed();
    };
    socket.onclose = () => {
      this.connected = false;
      this.line?.close();
      this.answer_none();
      if (this.closed || !this.live) return;
      if (!this.was_connected && this.retries === 0) void this.ask_refusal();
      this.retry_timer = window.setTimeout(() => this.connect(), kRetry_ms[Math.min(this.retries++, kRetry_ms.length - 1)]);
    };
  }

  /** A WebSocket that never opens does not say why. */
  private async ask_refusal(): Promise<void> {
    const refused = await refusal_of_socket(this.path("ws"));
    if (this.connected) return;
    this.refused = refused;
    this.changed();
  }

  private take_hello(hello: Hello): void {
    this.hello = hello;
    this.layers = [...(hello.layers ?? [])].sort((a, b) => a.n - b.n);
    this.events = [...(hello.events ?? [])];
    this.instruments = new Map((hello.instruments ?? []).map(one => [one.name, one]));
    this.estimates = [...(hello.estimates ?? [])];
    this.ending = hello.end ?? null;
    this.take_acknowledged(hello.run.acknowledged ?? []);
    need_no_token(hello.you?.commands === true && !hello.you.needs_token);
    if (hello.state) this.take_state(hello.state);
  }

  take_acknowledged(all: Acknowledged[]): void {
    this.acknowledged = new Map(all.map(one => [one.alarm, one]));
    this.changed();
  }

  private take_map(frame: ArrayBuffer): void {
    this.maps.take_frame(frame);
    if (!this.hello.run.grid && !this.asked_grid) void this.ask_grid();
  }

  /** A print that was opened before its first map has no grid yet. */
  private async ask_grid(): Promise<void> {
    this.asked_grid = true;
    const reply = await read(address_of(`api/runs/${encodeURIComponent(this.hello.run.id)}`)).catch(() => null);
    const body = reply?.ok ? await reply.json().catch(() => null) : null;
    this.hello.run.grid = body?.run?.grid ?? null;
    this.asked_grid = false;
    this.maps.changed();
  }

  private take_setting(key: string, value: unknown): void {
    for (const one of [...this.hello.run.settings, ...this.hello.commands.in_flight]) if (one.key === key) one.value = value;
  }

  private take_state(state: PrintState): void {
    this.state = state;
    this.state_at_ms = performance.now();
  }

  private take(message: ServerMessage | null): void {
    if (!message) return;
    switch (message.type) {
      case "hello":
        return this.take_hello(message);
      case "state":
        return this.take_state(message);
      case "layer":
        put(this.layers, message);
        this.maps.layer_done(message.n + 1, null);  // its plan
        this.maps.layer_done(message.n, this.followed);
        return;
      case "event":
        return put(this.events, message);
      case "instrument":
        this.instruments.set(message.name, message);
        return;
      case "estimate":
        this.estimates.push(message);
        return;
      case "setting":
        return this.take_setting(message.key, message.value);
      case "end":
        this.ending = message;
        return;
      case "acknowledged":
        return this.take_acknowledged(message.alarms);
      case "answer":
        if (message.id != null) this.waiting.get(message.id)?.(message);
        if (message.id != null) this.waiting.delete(message.id);
        return;
      case "error":
        this.trouble = message.error;
        return;
      case "pong":
        return;
    }
  }
}

/** Puts an item into a list in order of n; a number that is there already is replaced. */
function put<T extends {n: number}>(list: T[], item: T): void {
  let at = list.length;
  while (at > 0 && list[at - 1].n > item.n) --at;
  if (at > 0 && list[at - 1].n === item.n) list[at - 1] = item;
  else list.splice(at, 0, item);
}
