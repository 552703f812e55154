// |T| of each direction, predicted and measured; and of each leg from its actuator to its force sensor.
import {extent, frequencyAxis, legend, log10, logAxis, number, plotArea, tooltip} from '../axes.js';
import {makeChart} from '../charts.js';
import {bandSeries, curveSeries, nearest, pointSeries, rows} from './series.js';

const loops = ['passive', 'active'];

function readout(axis, c, x, names) {
  const f = 10 ** x;
  const lines = [];
  let shown = f;
  for (const loop of loops) {
    if (axis[loop].length) {
      const i = nearest(axis.f, f);
      shown = axis.f[i];
      lines.push({name: `${names[loop]}, predicted`, colour: c[loop], values: [number(axis[loop][i])]});
    }
    const measured = axis[`${loop}_measured`];
    if (!measured) continue;
    const j = nearest(measured.f, f);
    if (Math.abs(Math.log(measured.f[j] / f)) > 0.06) continue;
    const known = measured.lower.length && measured.values[0][j] !== null;
    const band = known ? ` (${number(measured.lower[0][j])} to ${number(measured.upper[0][j])})` : '';
    lines.push({name: names.measured ?? `${names[loop]}, measured`, colour: c[loop], values: [number(measured.values[0][j]) + band]});
    if (measured.coherence.length) {
      lines.push({name: 'coherence', colour: 'transparent', values: [number(measured.coherence[j], 5)]});
    }
  }
  return `<b>${number(shown, 4)} Hz</b>${rows(lines)}`;
}

function option(axis, c, width, range, names) {
  const series = [];
  for (const loop of loops) {
    if (axis[loop].length) {
      series.push(curveSeries(names[loop], axis.f, axis[loop].map(log10), c[loop], {width: 1.8}));
    }
    const measured = axis[`${loop}_measured`];
    if (!measured) continue;
    const symbol = loop === 'active' ? 'diamond' : 'circle';
    if (measured.lower.length) {
      series.push(bandSeries(names[loop], measured.f, measured.lower[0].map(log10), measured.upper[0].map(log10), c[loop]));
    }
    series.push(pointSeries(names[loop], measured.f, measured.values[0].map(log10), c[loop], c.surface, symbol, 5));
  }
  if (series.length) {
    series.push({type: 'line', data: [], silent: true, markLine: {silent: true, symbol: 'none', label: {show: false},
      lineStyle: {color: c.muted, type: 'solid', width: 1}, data: [{yAxis: 0}]}});
  }
  return {
    grid: plotArea({left: 46, right: 16, top: 30, bottom: 42}),
    xAxis: frequencyAxis(c, ...range.f, width - 62),
    yAxis: logAxis(c, ...range.y, 228),
    series,
    legend: legend(c, loops.map((loop) => names[loop]).filter((name) => series.some((one) => one.name === name)).map((name) => ({name})), width),
    tooltip: tooltip(c, {trigger: 'axis', formatter: (parameters) => readout(axis, c, parameters[0].axisValue, names)}),
    dataZoom: [{type: 'inside', filterMode: 'none', zoomOnMouseWheel: 'ctrl'}],
  };
}

function draw(axes, id, names) {
  const measured = axes.flatMap((axis) => loops.map((loop) => axis[`${loop}_measured`])).filter(Boolean);
  const [low, high] = extent(...axes.flatMap((axis) => loops.map((loop) => axis[loop].map(log10))),
    ...measured.map((m) => m.values[0].map(log10)));
  const f = extent(...axes.map((axis) => axis.f), ...measured.map((m) => m.f));
  const range = {f, y: [Math.floor(low), Math.ceil(high)]};
  axes.forEach((axis, i) => {
    makeChart(document.getElementById(`${id}-${i + 1}`), (c, width) => option(axis, c, width, range, names));
  });
}

export const transmissibility = (axes) => draw(axes, 'fig-transmissibility', {passive: 'passive', active: 'active'});
export const fit = (legs) => draw(legs, 'fig-fit',
  {passive: 'scene as it was', active: 'updated scene', measured: 'measured'});
