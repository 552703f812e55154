// The deck's figure: singular values, predicted and measured, and below them by how much they differ.
import {decibel, extent, frequencyAxis, legend, linearAxis, number, plotArea, tooltip} from '../axes.js';
import {makeChart} from '../charts.js';
import {bandSeries, curveSeries, nearest, pointSeries, rows} from './series.js';

const lowestShown = -80;  // dB; below it lie rounding and noise

function errorBound(data) {
  const [low, high] = extent(...['open_measured', 'closed_measured'].flatMap((key) => data[key]?.difference_db ?? []));
  const largest = Math.max(Math.abs(low), Math.abs(high), 1.25 * (data.allowed_db || 0));
  if (!Number.isFinite(largest) || largest === 0) return 1;
  const step = 10 ** Math.floor(Math.log10(largest));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].map((m) => m * step).find((bound) => bound >= largest * 1.05);
}

function families(c, data) {
  return [
    {name: 'open, predicted', curves: data.open, colour: c.passive},
    {name: 'closed, predicted', curves: data.closed, colour: c.active},
    {name: 'closed, continuous design', curves: data.continuous, colour: c.active, thin: true},
    {name: 'target', curves: data.target.length ? [data.target] : [], colour: c.target, thin: true},
  ].filter(({curves}) => curves.length);
}

function measuredFamilies(c, data) {
  return [
    {name: 'open, measured', measured: data.open_measured, colour: c.passive, symbol: 'circle'},
    {name: 'closed, measured', measured: data.closed_measured, colour: c.active, symbol: 'diamond'},
  ].filter(({measured}) => measured);
}

function readout(data, c, x) {
  const f = 10 ** x;
  const i = nearest(data.f, f);
  const lines = families(c, data).map(({name, curves, colour}) => ({
    name, colour, values: curves.map((curve) => number(decibel(curve[i]), 4)),
  }));
  let shown = data.f[i];
  for (const {name, measured, colour} of measuredFamilies(c, data)) {
    const j = nearest(measured.f, f);
    if (Math.abs(Math.log(measured.f[j] / f)) > 0.04) continue;
    shown = measured.f[j];
    lines.push({name, colour, values: measured.values.map((column) => number(decibel(column[j]), 4))});
    if (measured.lower.length) {
      const half = measured.values.map((_, s) => {
        const low = decibel(measured.lower[s][j]), high = decibel(measured.upper[s][j]);
        if (high === null) return number(null);
        return low === null ? `below ${number(high, 4)}` : number((high - low) / 2, 2);
      });
      lines.push({name: '\u00b1 95 % band', colour: 'transparent', values: half});
    }
    if (measured.difference_db.length) {
      lines.push({name: 'less predicted', colour: 'transparent',
        values: measured.difference_db.map((column) => number(column[j], 2))});
    }
    if (measured.coherence.length) {
      lines.push({name: 'coherence', colour: 'transparent', values: [number(measured.coherence[j], 5)]});
    }
  }
  return `<b>${number(shown, 4)} Hz</b>, dB${rows(lines)}`;
}

function option(data, c, width) {
  const families_ = families(c, data), measured = measuredFamilies(c, data);
  const withError = measured.some((family) => family.measured.difference_db.length);
  const [fLow, fHigh] = extent(data.f, ...measured.map((family) => family.measured.f));
  const [, top] = extent(...families_.flatMap(({curves}) => curves.map((curve) => curve.map(decibel))),
    ...measured.flatMap((family) => family.measured.values.map((column) => column.map(decibel))));
  const bound = errorBound(data);
  const left = 72, right = 26, legendRows = width < 760 ? 2 : 1;
  const head = 12 + 22 * legendRows;
  const place = {left, right, top: head, bottom: 46};
  const grid = withError ? [{...place, bottom: null, height: 380}, {...place, top: head + 404}] : [place];
  const xAxis = grid.map((_, i) => frequencyAxis(c, fLow, fHigh, width - left - right, {
    gridIndex: i, name: i === grid.length - 1 ? 'frequency, Hz' : '', nameGap: 26,
    axisLabel: {show: i === grid.length - 1},
  }));
  const yAxis = [linearAxis(c, {name: 'singular values, dB', nameLocation: 'middle', nameGap: 48, min: lowestShown,
    max: Math.ceil(top / 20) * 20, interval: 20})];
  if (withError) {
    yAxis.push(linearAxis(c, {gridIndex: 1, name: 'error, dB', nameLocation: 'middle', nameGap: 48, min: -bound,
      max: bound, interval: bound / 2}));
  }
  const series = [];
  for (const {name, curves, colour, thin} of families_) {
    for (const curve of curves) {
      series.push(curveSeries(name, data.f, curve.map(decibel), colour,
        thin ? {width: 1, type: [5, 4], z: 2} : {width: 1.8, z: 3}));
    }
  }
  for (const {name, measured: m, colour, symbol} of measured) {
    m.values.forEach((column, s) => {
      if (m.lower.length) series.push(bandSeries(name, m.f, m.lower[s].map(decibel), m.upper[s].map(decibel), colour));
      series.push(pointSeries(name, m.f, column.map(decibel), colour, c.surface, symbol));
    });
    m.difference_db.forEach((column) => series.push({
      ...pointSeries(name, m.f, column, colour, c.surface, symbol, 5), xAxisIndex: 1, yAxisIndex: 1,
    }));
  }
  if (withError && data.allowed_db > 0) {
    series.push({type: 'line', data: [], xAxisIndex: 1, yAxisIndex: 1, silent: true, markArea: {
      silent: true, itemStyle: {color: c.good, opacity: 0.1},
      data: [[{yAxis: -data.allowed_db}, {yAxis: data.allowed_db}]],
    }});
  }
  return {
    grid: grid.map(plotArea), xAxis, yAxis, series,
    legend: legend(c, [...families_.map(({name, thin}) => ({name, key: thin ? 'dashes' : 'line'})),
      ...measured.map(({name, symbol}) => ({name, key: symbol}))], width),
    axisPointer: {link: [{xAxisIndex: 'all'}]},
    tooltip: tooltip(c, {trigger: 'axis', formatter: (parameters) =>
      readout(data, c, (Array.isArray(parameters) ? parameters[0] : parameters).axisValue)}),
    dataZoom: [{type: 'inside', xAxisIndex: grid.map((_, i) => i), filterMode: 'none', zoomOnMouseWheel: 'ctrl'}],
  };
}

export function singularValues(data) {
  const element = document.getElementById('fig-singular-values');
  makeChart(element, (c, width) => option(data, c, width));
}
