// Closed surfaces beside each other in one scale, turned together, and paths among solids. One renderer for all views of a page, whose pictures are copied:
// browsers keep about 16 contexts of WebGL at once.
'use strict';
/* global THREE, Report */
(() => {
  const {onSize, colour, format, make, ramp} = Report;
  let renderer = null;
  try {
    renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
  } catch (error) {
    renderer = null;
  }
  const vector = p => new THREE.Vector3(p[0], p[1], p[2]);

  function label(text, at, size) {
    const canvas = document.createElement('canvas'), context = canvas.getContext('2d');
    canvas.width = 256; canvas.height = 64;
    context.font = '600 34px system-ui, sans-serif'; context.fillStyle = colour('--text');
    context.textAlign = 'center'; context.textBaseline = 'middle';
    context.fillText(text, 128, 32);
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(canvas), transparent: true, depthTest: false}));
    sprite.position.copy(at); sprite.scale.set(4 * size, size, 1);
    return sprite;
  }

  function sceneOf(surface, index, all) {
    const scene = new THREE.Scene(), tint = new THREE.Color(colour('--s' + index % 8)), grey = new THREE.Color(colour('--muted'));
    scene.add(new THREE.HemisphereLight(0xffffff, 0x8899aa, 0.95));
    const sun = new THREE.DirectionalLight(0xffffff, 0.45);
    sun.position.set(2, -3, 5);
    scene.add(sun);
    const line = (points, look) => scene.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial(look)));
    const points = surface.points.map(vector);
    if (surface.triangles.length) {
      const corners = [];
      for (const triangle of surface.triangles) for (const i of triangle) corners.push(points[i]);
      const geometry = new THREE.BufferGeometry().setFromPoints(corners);
      geometry.computeVertexNormals();
      scene.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({color: tint, side: THREE.DoubleSide, transparent: true, opacity: 0.72,
        polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1})));
      scene.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 1), new THREE.LineBasicMaterial({color: new THREE.Color(colour('--text'))})));
    } else if (points.length === 2) {
      line(points, {color: tint});
    }
    if (all.sphere > 0) {
      const grid = new THREE.WireframeGeometry(new THREE.SphereGeometry(all.sphere, 24, 12));
      scene.add(new THREE.LineSegments(grid, new THREE.LineBasicMaterial({color: grey, transparent: true, opacity: 0.35})));
    }
    const end = 1.12 * all.largest;
    line([[-end, 0, 0], [end, 0, 0], [0, -end, 0], [0, end, 0], [0, 0, -end], [0, 0, end]].map(vector), {color: grey});
    for (const [name, at] of [['x', [1, 0, 0]], ['y', [0, 1, 0]], ['z', [0, 0, 1]]])
      scene.add(label(all.quantity + name, vector(at).multiplyScalar(1.22 * all.largest), 0.17 * all.largest));
    return scene;
  }

  // A cylinder of three.js has its axis along y.
  const along = new THREE.Vector3(0, 1, 0);
  const shade = (name, opacity) => new THREE.MeshLambertMaterial({color: new THREE.Color(colour(name)), transparent: true, opacity, depthWrite: opacity > 0.9,
    side: THREE.DoubleSide});

  function solidOf(solid) {
    const look = shade(solid.zone ? '--bad' : '--muted', solid.zone ? 0.25 : 0.55);
    if (!solid.rod) {
      const box = new THREE.Mesh(new THREE.BoxGeometry(...solid.b), look);
      box.position.set(...solid.a);
      return box;
    }
    const from = vector(solid.a), way = vector(solid.b).sub(from);
    const rod = new THREE.Mesh(new THREE.CylinderGeometry(solid.radius, solid.radius, way.length(), 12), look);
    rod.position.copy(from).addScaledVector(way, 0.5);
    rod.quaternion.setFromUnitVectors(along, way.normalize());
    return rod;
  }

  function spaceOf(all) {
    const scene = new THREE.Scene();
    scene.add(new THREE.HemisphereLight(0xffffff, 0x8899aa, 0.95));
    const sun = new THREE.DirectionalLight(0xffffff, 0.45);
    sun.position.set(2, -3, 5);
    scene.add(sun);
    all.solids.forEach(solid => scene.add(solidOf(solid)));
    const rotor = shade('--s0', 0.3);
    for (const disc of all.discs) {
      const mesh = new THREE.Mesh(new THREE.CylinderGeometry(disc.radius, disc.radius, 0.04 * disc.radius, 24), rotor);
      mesh.position.set(...disc.center);
      mesh.quaternion.setFromUnitVectors(along, vector(disc.axis));
      scene.add(mesh);
    }
    const path = new THREE.BufferGeometry().setFromPoints(all.path.map(vector)), share = v => v === null ? 0 : (v - all.low) / (all.high - all.low || 1);
    path.setAttribute('color', new THREE.Float32BufferAttribute(all.value.flatMap(v => new THREE.Color(ramp(share(v))).toArray()), 3));
    scene.add(new THREE.Line(path, new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors || true})));
    scene.add(new THREE.Points(path, new THREE.PointsMaterial({vertexColors: THREE.VertexColors || true, size: 0.02 * all.largest})));
    scene.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(all.lines.flat().map(vector)),
      new THREE.LineBasicMaterial({color: new THREE.Color(colour('--text'))})));
    return scene;
  }

  /// Where the camera looks and how far the path reaches from there.
  function measure(all, figure) {
    const box = new THREE.Box3().setFromPoints(all.path.map(vector));
    all.centre = box.getCenter(new THREE.Vector3()).toArray();
    all.largest = 0.5 * box.getSize(new THREE.Vector3()).length() + 2 * Math.max(0.1, ...all.discs.map(disc => disc.radius));
    const known = all.value.filter(v => v !== null);
    all.low = Math.min(...known); all.high = Math.max(...known);
    figure.querySelector('.low').textContent = known.length ? format(all.low) : '';
    figure.querySelector('.high').textContent = known.length ? format(all.high) : '';
  }

  for (const figure of document.querySelectorAll('figure.surfaces, figure.space')) {
    const all = JSON.parse(figure.querySelector('script').textContent), isSpace = figure.classList.contains('space');
    if (isSpace) measure(all, figure);
    const centre = new THREE.Vector3(...(all.centre || [0, 0, 0]));
    if (!renderer) {
      make('p', figure, 'footnote', 'This browser has no WebGL: nothing is drawn in space.');
      continue;
    }
    const look = {azimuth: -0.9, elevation: 0.45, zoom: 1}, draws = [];
    const redraw = () => draws.forEach(draw => draw());
    figure.querySelectorAll('canvas').forEach((canvas, index) => {
      const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
      camera.up.set(0, 0, 1);
      let width = 0, height = 0, scene = null;
      const draw = () => {
        if (!width || !scene) return;
        const distance = 4.1 / look.zoom, c = Math.cos(look.elevation);
        camera.position.set(distance * c * Math.cos(look.azimuth), distance * c * Math.sin(look.azimuth), distance * Math.sin(look.elevation))
            .multiplyScalar(all.largest).add(centre);
        camera.near = 0.01 * all.largest; camera.far = 100 * all.largest;
        camera.aspect = width / height; camera.lookAt(centre); camera.updateProjectionMatrix();
        const ratio = Math.min(window.devicePixelRatio || 1, 2);
        renderer.setPixelRatio(ratio); renderer.setSize(width, height, false);
        renderer.render(scene, camera);
        canvas.width = width * ratio; canvas.height = height * ratio;
        canvas.getContext('2d').drawImage(renderer.domElement, 0, 0);
        figure.dataset.drawn = look.azimuth.toFixed(3) + ' ' + look.elevation.toFixed(3);
      };
      draws.push(draw);
      onSize(canvas, now => { width = now; height = canvas.clientHeight; scene = isSpace ? spaceOf(all) : sceneOf(all.surfaces[index], index, all); draw(); });
      const turn = (across, up) => {
        look.azimuth -= across;
        look.elevation = Math.min(Math.max(look.elevation + up, -1.55), 1.55);
        redraw();
      };
      let from = null;
      canvas.addEventListener('pointerdown', event => { from = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
      canvas.addEventListener('pointermove', event => {
        if (!from) return;
        turn(0.008 * (event.clientX - from[0]), 0.008 * (event.clientY - from[1]));
        from = [event.clientX, event.clientY];
      });
      for (const kind of ['pointerup', 'pointercancel']) canvas.addEventListener(kind, () => { from = null; });
      canvas.addEventListener('wheel', event => {
        if (!event.ctrlKey) return; // the page scrolls
        event.preventDefault();
        look.zoom = Math.min(Math.max(look.zoom * Math.exp(-0.002 * event.deltaY), 0.4), 6);
        redraw();
      }, {passive: false});
      canvas.addEventListener('keydown', event => {
        const steps = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1]}[event.key];
        if (steps) { event.preventDefault(); turn(...steps); }
      });
    });
    make('p', figure, 'footnote', 'Drag or use the arrow keys to turn, Ctrl and wheel to zoom' + (isSpace ? '.' : `; the axes end at ${format(1.12 * all.largest)} ${all.unit}.`));
  }
})();
