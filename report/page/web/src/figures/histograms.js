// How often each duration occurred, counts on a logarithmic axis.
import {linearAxis, logAxis, number, plotArea, powerOfTen, tooltip} from '../axes.js';
import {makeChart} from '../charts.js';

const foot = -0.3;  // half a count: a single one still has a height

function option({edges_us: edges, counts}, c) {
  const top = Math.max(1, Math.ceil(Math.log10(Math.max(...counts, 1))));
  const bars = counts.map((count, i) => [edges[i], edges[i + 1], count]).filter(([, , count]) => count > 0);
  return {
    grid: plotArea({left: 46, right: 14, top: 12, bottom: 42}),
    xAxis: linearAxis(c, {name: '\u00b5s', nameLocation: 'middle', nameGap: 25, min: edges[0], max: edges.at(-1),
      axisLabel: {showMaxLabel: false}}),
    yAxis: logAxis(c, foot, top, 186, {axisTick: {customValues: [...Array(top + 1).keys()]},
      axisLabel: {customValues: [...Array(top + 1).keys()], formatter: (v) => (v < 4 ? String(10 ** v) : powerOfTen(v))}}),
    tooltip: tooltip(c, {trigger: 'item', formatter: ({value}) =>
      `${number(value[0])} to ${number(value[1])} \u00b5s: <b>${value[2]}</b>`}),
    series: [{
      type: 'custom', data: bars, encode: {x: [0, 1], y: 2}, clip: true,
      renderItem(_, api) {
        const [left, high] = api.coord([api.value(0), Math.log10(api.value(2))]);
        const [right, low] = api.coord([api.value(1), foot]);
        return {type: 'rect', shape: {x: left + 0.25, y: high, width: Math.max(1, right - left - 0.5), height: low - high},
          style: {fill: c.active}};
      },
    }],
  };
}

export function histograms(list) {
  list.forEach((histogram, i) => makeChart(document.getElementById(`fig-histogram-${i + 1}`), (c) => option(histogram, c)));
}
