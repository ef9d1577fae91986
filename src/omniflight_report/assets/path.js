// A flight path from above and from the side, coloured by a scalar; equal scales, drag to move, zoom around the pointer.
'use strict';
(() => {
  const {near, onSize, colour, format, make, ramp} = Report;
  const finite = values => values.filter(v => v !== null);
  const extent = (...lists) => {
    let low = Infinity, high = -Infinity;
    for (const list of lists) for (const v of finite(list)) { low = Math.min(low, v); high = Math.max(high, v); }
    return low <= high ? [low, high] : [0, 1];
  };

  function step(pixelsPerMetre) {
    const raw = 64 / pixelsPerMetre, power = Math.pow(10, Math.floor(Math.log10(raw)));
    return [1, 2, 5, 10].map(m => m * power).find(s => s >= raw);
  }

  function buildView(view, data, range, readout, peers) {
    const canvas = view.querySelector('canvas'), across = data[view.dataset.across], up = data[view.dataset.up];
    const refAcross = data.reference[view.dataset.across], refUp = data.reference[view.dataset.up];
    const xs = extent(across, refAcross), ys = extent(up, refUp);
    let scale = 0, home = 0, centre = [0, 0], width = 0, height = 0, marked = -1;
    const toX = x => width / 2 + (x - centre[0]) * scale, toY = y => height / 2 - (y - centre[1]) * scale;

    const fit = () => {
      const w = Math.max(xs[1] - xs[0], 1e-3), h = Math.max(ys[1] - ys[0], 1e-3);
      home = scale = Math.min((width - 70) / w, (height - 60) / h);
      centre = [(xs[0] + xs[1]) / 2, (ys[0] + ys[1]) / 2];
    };
    function grid(context) {
      const s = step(scale), digits = Math.max(0, -Math.floor(Math.log10(s) + 1e-9));
      context.lineWidth = 1; context.font = '11px system-ui, sans-serif'; context.strokeStyle = 'rgba(128,138,150,.22)'; context.fillStyle = colour('--muted');
      context.textAlign = 'center'; context.textBaseline = 'bottom';
      context.beginPath();
      for (let k = Math.ceil((centre[0] - width / 2 / scale) / s); toX(k * s) < width; ++k) {
        context.moveTo(toX(k * s), 0); context.lineTo(toX(k * s), height);
        if (toX(k * s) > 44 && toX(k * s) < width - 130) context.fillText((k * s).toFixed(digits), toX(k * s), height - 3);
      }
      context.textAlign = 'left'; context.textBaseline = 'middle';
      for (let k = Math.ceil((centre[1] - height / 2 / scale) / s); toY(k * s) > 0; ++k) {
        context.moveTo(0, toY(k * s)); context.lineTo(width, toY(k * s));
        if (toY(k * s) < height - 22) context.fillText((k * s).toFixed(digits), 5, toY(k * s) - 7);
      }
      context.stroke();
    }
    function line(context, a, b, style, dashes, thickness) {
      context.setLineDash(dashes); context.strokeStyle = style; context.lineWidth = thickness; context.beginPath();
      let pen = false;
      a.forEach((x, i) => {
        if (x === null || b[i] === null) { pen = false; return; }
        if (pen) context.lineTo(toX(x), toY(b[i])); else context.moveTo(toX(x), toY(b[i]));
        pen = true;
      });
      context.stroke(); context.setLineDash([]);
    }
    function spot(context, i, text, square) {
      const x = toX(across[i]), y = toY(up[i]);
      context.fillStyle = colour('--bg'); context.strokeStyle = colour('--text'); context.lineWidth = 2; context.beginPath();
      if (square) context.rect(x - 4.5, y - 4.5, 9, 9); else context.arc(x, y, 5, 0, 7);
      context.fill(); context.stroke();
      if (!text) return;
      context.fillStyle = colour('--text'); context.font = '600 11.5px system-ui, sans-serif'; context.textAlign = 'left'; context.textBaseline = 'middle';
      context.fillText(text, x + 9, square ? y + 10 : y - 10);
    }
    function draw() {
      const ratio = window.devicePixelRatio || 1;
      canvas.width = width * ratio; canvas.height = height * ratio;
      const context = canvas.getContext('2d');
      context.scale(ratio, ratio);
      grid(context);
      line(context, refAcross, refUp, colour('--muted'), [6, 4], 1.4);
      context.globalAlpha = 0.3; context.lineJoin = 'round'; line(context, data.x.map((x, i) => x === null ? null : across[i]), up, colour('--muted'), [], 4.5); context.globalAlpha = 1;
      context.lineWidth = 3; context.lineCap = 'round';
      const span = range[1] - range[0] || 1;
      for (let i = 1; i < across.length; ++i) {
        if (data.x[i] === null || data.x[i - 1] === null || up[i] === null || up[i - 1] === null || across[i] === null) continue;
        context.strokeStyle = data.v[i] === null ? colour('--muted') : ramp((data.v[i] - range[0]) / span);
        context.beginPath(); context.moveTo(toX(across[i - 1]), toY(up[i - 1])); context.lineTo(toX(across[i]), toY(up[i])); context.stroke();
      }
      const first = data.x.findIndex(x => x !== null), last = data.x.length - 1 - [...data.x].reverse().findIndex(x => x !== null);
      if (first >= 0) { spot(context, last, 'end', true); spot(context, first, 'start', false); }
      if (marked >= 0) spot(context, marked, '', false);
    }
    const zoom = (factor, px, py) => {
      const before = [centre[0] + (px - width / 2) / scale, centre[1] - (py - height / 2) / scale];
      scale = Math.min(Math.max(scale * factor, home / 4), home * 500);
      centre = [before[0] - (px - width / 2) / scale, before[1] + (py - height / 2) / scale];
      draw();
    };
    const show = i => { marked = i; draw(); };
    peers.push(show);

    let drag = null;
    canvas.addEventListener('pointerdown', event => { if (event.pointerType === 'mouse') { drag = [event.offsetX, event.offsetY]; canvas.setPointerCapture(event.pointerId); } });
    canvas.addEventListener('pointerup', () => { drag = null; });
    canvas.addEventListener('pointercancel', () => { drag = null; });
    canvas.addEventListener('pointermove', event => {
      const x = event.offsetX, y = event.offsetY;
      if (drag) { centre = [centre[0] - (x - drag[0]) / scale, centre[1] + (y - drag[1]) / scale]; drag = [x, y]; draw(); return; }
      let best = -1, distance = 20 * 20;
      for (let i = 0; i < across.length; ++i) {
        if (data.x[i] === null || up[i] === null) continue;
        const d = (toX(across[i]) - x) ** 2 + (toY(up[i]) - y) ** 2;
        if (d < distance) { distance = d; best = i; }
      }
      peers.forEach(peer => peer(best));
      readout.textContent = best < 0 ? '' : (data.t.length ? `t ${format(data.t[best])} s, ` : '') +
          `x ${format(data.x[best])}, y ${format(data.y[best])}, z ${format(data.z[best])} m: ${format(data.v[best])}`;
    });
    canvas.addEventListener('pointerleave', () => { readout.textContent = ''; peers.forEach(peer => peer(-1)); });
    canvas.addEventListener('wheel', event => {
      if (!event.ctrlKey && !event.metaKey) return;  // the wheel alone scrolls the page
      event.preventDefault();
      zoom(Math.exp(-event.deltaY / 300), event.offsetX, event.offsetY);
    }, {passive: false});
    canvas.addEventListener('dblclick', () => { fit(); draw(); });
    canvas.title = 'drag to move, Ctrl + wheel to zoom, double-click to reset';
    const tools = make('div', view, 'zoom');
    for (const [text, name, action] of [['+', 'zoom in', () => zoom(1.5, width / 2, height / 2)], ['\u2212', 'zoom out', () => zoom(1 / 1.5, width / 2, height / 2)],
      ['Reset', 'show all', () => { fit(); draw(); }]]) {
      const button = make('button', tools, '', text);
      button.type = 'button'; button.title = name; button.setAttribute('aria-label', name);
      button.addEventListener('click', action);
    }
    onSize(canvas, now => { const first = width !== now; width = now; height = canvas.clientHeight; if (first) fit(); draw(); });
  }

  document.querySelectorAll('figure.path').forEach(figure => near(figure, () => {
    const data = JSON.parse(figure.querySelector('script').textContent), range = extent(data.v), peers = [];
    figure.querySelector('.low').textContent = format(range[0]);
    figure.querySelector('.high').textContent = format(range[1]);
    const readout = figure.querySelector('.readout');
    figure.querySelectorAll('.view').forEach(view => buildView(view, data, range, readout, peers));
  }));
})();
