// Messages between the process `page` and the browser, protocol version 1.

export * from "../generated/protocol";
import type {Phase, Surface, Weight} from "../generated/protocol";

export interface Grid {
  nx: number;
  ny: number;
  pitch_mm: number;
  pitch_y_mm?: number;  // pitch_mm without it
  x0_mm: number;
  y0_mm: number;
}

export interface Setting {
  key: string;
  value: unknown;
  unit?: string | null;
  default?: unknown;
}

export interface Note {
  time_utc: string;  // empty: an older program kept none
  author: string;
  text: string;
}

export type Meta = Record<string, string | number | boolean>;

export interface RunSummary {
  id: string;  // address: number of the run and its place
  label?: string;  // name of its folder, with the place where several have the name
  lab: string;
  experiment: string;
  scheme: string;
  seed: number | null;
  layers: number;
  outcome: string | null;
  rms_um: number | null;
  mean_um: number | null;
  height_unit?: string;  // "um" or "mm": as this lab's heights are shown
  state?: string;        // of a print: "running", "paused: the print waits before layer 7, pass 2"
  part?: string | null;  // "cylinder, 10 x 10 x 0.4 mm"
  overspill_percent?: number | null;
  audit?: string | null;
  verdict?: string | null;
  within?: boolean | null;  // the goal was reached; null: not judged
  started_utc: string | null;
  host?: string | null;  // the computer that printed
  meta?: Meta;           // what was printed: [meta] of the experiment
  tags: string[];
  notes: Note[];         // oldest first
  acknowledged?: Acknowledged[];
  live: boolean;
}

export interface RunInfo extends Partial<Omit<RunSummary, "layers">> {
  id: string;
  lab: string;
  experiment: string;
  scheme: string;
  live: boolean;
  finished: boolean;
  simulated: boolean;
  grid: Grid | null;  // null before the first map
  lab_words: string;  // "droplets on a stage"
  deposition: "droplets" | "paths" | "lines";
  amount?: string;  // "droplets", "pulses", "switches"
  trouble?: string;
  layers_planned?: number | null;
  layers_expected?: number | null;
  goal?: {kind: string; value: number | null; unit: string} | null;
  settings: Setting[];
}

export interface Layer {
  n: number;
  t_s: number;
  rms_um: number | null;
  mean_um: number | null;
  max_um: number | null;
  overspill_percent: number | null;  // this and the next five: of the measured surface
  missing_percent?: number | null;   // of the part's volume
  first_ring_um?: number | null;     // mean height of the cells beside the part
  edge_width_um?: number | null;    // from 10 to 90 % of the height
  size_x_um?: number | null;        // error of the width at half height
  size_y_um?: number | null;
  size_cut?: boolean;               // the map's border cuts the surface: the part may be wider
  droplets: number | null;
  predicted_rms_um: number | null;
  measured_rms_um: number | null;
  decision_ms: number | null;
}


export interface PrintEvent {
  n: number;
  t_s: number;
  severity: Weight;
  source: string;
  words: string;
  cause: string | null;
  value: number | string | null;
  limit: number | string | null;
  unit: string | null;
  do: string | null;
  manual: string | null;
  alarm?: string | null;  // name of the alarm that this event is
}

export interface Acknowledged {
  alarm: string;
  author: string;
  time_utc: string;
}

/** Hours that the lamp at the same port was open in the earlier runs of the folder. */
export interface LampHours {
  lamp: string;  // its port; empty: the run has none
  earlier_h: number;
  earlier_runs: number;
}

export interface Instrument {
  name: string;
  kind: string;
  state: string;
  words: string;
  real: boolean;
  link: string;
  last: {t_s: number; text: string} | null;
  faults: number;
  details: [string, unknown, string][];
}

export interface Estimate {
  t_s: number;
  name: string;
  value: number;
  sd: number | null;
  unit: string;
}

export interface InFlight {
  key: string;
  value: unknown;
  min: number | null;
  max: number | null;
  unit: string;
  words: string;
  choices?: string[];
}

export interface Doubt {
  words: string;
  question: string;
  choices: string[];
}

export interface PrintState {
  t_s: number;
  state: Phase;
  words: string;
  layer: number;
  layers: number | null;
  eta_s: number | null;
  ages: Record<string, number | null>;
  paused?: boolean;
  stopping?: boolean;
  doubt?: Doubt | null;
  temperatures?: Record<string, {value: number | null; set: number | null; unit: string}> | null;
  flow?: {value: number; low: number | null; high: number | null; unit: string} | null;
  interval?: Record<string, unknown> | null;
}

export interface Hello {
  type: "hello";
  protocol: number;
  firn: string;
  you?: {name: string | null; commands: boolean; needs_token: boolean};  // whose request it was
  run: RunInfo;
  commands: {allowed: string[]; in_flight: InFlight[]; resume?: boolean};  // resume: this page may, once the run is over
  layers: Layer[];
  events: PrintEvent[];
  instruments: Instrument[];
  estimates: Estimate[];
  state: PrintState | null;
  end?: Ending | null;
}

export interface Ending {
  outcome: string;
  words: string;
  cause: string | null;
  do: string | null;
  manual: string | null;
  by_operator: boolean;
  can_go_on?: boolean;      // some of the layers are not printed
  verdict?: string | null;  // "within tolerance: RMS 3.2 um of the last map, at most 7.6 um"
  within?: boolean | null;
  facts?: string[];  // lines of the result: part, errors, overspill, audit
}

export interface Answer {
  id: number | null;
  ok: boolean;
  error: string | null;
  words?: string | null;
}

export type ServerMessage =
  | Hello
  | ({type: "state"} & PrintState)
  | ({type: "layer"} & Layer)
  | ({type: "event"} & PrintEvent)
  | ({type: "instrument"} & Instrument)
  | ({type: "estimate"} & Estimate)
  | {type: "setting"; key: string; value: unknown}
  | ({type: "end"} & Ending)
  | {type: "acknowledged"; alarms: Acknowledged[]}
  | ({type: "answer"} & Answer)
  | {type: "pong"; id: number; t_s: number}
  | {type: "error"; error: string};

/** The message in a text frame, or null where it is none: a page must outlive a server's mistake. */
export function parse_message(text: string): ServerMessage | null {
  try {
    const message = JSON.parse(text);
    return message && typeof message === "object" && typeof message.type === "string" ? message : null;
  } catch {
    return null;
  }
}

export const kSurfaceWords: Record<Surface, string> = {
  measured: "height",
  target: "target",
  error: "error",
  planned: "next layer's plan",
  predicted: "predicted height",
  truth: "true height",
};
