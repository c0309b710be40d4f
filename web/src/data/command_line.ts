// The page's side of the line for commands: opens it, once there is a token, and tells it how the stop button is held.

import {hush} from "./observable";
import {LineEnd, type FromLine, type ToLine} from "./line_end";

const kWorker_ms = 3000;  // a worker that is not there by then is done without
const kTell_ms = 20;

export class CommandLine {
  private state: "closed" | "opening" | "open" = "closed";
  private secret: string | null = null;
  private way: ((message: ToLine) => void) | null = null;  // to the worker or, without one, to `own`; null until that is known
  private worker: Worker | null = null;
  private readonly own = new LineEnd(message => this.hear(message));
  private hold: {way: (message: ToLine) => void; pressed_ms: number; timer: number; ended: (sent: boolean) => void} | null = null;

  /** @param heard gets the text of each message; closed: an open line has ended */
  constructor(private readonly address: string, private readonly heard: (text: string) => void, private readonly closed: () => void) {
    const own = (message: ToLine) => this.own.take(message);
    const alone = () => {
      if (this.way) return;
      this.worker?.terminate();
      this.worker = null;
      this.go_by(own);
    };
    let worker: Worker;
    try {
      worker = this.worker = new Worker("line.js");
    } catch {
      alone();
      return;
    }
    setTimeout(alone, kWorker_ms);
    worker.onerror = alone;
    worker.onmessage = ({data}: {data: FromLine}) => {
      if (data.kind === "ready") this.go_by(message => worker.postMessage(message));
      else this.hear(data);
    };
  }

  get is_open(): boolean {
    return this.state === "open";
  }

  open(secret: string): void {
    this.secret = secret;
    if (this.state !== "closed" || !this.way) return;
    this.state = "opening";
    this.way({kind: "open", address: this.address, secret});
  }

  send(text: string): void {
    this.way?.({kind: "send", text});
  }

  close(): void {
    this.way?.({kind: "close"});
    this.state = "closed";
  }

  end(): void {
    this.close();
    this.way = () => {};
    this.worker?.terminate();
  }

  /** The stop button went down at `pressed_ms` of performance.now(). Once it was held long enough `text` is sent by the line;
   *  `ended` hears whether it was, or that no line was open. Nothing is drawn meanwhile. */
  press(pressed_ms: number, text: string, ended: (sent: boolean) => void): void {
    this.let_go();
    const way = this.way ?? (message => this.own.take(message));
    const lasted_ms = () => performance.now() - pressed_ms;
    way({kind: "press", lasted_ms: lasted_ms(), at_ms: Date.now(), text});
    this.hold = {way, pressed_ms, timer: window.setInterval(() => way({kind: "held", lasted_ms: lasted_ms()}), kTell_ms), ended};
    hush(true);
  }

  /** A hold whose end has come already is still heard of. */
  release(at_ms: number): void {
    this.hold?.way({kind: "release", lasted_ms: at_ms - this.hold.pressed_ms});
    this.let_go();
  }

  private let_go(): void {
    clearInterval(this.hold?.timer);
    hush(false);
  }

  private go_by(way: (message: ToLine) => void): void {
    this.way = way;
    if (this.secret !== null) this.open(this.secret);
  }

  private hear(message: FromLine): void {
    if (message.kind === "heard") return this.heard(message.text);
    if (message.kind === "opened") this.state = "open";
    if (message.kind === "closed") {
      const was_open = this.is_open;
      this.state = "closed";
      if (was_open) this.closed();
    }
    if (message.kind !== "ended" || !this.hold) return;
    const {ended} = this.hold;
    this.let_go();
    this.hold = null;
    ended(message.sent);
  }
}
