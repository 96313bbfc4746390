// SPDX-License-Identifier: BSD-3-Clause
// runs.html of `hils runs`: the table of finished runs, sorted and filtered, and the two that are ticked side by side. The
// one that was ticked first is A, everywhere on the left. Without a script the plain table stays.
import './runs.css';
import {fixed} from './numbers.ts';
import {differentSettings, figurePairs, matching, sorted, type ListedRun} from './run_pair.ts';

interface Column {
  title: string;
  value: (run: ListedRun) => string | number | undefined;
  cell: (run: ListedRun) => string | Node;
  left?: boolean;
}

function element<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Record<string, string> = {}, ...inside: (string | Node)[]): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...inside);
  return made;
}

const link = (address: string, text: string) => (address ? element('a', {href: address}, text) : '');
const figure = (name: string, digits: number): Pick<Column, 'value' | 'cell'> => ({
  value: (run) => run.figures[name],
  cell: (run) => fixed(run.figures[name] ?? null, digits),
});
const loopDelay = (run: ListedRun) => {
  const us = run.figures['latency_us.sensor_to_control.p99'];
  return us === undefined ? undefined : us / 1000;
};
const lost = (run: ListedRun) => {
  const counts = Object.entries(run.figures).filter(([name]) => /rates\.HIL_\w+\.lost$/.test(name));
  return counts.length ? counts.reduce((sum, [, count]) => sum + count, 0) : undefined;
};
const when = (run: ListedRun) => {
  const date = new Date(run.ended_s * 1000);
  const two = (n: number) => String(n).padStart(2, '0');
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())} ${two(date.getHours())}:${two(date.getMinutes())}`;
};

const kColumns: Column[] = [
  {title: 'Scenario', value: (run) => run.scenario, cell: (run) => run.scenario, left: true},
  {title: 'Verdict', value: (run) => run.verdict, cell: (run) => run.verdict},
  {title: 'Ended', value: (run) => run.ended_s, cell: when},
  {title: 'Folder', value: (run) => run.folder, cell: (run) => link(run.report, run.folder) || run.folder, left: true},
  {title: 'Replay', value: (run) => run.replay, cell: (run) => link(run.replay, 'replay')},
  {title: 'RMS error, m', ...figure('rms_position_m', 3)},
  {title: 'Largest error, m', ...figure('peak_error_m', 3)},
  {title: 'Lost', value: lost, cell: (run) => fixed(lost(run) ?? null, 0)},
  {title: 'Loop 99 %, ms', value: loopDelay, cell: (run) => fixed(loopDelay(run) ?? null, 2)},
  {title: 'Why', value: (run) => run.why, cell: (run) => run.why, left: true},
  {title: 'Controller', value: (run) => run.controller, cell: (run) => run.controller || 'CAS'},
  {title: 'Clock', value: (run) => run.clock, cell: (run) => run.clock},
  {title: 'Seed', value: (run) => run.seed, cell: (run) => String(run.seed)},
];
const kMoods: Record<string, string> = {PASSED: 'good', FAILED: 'bad', INVALID: 'neutral'};

const data = JSON.parse(document.getElementById('runs')!.textContent!) as {folder: string; runs: ListedRun[]};
const ticked: ListedRun[] = [];  // A, B
let order = {column: 2, descending: true};
let onlyDifferent = true;

const search = element('input', {type: 'search', placeholder: 'Filter: words of scenario, folder, verdict, cause', 'aria-label': 'Filter'});
const verdicts = element('select', {'aria-label': 'Verdict'}, ...['', 'PASSED', 'FAILED', 'INVALID'].map((each) =>
  element('option', {value: each}, each || 'every verdict')));
const counted = element('span', {class: 'counted'});
const head = element('tr');
const body = element('tbody');
const beside = element('section', {class: 'beside', 'aria-label': 'Comparison'});

function drawHead(): void {
  head.replaceChildren(element('th', {}, ''), ...kColumns.map((column, i) => {
    const button = element('button', {type: 'button'}, column.title);
    button.onclick = () => {
      order = {column: i, descending: order.column === i ? !order.descending : false};
      draw();
    };
    const sort = order.column !== i ? 'none' : order.descending ? 'descending' : 'ascending';
    return element('th', {'aria-sort': sort, ...(column.left ? {style: 'text-align:left'} : {})}, button);
  }));
}

function rowOf(run: ListedRun): HTMLElement {
  const tick = element('input', {type: 'checkbox', 'aria-label': `compare ${run.folder}`});
  tick.checked = ticked.includes(run);
  tick.onchange = () => {
    const at = ticked.indexOf(run);
    if (at >= 0) ticked.splice(at, 1);
    else ticked.push(run);
    if (ticked.length > 2) ticked.splice(1, 1);  // A stays
    draw();
    if (ticked.length === 2) beside.scrollIntoView();
  };
  const letter = ticked.length > 1 || ticked[0] === run ? ['A', 'B'][ticked.indexOf(run)] ?? '' : '';
  const cells = kColumns.map((column) => {
    const cell = element('td', column.title === 'Why' ? {class: 'why'} : column.left ? {style: 'text-align:left'} : {}, column.cell(run));
    if (column.title === 'Verdict') cell.className = kMoods[run.verdict] ?? '';
    return cell;
  });
  return element('tr', ticked.includes(run) ? {class: 'ticked'} : {}, element('td', {}, tick, letter ? ` ${letter}` : ''), ...cells);
}

function pairTable(caption: string, heads: string[], rows: HTMLElement[]): Node[] {
  const table = element('table', {}, element('thead', {}, element('tr', {}, ...heads.map((each) => element('th', {}, each)))), element('tbody', {}, ...rows));
  return [element('p', {class: 'caption'}, caption), element('div', {class: 'scroll'}, table)];
}

const quoted = (text: string) => (/^[\w./-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

function drawPair(a: ListedRun, b: ListedRun): void {
  const heading = (letter: string, run: ListedRun) =>
    element('p', {}, element('strong', {}, `${letter}: ${run.folder}`), ` · ${run.scenario} · ${run.verdict}${run.why ? ` · ${run.why}` : ''} · `,
      link(run.report, 'report'), ' ', link(run.replay, 'replay'));
  const settings = differentSettings(a, b).map(({name, a: left, b: right}) =>
    element('tr', {}, element('td', {}, name), element('td', {}, left), element('td', {}, right)));
  const number = (value?: number) => (value === undefined ? '–' : String(Number(value.toPrecision(6))));
  const figures = figurePairs(a, b).filter((pair) => !onlyDifferent || !pair.same).map((pair) =>
    element('tr', pair.same ? {class: 'same'} : {}, element('td', {}, pair.name), element('td', {}, number(pair.a)), element('td', {}, number(pair.b)),
      element('td', {}, number(pair.change)), element('td', {}, pair.change_pct === undefined ? '–' : fixed(pair.change_pct, 1))));
  const only = element('input', {type: 'checkbox'});
  only.checked = onlyDifferent;
  only.onchange = () => {
    onlyDifferent = only.checked;
    draw();
  };
  const path = (run: ListedRun) => quoted(run.folder === '.' ? data.folder : `${data.folder}/${run.folder}`);
  beside.replaceChildren(
    element('h2', {}, 'Side by side'), heading('A', a), heading('B', b),
    element('p', {}, 'Replayed together: ', element('code', {}, `hils replay ${path(a)} ${path(b)} --out compared.html`)),
    ...(settings.length
      ? pairTable('What differs in the configuration', ['Key', `A: ${a.folder}`, `B: ${b.folder}`], settings)
      : [element('p', {}, 'The configurations of simulator and controllers are the same.')]),
    element('p', {}, element('label', {}, only, ' only figures that differ')),
    ...pairTable('Figures, by their names in summary.json', ['Figure', `A: ${a.folder}`, `B: ${b.folder}`, 'B − A', '% of A'], figures));
}

function draw(): void {
  drawHead();
  const column = kColumns[order.column]!;
  const shown = sorted(matching(data.runs, search.value, verdicts.value), column.value, order.descending);
  body.replaceChildren(...shown.map(rowOf));
  counted.textContent = `${shown.length} of ${data.runs.length} runs; tick two to compare them`;
  const [a, b] = ticked;
  if (a && b) drawPair(a, b);
  else beside.replaceChildren();
}

search.oninput = draw;
verdicts.onchange = draw;
const main = document.querySelector('main')!;
main.querySelectorAll('.scroll, .caption').forEach((part) => part.remove());  // the plain table
main.append(
  element('div', {class: 'runs-tools'}, search, verdicts, counted), beside,
  element('div', {class: 'scroll'}, element('table', {class: 'runs'}, element('thead', {}, head), body)));
draw();
