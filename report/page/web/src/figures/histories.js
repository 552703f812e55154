// Time histories: one view of time for all of them.
import {legend, linearAxis, number, plainLabel, plotArea, tooltip} from '../axes.js';
import {makeChart} from '../charts.js';
import {decode, polyline, range} from './envelope.js';
import {rows} from './series.js';

const signals = ['floor', 'passive', 'active'];

/** What is seen, s, and the whole run; the charts that follow. */
const view = {from: 0, to: 1, whole: [0, 1], entries: [], pending: false};

function lineSeries(name, envelope, colour, width, axis) {
  return {
    type: 'line', name, data: polyline(envelope, view.from, view.to, width), xAxisIndex: axis, yAxisIndex: axis,
    showSymbol: false, symbol: 'none', silent: true, color: colour, connectNulls: false,
    lineStyle: {width: name === 'active' ? 1.4 : 1, color: colour, join: 'round'}, emphasis: {disabled: true},
  };
}

/** Ends of a vertical axis a little beyond what is drawn, the same up and down where both occur. */
function bounds(envelopes) {
  const ranges = envelopes.map((envelope) => range(envelope, view.from, view.to));
  const low = Math.min(...ranges.map(([l]) => l)), high = Math.max(...ranges.map(([, h]) => h));
  if (!(low <= high)) return {min: -1, max: 1};
  const size = Math.max(Math.abs(low), Math.abs(high)) || 1;
  if (low < 0 && high > 0) return nice(-size, size);
  return nice(low, high === low ? low + size : high);
}

function nice(low, high) {
  const step = niceStep((high - low) / 4);
  return {min: Math.floor(low / step) * step, max: Math.ceil(high / step) * step, interval: step};
}

function niceStep(size) {
  const decade = 10 ** Math.floor(Math.log10(size));
  return [1, 2, 2.5, 5, 10].map((m) => m * decade).find((step) => step >= size * 0.999);
}

function timeAxis(c, i, last) {
  return linearAxis(c, {
    gridIndex: i, min: view.from, max: view.to, name: last ? 'time, s' : '', nameLocation: 'middle', nameGap: 25,
    axisLabel: {show: last, formatter: (t) => plainLabel(Number(t.toFixed(6))), showMinLabel: false,
      showMaxLabel: false}, splitNumber: 10,
  });
}

function valueAt(envelope, time) {
  const i = Math.floor((time - envelope.first) / envelope.part);
  const low = envelope.lower[i], high = envelope.upper[i];
  if (!(low <= high)) return '\u2013';
  return envelope.lower === envelope.upper ? number(low, 4) : `${number(low)} \u2026 ${number(high)}`;
}

function readout(lines, time) {
  return `<b>${time.toFixed(3)} s</b>` + rows(lines.map(({name, envelope, colour}) =>
    ({name, colour, values: [valueAt(envelope, time)]})));
}

/** Panels below each other, each {lines: [{name, envelope, colour}], limit}; they share time. */
function panelOption(c, width, panels, {top, gap, bottom, height, labels}) {
  const stretches = Math.max(200, Math.floor(width - 80));
  const lines = panels.flatMap((panel) => panel.lines);
  const n = panels.length;
  const each = (height - top - bottom - gap * (n - 1)) / n;
  return {
    grid: panels.map((_, i) => plotArea({left: labels ? 96 : 62, right: 18, top: top + i * (each + gap), height: each})),
    xAxis: panels.map((_, i) => timeAxis(c, i, i === n - 1)),
    yAxis: panels.map((panel, i) => linearAxis(c, {
      gridIndex: i, ...(panel.bounds ?? bounds(panel.lines.map(({envelope}) => envelope))),
      ...(labels ? {name: panel.lines[0].name, nameLocation: 'middle', nameGap: 52, nameRotate: 0, nameTruncate: {maxWidth: 58},
        nameTextStyle: {color: c.text, fontSize: 12, align: 'right'}} : {}),
      axisLabel: {showMinLabel: !labels, showMaxLabel: !labels},
    })),
    series: panels.flatMap((panel, i) => panel.lines.map(({name, envelope, colour}) =>
      ({...lineSeries(name, envelope, colour, stretches, i), ...(panel.limit ? limitLine(c, panel.limit) : {})}))),
    axisPointer: {link: [{xAxisIndex: 'all'}]},
    tooltip: tooltip(c, {trigger: 'axis', formatter: (parameters) => readout(lines, parameters[0].axisValue)}),
  };
}

function limitLine(c, limit) {
  return {markLine: {silent: true, symbol: 'none', label: {show: false},
    lineStyle: {color: c.bad, type: [4, 4], width: 1}, data: [{yAxis: limit}, {yAxis: -limit}]}};
}

