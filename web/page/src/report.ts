// SPDX-License-Identifier: BSD-3-Clause
// The plots in reports of hils (report.html, comparison.html, sweep.html, tune.html): each drawing that has its numbers
// beside it becomes a plot: zoom by dragging, one cursor over all that have the same x axis, curves that can be hidden, and
// the distance between two points that were clicked. Without a script the drawings stay.
import 'uplot/dist/uPlot.min.css';
import './report.css';
import uPlot from 'uplot';
import {fixed} from './numbers.ts';
import {measured, type Point} from './measure.ts';
import {decode, type Column} from './series.ts';

interface Curve {
  name: string;
  dashed?: boolean;
  steps?: boolean;
  /** Points without a line between them. */
  dots?: boolean;
  x: Column;
  y: Column;
}

/** As hils/report/plot_data.hpp has it. */
interface PlotData {
  title?: string;
  x_label: string;
  y_label: string;
  log_x?: boolean;
  log_y?: boolean;
  from_zero?: boolean;
  series: Curve[];
  marks?: {x: number; text: string; fault?: boolean}[];
  shaded?: [number, number];
}

const kColours = ['#1c7ed6', '#e8590c', '#2b8a3e', '#9c36b5', '#c92a2a', '#0c8599', '#5c940d', '#862e9c'];

function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Grey for references, so that the flown curve stands out. */
function strokes(curves: Curve[]): string[] {
  let next = 0;
  return curves.map((curve) => (curve.dashed ? colour('--quiet') : kColours[next++ % kColours.length]!));
}

function drawMarks(u: uPlot, data: PlotData): void {
  const {ctx, bbox} = u;
  ctx.save();
  if (data.shaded) {
    const [a, b] = data.shaded.map((x) => Math.max(bbox.left, Math.min(bbox.left + bbox.width, u.valToPos(x, 'x', true)))) as [number, number];
    ctx.globalAlpha = 0.1;
    ctx.fillStyle = kColours[0]!;
    ctx.fillRect(a, bbox.top, b - a, bbox.height);
    ctx.globalAlpha = 1;
  }
  const right = bbox.left + bbox.width;
  const gap = 3 * devicePixelRatio;
  ctx.font = `${10 * devicePixelRatio}px system-ui, sans-serif`;
  let taken = bbox.left;  // where the label before this one ends
  for (const mark of data.marks ?? []) {
    const x = u.valToPos(mark.x, 'x', true);
    if (x < bbox.left || x > right) continue;
    ctx.strokeStyle = ctx.fillStyle = mark.fault ? kColours[4]! : colour('--quiet');
    ctx.lineWidth = 1;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    const width = ctx.measureText(mark.text).width;
    const from = x + gap + width > right ? x - gap - width : x + gap;
    const row = from < taken ? 2 : 1;
    ctx.fillText(mark.text, from, bbox.top + 10 * row * devicePixelRatio);
    if (row === 1) taken = from + width;
  }
  ctx.restore();
}

function makePlot(figure: HTMLElement, data: PlotData): uPlot {
  // A null is a gap; undefined of join(), for the moments of other curves, is none.
  const tables = data.series.map((curve) => [decode(curve.x), Array.from(decode(curve.y), (y) => (Number.isNaN(y) ? null : y))]);
  const colours = strokes(data.series);
  const said = document.createElement('figcaption');
  const says = (text: string) => { said.textContent = text; };
  const hint = 'Drag to zoom, double click for all, click two points to measure between them, click a name to hide its curve.';
  const axis = {stroke: () => colour('--ink'), grid: {stroke: () => colour('--line'), width: 1}, ticks: {show: false}, font: '12px system-ui, sans-serif'};
  let first: Point | undefined;
  const plot = new uPlot({
    title: data.title, width: figure.clientWidth - 12, height: 300, padding: [10, 14, 0, 4],
    cursor: {sync: {key: data.log_x ? `own ${Math.random()}` : data.x_label, scales: ['x', null]}, drag: {x: true, y: false}},
    scales: {
      x: {time: false, distr: data.log_x ? 3 : 1},
      y: {distr: data.log_y ? 3 : 1, range: data.from_zero ? (_, __, max) => [0, max * 1.05 || 1] : undefined},
    },
    axes: [{...axis, label: data.x_label, size: 34, labelSize: 18}, {...axis, label: data.y_label, size: 62, labelSize: 18}],
    series: [{label: data.x_label}, ...data.series.map((curve, i) => ({
      label: curve.name || data.y_label, stroke: colours[i], width: 1.4, dash: curve.dashed ? [5, 4] : undefined, spanGaps: false,
      points: curve.dots ? {show: true, size: 8, fill: colours[i]} : {show: false},
      paths: curve.dots ? () => null : curve.steps ? uPlot.paths.stepped!({align: 1}) : undefined,
    }))],
    hooks: {
      drawClear: [(u) => drawMarks(u, data)],
      ready: [(u) => u.over.addEventListener('click', () => {
        const {left, top} = u.cursor;
        if (left === undefined || top === undefined || left < 0) return;
        const point = {x: u.posToVal(left, 'x'), y: u.posToVal(top, 'y')};
        says(first ? measured(first, point, data.x_label, data.y_label) : `From ${data.x_label} ${fixed(point.x, 3)}, ${data.y_label} ${fixed(point.y, 4)}: click the second point.`);
        first = first ? undefined : point;
      })],
    },
  }, uPlot.join(tables as unknown as uPlot.AlignedData[]), figure);
  figure.append(said);
  says(hint);
  return plot;
}

const plots: [HTMLElement, uPlot][] = [];
for (const block of document.querySelectorAll('script.plot')) {
  const figure = block.parentElement!;
  try {
    plots.push([figure, makePlot(figure, JSON.parse(block.textContent!) as PlotData)]);
    figure.querySelector('svg')?.classList.add('on-paper');
  } catch (error) {
    figure.querySelectorAll('.uplot').forEach((part) => part.remove());
    console.error(error);  // the drawing stays
  }
}
addEventListener('resize', () => {
  for (const [figure, plot] of plots) plot.setSize({width: figure.clientWidth - 12, height: 300});
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => plots.forEach(([, plot]) => plot.redraw(false)));
