// Equations of ```math blocks, as KaTeX sets them.
document.addEventListener('DOMContentLoaded', () => {
  for (const block of document.querySelectorAll('.language-math')) {
    const place = document.createElement('div');
    katex.render(block.textContent, place, {displayMode: true, throwOnError: false});
    (block.closest('.highlight') || block).replaceWith(place);
  }
});