function axisOption(axis, c, width, height, isShown) {
  const line = (name) => ({name, envelope: axis[name], colour: c[name]});
  const quiet = ['floor', 'active'].filter((name) => axis[name]).map(line);
  const seen = quiet.filter(({name}) => isShown(name));
  const panels = [];
  if (axis.passive) panels.push({lines: [line('passive')]});
  // What the legend has switched off does not set the scale.
  if (quiet.length) panels.push({lines: quiet, bounds: bounds((seen.length ? seen : quiet).map(({envelope}) => envelope))});
  return {
    ...panelOption(c, width, panels, {top: 28, gap: 14, bottom: 42, height}),
    legend: legend(c, signals.filter((name) => axis[name]).map((name) => ({name})), width),
  };
}

function legsOption(legs, c, width, height) {
  // One scale for all legs, so that they can be compared.
  const all = bounds(legs.map(({force}) => force));
  const panels = legs.map(({leg, force, limit_n: limit}) =>
    ({lines: [{name: leg, envelope: force, colour: c.active}], bounds: all,
      limit: limit !== null && limit <= all.max ? limit : null}));
  return panelOption(c, width, panels, {top: 8, gap: 8, bottom: 42, height, labels: true});
}

function show(from, to) {
  const [start, end] = view.whole;
  const length = Math.min(Math.max(to - from, (end - start) * 1e-4), end - start);
  view.from = Math.min(Math.max(from, start), end - length);
  view.to = view.from + length;
  if (view.pending) return;
  view.pending = true;
  requestAnimationFrame(() => {
    view.pending = false;
    view.entries.forEach(({redraw}) => redraw());
  });
}

function zoomAbout(time, factor) {
  show(time - (time - view.from) * factor, time + (view.to - time) * factor);
}

function move(share) {
  const step = share * (view.to - view.from);
  show(view.from + step, view.to + step);
}

const buttons = {
  in: () => zoomAbout((view.from + view.to) / 2, 0.5),
  out: () => zoomAbout((view.from + view.to) / 2, 2),
  left: () => move(-0.5),
  right: () => move(0.5),
  all: () => show(...view.whole),
};

/** Dragging moves, a wheel with Ctrl (which a pinch is, too) zooms about the pointer, a double click shows all. */
function follow({chart, element}) {
  const zr = chart.getZr();
  const timeAt = (x) => chart.convertFromPixel({xAxisIndex: 0}, x);
  let held = null;
  zr.on('mousedown', (event) => { held = {x: event.offsetX, from: view.from, to: view.to}; });
  zr.on('mousemove', (event) => {
    if (!held) return;
    const [left, right] = [view.from, view.to].map((t) => chart.convertToPixel({xAxisIndex: 0}, t));
    const shift = (held.x - event.offsetX) / (right - left) * (held.to - held.from);
    show(held.from + shift, held.to + shift);
  });
  addEventListener('mouseup', () => { held = null; });
  zr.on('dblclick', buttons.all);
  element.addEventListener('wheel', (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoomAbout(timeAt(event.offsetX), 2 ** Math.max(-1, Math.min(1, event.deltaY / 200)));
  }, {passive: false});
}

function decodeAll(data) {
  for (const axis of data.axes) for (const name of signals) axis[name] = decode(axis[name]);
  for (const leg of data.legs) leg.force = decode(leg.force);
  data.legs = data.legs.filter(({force}) => force);
  return [...data.axes.flatMap((axis) => signals.map((name) => axis[name])), ...data.legs.map(({force}) => force)]
    .filter(Boolean);
}

export function histories(data) {
  const envelopes = decodeAll(data);
  view.whole = [Math.min(...envelopes.map(({first}) => first)),
    Math.max(...envelopes.map(({first, part, lower}) => first + part * lower.length))];
  [view.from, view.to] = view.whole;
  const add = (id, option) => {
    const element = document.getElementById(id);
    if (element) view.entries.push(makeChart(element,
      (c, width, isShown) => option(c, width, element.clientHeight, isShown)));
  };
  data.axes.forEach((axis, i) => add(`fig-history-${i + 1}`, (...place) => axisOption(axis, ...place)));
  if (data.legs.length) add('fig-legs', (...place) => legsOption(data.legs, ...place));
  view.entries.forEach(follow);
  document.querySelectorAll('#history-tools button').forEach((button) =>
    button.addEventListener('click', buttons[button.dataset.zoom]));
  window.stillframe.timeView = () => [view.from, view.to];
}
