// Series that several figures share. Horizontal values are log10 of frequencies in Hz.
import {escape, log10} from '../axes.js';

/** Pairs of log10 f and a value. */
export function points(f, values) {
  return f.map((frequency, i) => [log10(frequency), values[i]]);
}

/** Index of the frequency nearest to f on a logarithmic axis; frequencies rise. */
export function nearest(frequencies, f) {
  let best = 0;
  frequencies.forEach((frequency, i) => {
    if (Math.abs(Math.log(frequency / f)) < Math.abs(Math.log(frequencies[best] / f))) best = i;
  });
  return best;
}

/** A line; values are vertical positions already. */
export function curveSeries(name, f, values, colour, {width = 1.6, type = 'solid', z = 3, ...rest} = {}) {
  return {
    type: 'line', name, data: points(f, values), showSymbol: false, symbol: 'none', z, silent: true, color: colour,
    lineStyle: {width, type, color: colour, cap: 'butt', join: 'round'}, emphasis: {disabled: true}, ...rest,
  };
}

export function pointSeries(name, f, values, colour, ground, symbol = 'circle', size = 6.5) {
  return {
    type: 'scatter', name, data: points(f, values), symbol, symbolSize: symbol === 'diamond' ? size + 1.5 : size, z: 5,
    color: colour, itemStyle: {color: colour, borderColor: ground, borderWidth: 0.9, opacity: 1},
    emphasis: {disabled: true}, silent: true,
  };
}

/** 95 % bands as upright strokes with ends; one without a lower end, of what may be zero, reaches the bottom. */
export function bandSeries(name, f, lower, upper, colour) {
  return {
    type: 'custom', name, z: 4, silent: true, color: colour, encode: {x: 0, y: [1, 2]}, clip: true,
    data: f.map((frequency, i) => [log10(frequency), lower[i], upper[i]]).filter(([, , high]) => high !== null),
    renderItem({coordSys}, api) {
      const x = api.value(0), ends = Number.isFinite(api.value(1));
      const [left, high] = api.coord([x, api.value(2)]);
      const low = ends ? api.coord([x, api.value(1)])[1] : coordSys.y + coordSys.height;
      const style = {stroke: colour, lineWidth: 1.2, fill: null};
      const stroke = (x1, y1, x2, y2) => ({type: 'line', shape: {x1, y1, x2, y2}, style});
      return {type: 'group', children: [stroke(left, low, left, high), stroke(left - 3, high, left + 3, high),
        ...(ends ? [stroke(left - 3, low, left + 3, low)] : [])]};
    },
  };
}

/** Lines of a tooltip, each {name, colour, values}: values are HTML already, names are text. */
export function rows(lines) {
  const cell = (text) => `<td style="text-align:right;padding:0 0 0 10px;border:0">${text}</td>`;
  const key = (colour) => `<span style="display:inline-block;width:10px;height:4px;border-radius:2px;margin-right:6px;` +
    `vertical-align:middle;background:${colour}"></span>`;
  return '<table style="margin:2px 0 0;font-size:12px">' + lines.map(({name, colour, values}) =>
    `<tr><td style="text-align:left;padding:0;border:0">${key(colour)}${escape(name)}</td>` +
    `${values.map(cell).join('')}</tr>`).join('') + '</table>';
}
