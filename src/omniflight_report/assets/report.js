// What every page does: set the equations, follow the table of contents, tell the plots when to draw.
'use strict';
const Report = (() => {
  for (const element of document.querySelectorAll('.equation')) {
    const latex = element.textContent;
    try {
      katex.render(latex, element, {output: 'mathml', displayMode: true, throwOnError: true, trust: false, maxSize: 20, maxExpand: 500});
      element.classList.add('set');
    } catch (error) {
      element.textContent = latex;
      element.title = String(error.message || error);
    }
  }

  const links = new Map([...document.querySelectorAll('.toc a')].map(a => [a.getAttribute('href').slice(1), a]));
  const headings = [...document.querySelectorAll('h2.section')];
  const follow = () => {
    let here = headings[0];
    for (const heading of headings) if (heading.getBoundingClientRect().top < 120) here = heading;
    for (const [id, link] of links) link.classList.toggle('here', here && id === here.id);
  };
  if (links.size) { addEventListener('scroll', follow, {passive: true}); follow(); }

  // What scrolls sideways inside the page can be reached by keyboard.
  const scrolling = new ResizeObserver(entries => {
    for (const {target} of entries)
      if (target.scrollWidth > target.clientWidth || target.scrollHeight > target.clientHeight) target.tabIndex = 0;
      else target.removeAttribute('tabindex');
  });
  for (const element of document.querySelectorAll('.scroll, .equation, .toc ol')) scrolling.observe(element);

  // A table with more columns than the page has room for is set tighter, and if that does not do, as blocks of labelled lines.
  const widths = new Map();
  const room = new ResizeObserver(entries => {
    for (const {target} of entries) {
      if (!target.clientWidth || widths.get(target) === target.clientWidth) continue;
      widths.set(target, target.clientWidth);
      const scroll = target.querySelector('.scroll'), over = () => scroll.scrollWidth > scroll.clientWidth + 1;
      target.classList.remove('tight', 'blocks');
      if (over()) target.classList.add('tight');
      if (over()) target.classList.replace('tight', 'blocks');
    }
  });
  for (const figure of document.querySelectorAll('figure.table.wide')) room.observe(figure);

  // A filter hides the sections behind it, and their entries in the contents, that do not have all words that were typed.
  const filter = document.querySelector('.filter input');
  if (filter) {
    const groups = [];
    for (let node = filter.closest('.filter').nextElementSibling; node; node = node.nextElementSibling) {
      if (node.matches('h2.section')) groups.push({id: node.id, nodes: []});
      if (groups.length) groups.at(-1).nodes.push(node);
    }
    for (const group of groups) group.text = group.nodes.map(node => node.textContent).join(' ').toLowerCase();
    const apply = () => {
      const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      for (const group of groups) {
        const fits = words.every(word => group.text.includes(word));
        shown += fits;
        for (const node of group.nodes) node.hidden = !fits;
        const link = links.get(group.id);
        if (link) link.parentElement.hidden = !fits;
      }
      document.querySelector('.filter output').textContent = shown + ' of ' + groups.length;
    };
    filter.addEventListener('input', apply);
    addEventListener('keydown', event => {
      if (event.key === '/' && document.activeElement !== filter) { event.preventDefault(); filter.focus(); }
    });
    apply();
  }

  // What a browser lays out though it is folded: details hide their content from the eye only.
  const folded = element => element.closest('details:not([open])') !== null;

  // A page of hundreds of plots loads in pieces: a figure is made when the reader comes within two screens of it, or prints.
  const waiting = new Map();
  const make_now = figure => {
    const build = waiting.get(figure);
    waiting.delete(figure);
    if (build) build(figure);
  };
  const approach = new IntersectionObserver(entries => {
    for (const {target, isIntersecting} of entries)
      if (isIntersecting && !folded(target)) { approach.unobserve(target); make_now(target); }
  }, {rootMargin: '200% 0%'});
  const near = (figure, build) => { waiting.set(figure, build); approach.observe(figure); };
  addEventListener('beforeprint', () => [...waiting.keys()].filter(figure => !folded(figure)).forEach(make_now));

  // Plots are drawn when they have a width (not inside folded details), again when it changes, and in new colours
  // when the theme changes. Paper has a width of its own, which only the print events announce.
  const redraws = [];
  let paper = false;
  const onSize = (element, draw) => {
    let width = 0;
    const run = force => {
      const now = element.clientWidth;
      if (now > 0 && !folded(element) && (force || now !== width)) { width = now; draw(now); }
    };
    redraws.push(run);
    new ResizeObserver(() => { if (!paper) run(false); }).observe(element);
    run(false);
  };
  const redraw = () => redraws.forEach(run => run(true));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  addEventListener('beforeprint', () => { paper = true; document.querySelector('main').style.width = '680px'; redraw(); });
  addEventListener('afterprint', () => { paper = false; document.querySelector('main').style.width = ''; redraw(); });

  const light = {'--s0': '#0072b2', '--s1': '#d55e00', '--s2': '#009e73', '--s3': '#b5559b', '--s4': '#b98500', '--s5': '#3a9fd8',
    '--s6': '#6b6b6b', '--s7': '#7a4a12', '--ok': '#00795a', '--warn': '#a86400', '--bad': '#b8400a', '--unknown': '#5c6773',
    '--text': '#1b2430', '--muted': '#5c6773', '--bg': '#fff'};
  const colour = name => (paper && light[name]) || getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const format = value => {
    if (value === null || value === undefined || !isFinite(value)) return '\u2013';
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(2);
    return String(Number(value.toPrecision(4)));
  };
  const make = (tag, parent, className, text) => {
    const element = document.createElement(tag);
    if (className) element.className = className;
    if (text !== undefined) element.textContent = text;
    parent.appendChild(element);
    return element;
  };
  // The colours of the bar beside a path, share 0 to 1.
  const stops = ['440154', '46327e', '365c8d', '277f8e', '1fa187', '4ac16d', 'a0da39', 'fde725'].map(
      hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16)));
  const ramp = share => {
    const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2), f = at - i;
    return `rgb(${stops[i].map((c, k) => Math.round(c + f * (stops[i + 1][k] - c))).join()})`;
  };

  return {near, onSize, colour, format, make, ramp};
})();
