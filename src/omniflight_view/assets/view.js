// The page: figures, rotor loads, plots; live frames over a websocket, or a recording under a slider.
'use strict';
/* global Dygraph, World */
(async () => {
  const $ = (id) => document.getElementById(id);
  const KEPT_S = 120; // of a live flight in the plots
  const scene = await (await fetch('/scene.json')).json();
  $('title').textContent = scene.title;
  $('subtitle').textContent = scene.subtitle;
  document.title = scene.title + ' - omniflight view';

  let world = null;
  try {
    world = new World($('world'), scene);
  } catch (e) {
    $('no3d').hidden = false;
    $('world').hidden = true;
  }
  $('follow').addEventListener('click', () => {
    if (!world) return;
    world.follow = !world.follow;
    $('follow').setAttribute('aria-pressed', String(world.follow));
  });

  const bars = scene.vehicle.rotors.map((r, k) => {
    const row = document.createElement('div');
    row.className = 'rotor';
    row.innerHTML = '<b></b><div class="track"><div class="fill"></div></div><span>–</span>';
    row.children[0].textContent = String(k + 1);
    row.title = 'limit ' + r.max_thrust_N.toFixed(2) + ' N';
    $('rotors').append(row);
    return {row, fill: row.querySelector('.fill'), text: row.children[2]};
  });

  const number = (x, digits, unit) => (x === null || x === undefined || Number.isNaN(x) ? '–' : x.toFixed(digits) + ' ' + unit);
  const known = (v) => v && v.length === 3 && v.every((x) => x !== null);
  const off = (f) => (known(f.p) && known(f.ref) ? Math.hypot(f.p[0] - f.ref[0], f.p[1] - f.ref[1], f.p[2] - f.ref[2]) : null);
  const top = (f) => (f.load && f.load.some((x) => x !== null) ? Math.max(...f.load) : null);

  function state(id, words, tone) {
    const e = $(id);
    e.hidden = !words;
    e.textContent = words;
    e.className = 'state ' + tone;
  }

  function show(f) {
    $('time').textContent = number(f.t, 2, 's');
    $('height').textContent = number(known(f.p) ? f.p[2] : null, 3, 'm');
    const e = off(f);
    $('error').textContent = number(e === null ? null : 1000 * e, 1, 'mm');
    $('alpha').textContent = number(f.alpha === null ? null : (180 / Math.PI) * f.alpha, 1, '°');
    $('power').textContent = number(f.power, 0, 'W');
    bars.forEach((b, k) => {
      const load = f.load ? f.load[k] : null;
      b.text.textContent = load === null || load === undefined ? '–' : Math.round(100 * load) + ' %';
      b.fill.style.width = Math.min(100, 100 * (load || 0)) + '%';
      b.row.className = 'rotor' + (load >= 0.98 ? ' full' : load >= 0.85 ? ' high' : '');
    });
    if (world) world.show(f);
  }

  // [title, unit, value of a frame]
  const kinds = [['off the reference', 'mm', (f) => (off(f) === null ? null : 1000 * off(f))],
    ['highest rotor load', '%', (f) => (top(f) === null ? null : 100 * top(f))],
    ['power', 'W', (f) => (f.power === undefined ? null : f.power)]];
  const style = getComputedStyle(document.documentElement);
  const plots = kinds.map(([title, unit, value]) => {
    const heading = document.createElement('p');
    heading.className = 'plottitle';
    heading.textContent = title + ' [' + unit + ']';
    const box = document.createElement('div');
    box.className = 'plot';
    $('plots').append(heading, box);
    return {value, box, rows: [], graph: null, title, now: null};
  });
  function plot(p) {
    if (p.rows.length < 2) return;
    if (p.graph) {
      p.graph.updateOptions({file: p.rows});
      return;
    }
    p.graph = new Dygraph(p.box, p.rows, {
      labels: ['t', p.title], colors: [style.getPropertyValue('--flown').trim()], legend: 'follow', strokeWidth: 1.4,
      axes: {x: {axisLabelFormatter: (t) => t + ' s'}, y: {axisLabelWidth: 42}}, gridLineColor: style.getPropertyValue('--line').trim(),
      axisLineColor: style.getPropertyValue('--line').trim(), includeZero: true, animatedZooms: false,
      underlayCallback: (canvas, area, g) => {
        if (p.now === null) return;
        canvas.fillStyle = style.getPropertyValue('--planned').trim();
        canvas.fillRect(g.toDomXCoord(p.now) - 1, area.y, 2, area.h);
      },
    });
  }

  const flown = [];
  let drawn = 0;
  function animate(ms) {
    if (world) world.draw();
    if (step) step(ms);
    requestAnimationFrame(animate);
  }
  let step = null;

  // ------------------------------------------------------------------ a recording under a slider
  function replay(data) {
    const n = data.t.length;
    const column = (m, i) => (m && m.length ? m.map((c) => c[i]) : null);
    const frame = (i) => ({t: data.t[i], p: column(data.p, i), q: column(data.q, i), ref: column(data.ref, i),
      alpha: data.alpha.length ? data.alpha[0][i] : null, load: column(data.load, i), power: data.power.length ? data.power[0][i] : null});
    plots.forEach((p) => {
      const every = Math.max(1, Math.floor(n / 1500));
      for (let i = 0; i < n; i += every) p.rows.push([data.t[i], p.value(frame(i))]);
      plot(p);
      if (p.graph) p.graph.updateOptions({clickCallback: (e, t) => seek(t)});
    });
    if (world) {
      const points = (m) => data.t.map((t, i) => column(m, i)).filter(known);
      world.setLine(world.planned, data.ref.length ? points(data.ref) : []);
      world.setLine(world.flown, points(data.p));
    }
    let at = 0, playing = false, last = 0;
    const slider = $('slider');
    slider.max = String(n - 1);
    function go(i) {
      at = Math.min(n - 1, Math.max(0, i));
      const whole = Math.floor(at);
      slider.value = String(whole);
      slider.setAttribute('aria-valuetext', data.t[whole].toFixed(2) + ' s');
      show(frame(whole));
      if (world) world.flown.geometry.setDrawRange(0, whole + 1);
      plots.forEach((p) => {
        p.now = data.t[whole];
      });
    }
    function seek(t) {
      let i = 0;
      while (i < n - 1 && data.t[i + 1] <= t) ++i;
      go(i);
      marks();
    }
    const marks = () => plots.forEach((p) => p.graph && p.graph.updateOptions({}));
    slider.addEventListener('input', () => {
      go(Number(slider.value));
      marks();
    });
    function play(on) {
      playing = on;
      $('play').textContent = on ? 'pause' : 'play';
      if (on && at >= n - 1) go(0);
      last = 0;
    }
    $('play').addEventListener('click', () => play(!playing));
    document.addEventListener('keydown', (e) => {
      if (e.target.tagName === 'INPUT' || e.target.tagName === 'BUTTON' || e.target.tagName === 'SELECT') return;
      if (e.key === ' ') play(!playing);
      else if (e.key === 'ArrowRight') go(at + n / 100);
      else if (e.key === 'ArrowLeft') go(at - n / 100);
      else return;
      e.preventDefault();
    });
    step = (ms) => {
      if (playing && last && n > 1) {
        const perSecond = (n - 1) / (data.t[n - 1] - data.t[0]);
        go(at + 0.001 * (ms - last) * Number($('rate').value) * perSecond);
        if (ms - drawn > 250) {
          marks();
          drawn = ms;
        }
        if (at >= n - 1) play(false);
      }
      last = ms;
    };
    state('link', 'recording', 'ok');
    $('replay').hidden = false;
    go(0);
    marks();
    window.omniflightView = {seek, frames: n, scene}; // for tests and the console
  }

  // ------------------------------------------------------------------ live
  let socket = null, stopAsked = 0, gate = '', heard = 0, shown = 0;
  function tone(words) {
    if (/^(nominal|armed|none|ok|fine)/.test(words)) return 'ok';
    return /^(stopped|cut|lost|descend|land)/.test(words) ? 'bad' : 'warn';
  }
  function take(f) {
    if (f.path) {
      if (world) world.setLine(world.planned, f.path);
      return;
    }
    if (f.answer !== undefined) {
      $('stopped').textContent = f.answer;
      return;
    }
    heard = performance.now();
    shown += 1;
    state('link', 'live', 'ok');
    state('failsafe', f.failsafe ? 'failsafe: ' + f.failsafe : '', tone(f.failsafe || ''));
    gate = f.gate || '';
    state('gate', gate ? 'gate: ' + gate : '', tone(gate));
    if (stopAsked && gate.startsWith('stopped')) {
      $('stopped').textContent = 'Rotors stopped (' + gate + ').';
      stopAsked = 0;
    }
    show(f);
    if (flown.length && f.t < flown[flown.length - 1].t) { // another flight began
      flown.length = 0;
      plots.forEach((p) => p.rows.splice(0));
    }
    if (known(f.p)) {
      flown.push({t: f.t, p: f.p});
      if (flown.length > 6000) flown.shift();
      if (world && shown % 5 === 0) world.setLine(world.flown, flown.map((x) => x.p));
    }
    plots.forEach((p) => {
      p.rows.push([f.t, p.value(f)]);
      while (p.rows.length > 2 && p.rows[0][0] < f.t - KEPT_S) p.rows.shift();
      if (shown % 15 === 0) plot(p);
    });
    window.omniflightView = {frames: shown, last: f, scene};
  }
  function connect() {
    socket = new WebSocket('ws://' + location.host + '/', 'omniflight.view.v1');
    socket.onmessage = (e) => take(JSON.parse(e.data));
    socket.onclose = () => {
      state('link', 'connection lost, trying again', 'bad');
      setTimeout(connect, 1000);
    };
    socket.onopen = () => state('link', 'waiting for a flight', 'warn');
  }
  setInterval(() => {
    if (!scene.live || !socket || socket.readyState !== 1) return;
    if (heard && performance.now() - heard > 1500) state('link', 'silent for ' + Math.round((performance.now() - heard) / 1000) + ' s', 'warn');
    if (stopAsked && performance.now() - stopAsked > 3000) $('stopped').textContent = 'NOT acknowledged. Cut the power.';
  }, 250);
  $('stop').addEventListener('click', () => {
    if (!socket || socket.readyState !== 1) {
      $('stopped').textContent = 'NOT said: no connection. Cut the power, or run omniflight estop.';
      return;
    }
    stopAsked = performance.now();
    $('stopped').textContent = 'said, waiting for the gate';
    socket.send(JSON.stringify({wish: 'cut'}));
  });

  requestAnimationFrame(animate);
  if (scene.live) {
    $('stopbar').hidden = !scene.may_stop;
    connect();
  } else {
    replay(await (await fetch('/replay.json')).json());
  }
})().catch((e) => {
  document.getElementById('link').textContent = 'failed: ' + e.message;
});
