// Curves by uPlot, in the page's colours; a click moves the time cursor where the abscissa is the layer.

import {html} from "htm/preact";
import {useEffect, useRef} from "preact/hooks";
import uPlot from "uplot";
import {theme} from "./colours";
import {number} from "../data/words";

export interface Curve {
  label: string;
  colour: string;  // name of a colour of the theme
  dash?: number[];
  points?: boolean;
  band?: boolean;  // fills the area below the curve before it, down to this one
  edge?: boolean;  // the edge of a band, not drawn
}

interface Props {
  words: string;  // for those who do not see it
  x_label: string;
  y_label: string;
  curves: Curve[];
  data: (number | null)[][];
  logarithmic?: boolean;  // the ordinate
  mark?: number | null;
  pick?: (x: number) => void;
  height?: number;
}

export function Plot(props: Props) {
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const now = useRef(props);
  now.current = props;
  const shape = JSON.stringify([props.curves, props.x_label, props.y_label]);

  useEffect(() => {
    const build = () => {
      plot.current?.destroy();
      plot.current = new uPlot(options(box.current!, now), now.current.data as uPlot.AlignedData, box.current!);
    };
    build();
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const sized = new ResizeObserver(() =>
      plot.current?.setSize({width: Math.max(120, box.current!.clientWidth), height: now.current.height ?? 180}));
    sized.observe(box.current!);
    dark.addEventListener("change", build);
    return () => {
      sized.disconnect();
      dark.removeEventListener("change", build);
      plot.current?.destroy();
      plot.current = null;
    };
  }, [shape]);
  useEffect(() => plot.current?.setData(props.data as uPlot.AlignedData), [props.data]);
  useEffect(() => plot.current?.redraw(false), [props.mark]);
  return html`<div class="plot" ref=${box} role="img" aria-label=${props.words}></div>`;
}

const kWhole = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000];  // no layer is half

/** Width of an axis of values [px]: its longest number beside the label. */
function room(_: uPlot, values: string[] | null): number {
  const kDigit_px = 6.5, kMarks_px = 14;
  return Math.max(44, kMarks_px + kDigit_px * Math.max(0, ...(values ?? []).map(value => value.length)));
}

function options(box: HTMLElement, now: {current: Props}): uPlot.Options {
  const axis = (label: string): uPlot.Axis => ({
    label, labelSize: 20, size: 44, stroke: theme("soft"), font: "11px system-ui, sans-serif", labelFont: "11px system-ui, sans-serif",
    grid: {stroke: theme("grid"), width: 1}, ticks: {stroke: theme("grid"), width: 1},
    values: (_, ticks) => ticks.map(tick => tick == null ? "" : number(tick)),
  });
  const {curves, x_label, y_label} = now.current;
  return {
    width: Math.max(120, box.clientWidth),
    height: now.current.height ?? 180,
    cursor: {y: false, drag: {x: false, y: false}},
    legend: {show: curves.length > 1 && !curves.some(curve => curve.band)},
    scales: {x: {time: false}, y: now.current.logarithmic ? {distr: 3} : {}},
    axes: [{...axis(x_label), size: 34, ...(x_label === "layer" ? {incrs: kWhole} : {})}, {...axis(y_label), size: room}],
    series: [
      {label: x_label, value: (_, value) => number(value)},
      ...curves.map((curve): uPlot.Series => ({
        label: curve.label, stroke: curve.edge ? "transparent" : theme(curve.colour), width: 1.75, dash: curve.dash, spanGaps: false,
        points: {show: curve.points ?? false, size: 5}, value: (_, value) => number(value),
      })),
    ],
    bands: curves.flatMap((curve, i): uPlot.Band[] => curve.band ? [{series: [i, i + 1], fill: theme(`${curve.colour}-soft`)}] : []),
    hooks: {
      draw: [plot => {
        const {mark} = now.current;
        if (mark == null) return;
        const x = Math.round(plot.valToPos(mark, "x", true));
        if (x < plot.bbox.left || x > plot.bbox.left + plot.bbox.width) return;
        plot.ctx.save();
        plot.ctx.strokeStyle = theme("accent");
        plot.ctx.lineWidth = 2;
        plot.ctx.setLineDash([]);
        plot.ctx.beginPath();
        plot.ctx.moveTo(x, plot.bbox.top);
        plot.ctx.lineTo(x, plot.bbox.top + plot.bbox.height);
        plot.ctx.stroke();
        plot.ctx.restore();
      }],
      ready: [plot => {
        plot.over.addEventListener("click", () => {
          const at = plot.cursor.idx;
          const x = at == null ? null : now.current.data[0][at];
          if (x != null) now.current.pick?.(x);
        });
      }],
    },
  };
}
