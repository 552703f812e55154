// Spectra of each direction: one-third octaves against the vibration criteria, densities, cumulative rms.
import {extent, frequencyAxis, legend, log10, logAxis, number, plotArea, tooltip} from '../axes.js';
import {makeChart} from '../charts.js';
import {curveSeries, nearest, points, rows} from './series.js';

const signals = ['floor', 'passive', 'active'];
const widths = {floor: 1.4, passive: 1.4, active: 1.8};

/** The three signals of a kind of spectrum on one axis of the frame, those that there are. */
const present = (spectrum) => signals.filter((name) => spectrum[name]);

function readout(spectrum, c, x, scale, unit) {
  const f = 10 ** x;
  let shown = f;
  const lines = present(spectrum).map((name) => {
    const {f: frequencies, values} = spectrum[name];
    const i = nearest(frequencies, f);
    shown = frequencies[i];
    return {name, colour: c[name], values: [`${number(scale * values[i])} ${unit}`]};
  });
  return `<b>${number(shown)} Hz</b>${rows(lines)}`;
}

/** A grey line for what signals are compared with. */
function reference({name, f, values}, c, scale, type) {
  return curveSeries(name, f, values.map((value) => log10(scale * value)), c.muted, {width: 1, type, z: 1});
}

/** The same with its name behind its end. */
function named(curve, c, scale, type) {
  return {
    ...reference(curve, c, scale, type),
    endLabel: {show: true, formatter: curve.name, color: c.muted, fontSize: 10.5, distance: 3}, labelLayout: {hideOverlap: true},
  };
}

function frame(spectrum, c, {f, y, width, height, scale, unit, right = 14}) {
  const left = 46, top = 30, bottom = 42;
  return {
    grid: plotArea({left, right, top, bottom}),
    xAxis: frequencyAxis(c, ...f, width - left - right),
    yAxis: logAxis(c, ...y, height - top - bottom),
    legend: legend(c, present(spectrum).map((name) => ({name})), width),
    tooltip: tooltip(c, {trigger: 'axis', formatter: (parameters) =>
      readout(spectrum, c, parameters[0].axisValue, scale, unit)}),
    dataZoom: [{type: 'inside', filterMode: 'none', zoomOnMouseWheel: 'ctrl'}],
  };
}

function octaves(axis, criteria, c, range) {
  const spectrum = axis.third_octaves, scale = 1e6;
  return {
    ...frame(spectrum, c, {...range, scale, unit: '\u00b5m/s', right: 42}),
    series: [
      ...criteria.map((curve) => named(curve, c, scale, 'solid')),
      ...present(spectrum).map((name) => ({
        ...curveSeries(name, spectrum[name].f, spectrum[name].values.map((v) => log10(scale * v)), c[name],
          {width: 1.8}),
        step: 'middle',
      })),
    ],
  };
}

function density(axis, models, c, range) {
  const spectrum = axis.density;
  return {
    ...frame(spectrum, c, {...range, scale: 1, unit: ''}),
    series: [
      // Without names: they end in the midst of the curves. The words above the pictures have them.
      ...models.map((curve) => reference(clipped(curve, range.f), c, 1, [4, 3])),
      ...present(spectrum).map((name) => curveSeries(name, spectrum[name].f, spectrum[name].values.map(log10), c[name],
        {width: widths[name] - 0.5})),
    ],
  };
}

/** The part of a curve between two frequencies. */
function clipped({name, f, values}, [low, high]) {
  const kept = f.map((_, i) => i).filter((i) => f[i] >= low && f[i] <= high);
  return {name, f: kept.map((i) => f[i]), values: kept.map((i) => values[i])};
}

function cumulative(axis, c, range) {
  const spectrum = axis.cumulative_rms, scale = 1e3;
  return {
    ...frame(spectrum, c, {...range, scale, unit: 'mm/s\u00b2'}),
    series: present(spectrum).map((name) => ({
      ...curveSeries(name, spectrum[name].f, [], c[name], {width: widths[name]}),
      data: points(spectrum[name].f, spectrum[name].values.map((v) => log10(scale * v))),
    })),
  };
}

/** Common ends of the axes of one kind of spectrum, vertical ones in whole decades, at most so many. */
function ranges(axes, kind, scale, most, extra = []) {
  const curves = axes.flatMap((axis) => present(axis[kind]).map((name) => axis[kind][name]));
  if (!curves.length) return null;
  const [low, high] = extent(...[...curves, ...extra].map(({values}) => values.map((v) => log10(scale * v))));
  const top = Math.ceil(high + 1e-9), y = [Math.max(Math.floor(low), top - most), top];
  // Where everything lies below the picture there is nothing to see.
  const f = extent(...curves.map((curve) => curve.f.filter((_, i) => log10(scale * curve.values[i]) >= y[0])));
  return {f, y};
}

export function spectra(data) {
  const criteria = data.criteria.filter(Boolean), models = data.models.filter(Boolean);
  const densities = ranges(data.axes, 'density', 1, 14), sums = ranges(data.axes, 'cumulative_rms', 1e3, 6);
  // Sums do not change where there is no density.
  if (densities && sums) sums.f = densities.f;
  const kinds = [
    {id: 'fig-octaves', range: ranges(data.axes, 'third_octaves', 1e6, 6), make: (axis, c, range) =>
      octaves(axis, criteria, c, {...range, f: [range.f[0] * 0.89, range.f[1] * 1.12]})},
    {id: 'fig-density', range: densities, make: (axis, c, range) => density(axis, models, c, range)},
    {id: 'fig-cumulative', range: sums, make: cumulative},
  ];
  for (const {id, range, make} of kinds) {
    data.axes.forEach((axis, i) => {
      const element = document.getElementById(`${id}-${i + 1}`);
      if (!element || !range) return;
      makeChart(element, (c, width) => make(axis, c, {...range, width, height: element.clientHeight}));
    });
  }
}
