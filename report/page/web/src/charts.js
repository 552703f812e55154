// One way to make a chart: the parts of ECharts that are used, colours, print, and the account of what has been drawn.
import {BarChart, CustomChart, LineChart, ScatterChart} from 'echarts/charts';
import {AriaComponent, AxisPointerComponent, DataZoomInsideComponent, DataZoomSliderComponent, GridComponent,
  LegendComponent, MarkAreaComponent, MarkLineComponent, TooltipComponent} from 'echarts/components';
import * as echarts from 'echarts/core';
import {SVGRenderer} from 'echarts/renderers';

import {colours, onScheme, setPaper} from './theme.js';

echarts.use([BarChart, CustomChart, LineChart, ScatterChart, AriaComponent, AxisPointerComponent,
  DataZoomInsideComponent, DataZoomSliderComponent, GridComponent, LegendComponent, MarkAreaComponent,
  MarkLineComponent, TooltipComponent, SVGRenderer]);

export const font = 'system-ui, "Segoe UI", Roboto, "Helvetica Neue", "Noto Sans", "Liberation Sans", Arial, sans-serif';

/** Width in CSS pixels of a figure on A4 paper with the margins of the style sheet. */
const paperWidth = 690;

const charts = [];
const figures = {};

/** What tests and readers' scripts may look at: whether each figure has been drawn. */
window.stillframe = {figures, charts: () => charts.map((entry) => entry.chart)};

/** Announces a figure that will be drawn; drawn(name) says that it has been. */
export function expect(name) {
  figures[name] = false;
}
export function drawn(name) {
  figures[name] = true;
  if (Object.values(figures).every(Boolean)) window.stillframe.drawnAfterMs ??= performance.now();
}

/**
 * Makes a chart in an element. option(c, width, isShown) gives the ECharts option for colours c and a width in pixels;
 * isShown(name) says whether the legend has a series switched on. It is asked again when any of these change. Answers
 * {chart, element, redraw}.
 */
export function makeChart(element, option) {
  const name = element.id;
  expect(name);
  const chart = echarts.init(element, null, {renderer: 'svg'});
  const entry = {chart, element, redraw};
  function redraw() {
    const zoom = chart.getOption()?.dataZoom?.map(({start, end}) => ({start, end}));
    const hidden = chart.getOption()?.legend?.[0]?.selected;
    const c = colours();
    const base = {
      animation: false,
      backgroundColor: 'transparent',
      textStyle: {fontFamily: font, color: c.text},
      aria: {enabled: true, label: {enabled: false}},
    };
    const made = {...base, ...option(c, chart.getWidth(), (series) => hidden?.[series] !== false)};
    if (zoom && made.dataZoom) made.dataZoom = made.dataZoom.map((z, i) => ({...z, ...zoom[i]}));
    if (hidden && made.legend) made.legend = {...made.legend, selected: hidden};
    chart.setOption(made, {notMerge: true});
    chart.getZr().flush();
  }
  chart.on('finished', () => drawn(name));
  chart.on('legendselectchanged', redraw);
  charts.push(entry);
  sizes.observe(element);
  redraw();
  return entry;
}

let printing = false;
const sizes = new ResizeObserver((changes) => {
  if (printing) return;
  for (const {target} of changes) {
    const {chart, redraw} = charts.find(({element}) => element === target);
    if (!target.clientWidth || chart.getWidth() === target.clientWidth) continue;
    chart.resize();
    redraw();
  }
});
onScheme(() => charts.forEach(({redraw}) => redraw()));

const printListeners = new Set();
/** Calls listener(true) before the page goes to paper and listener(false) after. */
export function onPrint(listener) {
  printListeners.add(listener);
}

function resizeAll(width) {
  charts.forEach(({chart, element}) => {
    const share = Number(element.dataset.paperShare ?? 1);
    chart.resize(width ? {width: Math.floor(width * share), silent: true} : {width: 'auto', silent: true});
  });
}

addEventListener('beforeprint', () => {
  printing = true;
  document.querySelectorAll('details').forEach((details) => {
    details.dataset.wasOpen = details.open;
    details.open = true;
  });
  resizeAll(paperWidth);
  setPaper(true);
  printListeners.forEach((listener) => listener(true));
});
addEventListener('afterprint', () => {
  printing = false;
  document.querySelectorAll('details').forEach((details) => {
    details.open = details.dataset.wasOpen === 'true';
  });
  resizeAll(null);
  setPaper(false);
  printListeners.forEach((listener) => listener(false));
});
