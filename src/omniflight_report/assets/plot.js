// Time and x-y plots on dygraphs. Names never reach dygraphs, which would take them as HTML.
'use strict';
(() => {
  const {near, onSize, colour, format, make} = Report;
  const groups = new Map();

  // One row an x. undefined samples of a series (null) are bridged, gaps (NaN) are not.
  function merge(series, banded) {
    const at = series.map(() => 0), rows = [];
    for (;;) {
      let x = Infinity;
      series.forEach((s, k) => { if (at[k] < s.x.length) x = Math.min(x, s.x[at[k]]); });
      if (x === Infinity) return rows;
      const row = [x];
      series.forEach((s, k) => {
        if (at[k] >= s.x.length || s.x[at[k]] !== x) { row.push(banded ? [null, null, null] : null); return; }
        const i = at[k]++, y = s.y[i] === null ? NaN : s.y[i];
        if (!banded) { row.push(y); return; }
        const low = s.low && s.low[i] !== null ? s.low[i] : y, high = s.high && s.high[i] !== null ? s.high[i] : y;
        row.push([low, y, high]);
      });
      rows.push(row);
    }
  }

  function nearest(rows, x) {
    let low = 0, high = rows.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (rows[middle][0] < x) low = middle; else high = middle; }
    return Math.abs(rows[low][0] - x) < Math.abs(rows[high][0] - x) ? low : high;
  }

  // The value a series shows at x: its own sample there, or the closest one next to it.
  function valueAt(s, x) {
    if (!s.x.length) return null;
    let low = 0, high = s.x.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (s.x[middle] < x) low = middle; else high = middle; }
    return s.y[Math.abs(s.x[low] - x) <= Math.abs(s.x[high] - x) ? low : high];
  }

  function build(figure) {
    const data = JSON.parse(figure.querySelector('script').textContent);
    const chart = figure.querySelector('.chart'), legend = figure.querySelector('.legend');
    const series = data.series, banded = series.some(s => s.low), rows = merge(series, banded);
    if (!rows.length) { make('p', chart, 'footnote', 'No samples to show.'); return; }
    const labels = ['x', ...series.map((s, k) => 's' + k)];
    const group = data.group ? groups.get(data.group) || groups.set(data.group, []).get(data.group) : [];
    const shade = k => `--s${k % 8}`;
    const visible = series.map(() => true), values = [];
    let graph = null;

    series.forEach((s, k) => {
      const button = make('button', legend);
      button.type = 'button';
      button.style.setProperty('--k', `var(${shade(k)})`);
      button.setAttribute('aria-pressed', 'true');
      button.title = 'show or hide';
      make('i', button, s.points ? 'points' : s.dashed ? 'dashed' : '');
      make('span', button, 'name', s.name);
      values.push(make('b', button, '', ''));
      button.addEventListener('click', () => {
        visible[k] = !visible[k];
        button.setAttribute('aria-pressed', String(visible[k]));
        if (graph) graph.setVisibility(k, visible[k]);
      });
    });
    const shown = new Set();
    for (const w of data.windows) {
      const key = w.tone + w.label;
      if (!w.label || shown.has(key)) continue;
      shown.add(key);
      const item = make('span', legend, 'static');
      item.style.setProperty('--k', `var(--${w.tone})`);
      make('i', item, 'span');
      make('span', item, 'name', w.label);
    }
    const at = make('span', legend, 'at', '');

    const point = x => {
      series.forEach((s, k) => { values[k].textContent = x === null ? '' : format(valueAt(s, x)); });
      const match = /^(.*?)\s*\[(.*)\]\s*$/.exec(data.x_label);
      at.textContent = x === null ? '' : match ? `${match[1]} ${format(x)} ${match[2]}` : `x ${format(x)}`;
    };
    const self = {
      select: x => { if (!graph) return; if (x === null) { graph.clearSelection(); point(null); } else { graph.setSelection(nearest(rows, x)); point(x); } },
      zoom: range => { if (graph) graph.updateOptions({dateWindow: range}); },
    };
    group.push(self);
    const others = action => { for (const other of group) if (other !== self) action(other); };

    const shaded = (context, area, g) => {
      for (const w of data.windows) {
        const left = Math.max(area.x, g.toDomXCoord(Math.min(...w.ends))), right = Math.min(area.x + area.w, g.toDomXCoord(Math.max(...w.ends)));
        if (right < area.x || left > area.x + area.w) continue;
        context.globalAlpha = 0.14;
        context.fillStyle = colour(`--${w.tone}`);
        context.fillRect(left, area.y, Math.max(right - left, 1), area.h);
        context.globalAlpha = 0.7;
        context.fillRect(left, area.y, 1.5, area.h);
        context.globalAlpha = 1;
      }
    };
    // Touch: one finger scrolls the page, two fingers zoom.
    const model = Object.assign({}, Dygraph.defaultInteractionModel);
    const touch = model.touchstart;
    model.touchstart = (event, g, context) => { if (event.touches.length > 1) touch(event, g, context); };
    for (const name of ['touchmove', 'touchend']) {
      const original = model[name];
      model[name] = (event, g, context) => { if (context.initialTouches) original(event, g, context); };
    }

    const options = () => ({
      colors: series.map((s, k) => colour(shade(k))),
      series: Object.fromEntries(series.map((s, k) => ['s' + k, {
        strokeWidth: s.points ? 0 : 1.7, drawPoints: s.points, pointSize: s.points ? 1.8 : 1, strokePattern: s.dashed ? [7, 4] : null}])),
      gridLineColor: 'rgba(128,138,150,.22)', axisLineColor: 'rgba(128,138,150,.55)',
    });
    onSize(chart, width => {
      if (graph) { graph.resize(width, chart.clientHeight); graph.updateOptions(options()); return; }
      graph = new Dygraph(chart, rows, Object.assign({
        labels, legend: 'never', customBars: banded, connectSeparatedPoints: true, fillAlpha: 0.2, visibility: visible,
        width, height: chart.clientHeight, highlightCircleSize: 3.5, rightGap: 8, xRangePad: 4, yRangePad: 8, animatedZooms: false,
        axes: {x: {pixelsPerLabel: 70}, y: {axisLabelWidth: 58, pixelsPerLabel: 34, axisLabelFormatter: v => format(v)}},
        interactionModel: model, underlayCallback: shaded,
        highlightCallback: (event, x) => { point(x); others(o => o.select(x)); },
        unhighlightCallback: () => { point(null); others(o => o.select(null)); },
        drawCallback: (g, first) => {
          if (first) return;
          const range = g.xAxisRange();
          if (self.range && range[0] === self.range[0] && range[1] === self.range[1]) return;
          self.range = range;
          if (group.syncing) return;
        group.range = range;
          group.syncing = true;
          others(o => o.zoom(range));
          group.syncing = false;
        },
      }, group.range ? {dateWindow: group.range} : {}, options()));
    });
    chart.title = 'drag to zoom, shift-drag to move, double-click to reset';
  }
  document.querySelectorAll('figure.plot').forEach(figure => near(figure, build));
})();
