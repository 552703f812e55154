// Figures of the live page: one-third-octave bands against the criteria, and the last minute of anything.
import {escape, extent, frequencyAxis, legend, linearAxis, log10, logAxis, number, plainLabel, plotArea, tooltip}
  from '../axes.js';
import {makeChart} from '../charts.js';
import {curveSeries, nearest, rows} from '../figures/series.js';

/** A number for prose, whole from ten on. */
export const fewNumbers = (value) => (value < 10 ? value.toFixed(1) : value.toFixed(0));

/** A figure in a place; option(data, c, width, height) makes its chart of what show() is given. */
function figureOf(place, id, height, option) {
  const figure = document.createElement('figure');
  const heading = document.createElement('p');
  heading.className = 'figure-title';
  const chart = document.createElement('div');
  chart.className = 'chart';
  chart.id = id;
  chart.style.height = `${height}px`;
  chart.setAttribute('role', 'img');
  figure.append(heading, chart);
  place.append(figure);
  let data = null, entry = null;
  return {
    show(title, next) {
      data = next;
      figure.hidden = false;
      heading.textContent = title;
      chart.setAttribute('aria-label', title);
      if (entry) entry.redraw();
      else entry = makeChart(chart, (c, width) => option(data, c, width, height));
    },
    hide() {
      figure.hidden = true;
    },
  };
}

const frameColour = (view) => (view.run?.loop === 'passive' ? 'passive' : 'active');

function bandOption({view, axis, limits}, c, width, height) {
  const {bands_hz: f, criteria} = view.history;
  const place = {left: 46, right: 46, top: 30, bottom: 42};
  const micro = (velocity) => velocity.map((v) => log10(1e6 * v));
  const signals = [['floor', axis.floor, c.floor], ['frame', axis.frame, c[frameColour(view)]]].filter(([, s]) => s);
  return {
    grid: plotArea(place),
    xAxis: frequencyAxis(c, 0.89, 90, width - place.left - place.right),
    yAxis: logAxis(c, ...limits, height - place.top - place.bottom),
    legend: legend(c, signals.map(([name]) => ({name}))),
    tooltip: tooltip(c, {trigger: 'axis', formatter: ([{axisValue}]) => {
      const i = nearest(f, 10 ** axisValue);
      return `<b>${number(f[i])} Hz</b>` + rows(signals.map(([name, signal, colour]) =>
        ({name, colour, values: [signal.third_octaves_m_s[i] === null ? '\u2013' : `${number(1e6 * signal.third_octaves_m_s[i])} \u00b5m/s`]})));
    }}),
    series: [
      ...criteria.map(({name, velocity_m_s: velocity}) => ({
        ...curveSeries(name, f, micro(velocity), c.muted, {width: 1, z: 1}),
        endLabel: {show: true, formatter: name, color: c.muted, fontSize: 10.5, distance: 3},
      })),
      ...signals.map(([name, signal, colour]) =>
        ({...curveSeries(name, f, micro(signal.third_octaves_m_s), colour, {width: 2}), step: 'middle'})),
    ],
  };
}

export const bands = {
  make: (place, id) => figureOf(place, id, 300, bandOption),
  /** Ends of the vertical axis in whole decades, the same for all axes: criteria and signals, at most six. */
  range(view) {
    const all = view.axes.flatMap(({floor, frame}) => [floor, frame]).filter(Boolean).map((s) => s.third_octaves_m_s);
    const lines = view.history.criteria.map((criterion) => criterion.velocity_m_s);
    const [low, high] = extent(...[...all, ...lines].map((velocity) => velocity.map((v) => log10(1e6 * v))));
    const top = Math.ceil(high + 1e-9);
    return [Math.max(Math.floor(low), top - 6), top];
  },
};

function valueAxis(data, values, c, height) {
  if (!data.logarithmic) return linearAxis(c, {min: 0, splitNumber: 4});
  const [low, high] = extent(...values);
  if (!(low <= high)) return logAxis(c, -1, 1, height);
  const top = Math.ceil(high + 1e-9);
  return logAxis(c, Math.max(Math.min(Math.floor(low), top - 1), top - 6), top, height);
}

function historyOption(data, c, width, height) {
  const place = {left: 52, right: 16, top: 30, bottom: 42};
  const values = data.lines.map((line) =>
    line.values.map((v) => (v === null ? null : data.logarithmic ? log10(data.scale * v) : data.scale * v)));
  const [first, last] = [data.time[0] ?? 0, data.time.at(-1) ?? 1];
  const limit = data.limit ?? null;
  const near = limit !== null && values.flat().some((v) => v > limit / 2);
  return {
    grid: plotArea(place),
    xAxis: linearAxis(c, {min: Math.min(first, Math.max(last - 10, 0)), max: last, name: data.timeName ?? 'time, s',
      nameLocation: 'middle', nameGap: 25, splitNumber: 6,
      axisLabel: {formatter: plainLabel, showMinLabel: false, showMaxLabel: false}}),
    yAxis: valueAxis(data, values, c, height - place.top - place.bottom),
    legend: data.lines.length > 1 ? legend(c, data.lines.map(({name}) => ({name}))) : undefined,
    tooltip: tooltip(c, {trigger: 'axis', formatter: ([{axisValue, dataIndex}]) =>
      `<b>${escape(number(axisValue, 4))} s</b>` + rows(data.lines.map((line) => ({name: line.name, colour: c[line.colour],
        values: [`${number(line.values[dataIndex] === null ? null : data.scale * line.values[dataIndex])} ${data.unit}`]})))}),
    series: data.lines.map((line, i) => ({
      type: 'line', name: line.name, data: data.time.map((t, k) => [t, values[i][k] ?? null]), showSymbol: false,
      symbol: 'none', silent: true, color: c[line.colour], emphasis: {disabled: true}, connectNulls: false,
      lineStyle: {width: 1.6, color: c[line.colour], join: 'round'},
      ...(near && i === 0 ? {markLine: {silent: true, symbol: 'none', lineStyle: {color: c.bad, type: [4, 4], width: 1},
        label: {formatter: 'limit', color: c.bad, position: 'insideEndTop'}, data: [{yAxis: limit}]}} : {}),
    })),
  };
}

export const history = {
  make: (place, id) => figureOf(place, id, 220, historyOption),
};
