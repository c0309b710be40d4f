// The end of a line for commands that has the WebSocket and times the hold of the stop button: in a worker, which no drawing
// delays, or in the page's own thread where there is none.

import {HoldClock} from "./hold";

export type ToLine =
  | {kind: "open"; address: string; secret: string}
  | {kind: "close"}
  | {kind: "send"; text: string}
  | {kind: "press"; lasted_ms: number; at_ms: number; text: string}  // at_ms: of Date.now(); text: sent when the hold ends
  | {kind: "held"; lasted_ms: number}
  | {kind: "release"; lasted_ms: number};

export type FromLine =
  | {kind: "ready"}
  | {kind: "opened"}
  | {kind: "closed"}
  | {kind: "heard"; text: string}
  | {kind: "ended"; sent: boolean; at_ms: number};  // a hold; at_ms since the epoch

const kResolution_ms = 1;  // of Date.now(): no hold ends early

export class LineEnd {
  private socket: WebSocket | null = null;
  private text = "";
  private readonly hold = new HoldClock(() => {
    const sent = this.send(this.text);
    this.tell({kind: "ended", sent, at_ms: performance.timeOrigin + performance.now()});
  });

  constructor(private readonly tell: (message: FromLine) => void) {}

  take(message: ToLine): void {
    switch (message.kind) {
      case "open":
        return this.open(message.address, message.secret);
      case "close":
        this.socket?.close();
        this.socket = null;
        return;
      case "send":
        return void this.send(message.text);
      case "press":
        this.text = message.text;
        return this.hold.press(message.lasted_ms + Math.max(0, Date.now() - message.at_ms - kResolution_ms));
      case "held":
        return this.hold.held(message.lasted_ms);
      case "release":
        return this.hold.release(message.lasted_ms);
    }
  }

  private open(address: string, secret: string): void {
    let socket: WebSocket;
    try {
      socket = new WebSocket(address, secret ? ["firn", secret] : ["firn"]);
    } catch {
      return this.tell({kind: "closed"});  // a word that can be no token: the other way says so
    }
    this.socket = socket;
    const tell = (message: FromLine) => {
      if (this.socket === socket) this.tell(message);
    };
    socket.onopen = () => tell({kind: "opened"});
    socket.onclose = () => tell({kind: "closed"});
    socket.onmessage = event => tell({kind: "heard", text: String(event.data)});
  }

  private send(text: string): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(text);
    return true;
  }
}
