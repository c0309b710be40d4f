// A section through the shown map, with the target beside a measured height.

import {html} from "htm/preact";
import {useMemo} from "preact/hooks";
import {section} from "../data/maps";
import {kSurfaceWords} from "../data/protocol";
import type {Session} from "../data/session";
import {view} from "../data/view";
import {number, unit_words} from "../data/words";
import {Plot, type Curve} from "../draw/plot";
import type {ShownMap} from "./shown_map";

type Cell = [number, number];

export function Section({session, shown, cut}: {session: Session; shown: ShownMap; cut: [Cell, Cell]}) {
  const [a, b] = cut;
  const height = view.surface === "measured" || view.surface === "truth" || view.surface === "predicted";
  const target = height ? session.maps.get("target", shown.map!.layer) : null;
  const data = useMemo(() => {
    const values = section(shown.map!, a, b, shown.grid);
    const rows: (number | null)[][] = [values.along_mm, values.values];
    if (target) rows.push(section(target, a, b, shown.grid).values);
    return rows;
  }, [shown.map, target, a[0], a[1], b[0], b[1]]);
  const name = view.surface === "difference" ? "difference" : kSurfaceWords[view.surface];
  const curves: Curve[] = [{label: name, colour: "one"}];
  if (target) curves.push({label: "target", colour: "two", dash: [6, 4]});
  const length = data[0][data[0].length - 1] as number;
  return html`
    <div class="section">
      <div class="row head">
        <h3>Section from A (${a[0]}, ${a[1]}) to B (${b[0]}, ${b[1]}), ${number(length)} mm</h3>
        <button type="button" onClick=${() => { view.cut = null; view.changed(); }}>Remove</button>
      </div>
      <${Plot} words=${`${name} along a section of ${number(length)} mm`} x_label="mm from A" y_label=${unit_words(shown.unit) || name}
        curves=${curves} data=${data} height=${190} />
    </div>`;
}
