// The vehicle in its place, with three.js. World axes: x east, y north, z up [m].
'use strict';
/* global THREE */
class World { // eslint-disable-line no-unused-vars
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.02, 200);
    this.camera.up.set(0, 0, 1);
    this.target = new THREE.Vector3(0, 0, 1);
    this.distance = Math.max(2.2, 7 * scene.vehicle.size_m);
    this.azimuth = -1.0;
    this.elevation = 0.42;
    this.follow = true;
    this.colour = (name) => new THREE.Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x667788, 1.0));
    const sun = new THREE.DirectionalLight(0xffffff, 0.6);
    sun.position.set(2, -3, 6);
    this.scene.add(sun);
    const grid = new THREE.GridHelper(10, 20, this.colour('--muted'), this.colour('--line'));
    grid.rotation.x = Math.PI / 2;
    this.scene.add(grid);
    scene.solids.forEach((s) => this.addSolid(s));
    this.addVehicle(scene.vehicle);
    this.planned = this.line('--planned');
    this.flown = this.line('--flown');
    this.listen();
  }

  line(colour) {
    const line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({color: this.colour(colour)}));
    line.frustumCulled = false;
    this.scene.add(line);
    return line;
  }

  setLine(line, points) {
    line.geometry.dispose();
    line.geometry = new THREE.BufferGeometry().setFromPoints(points.map((p) => new THREE.Vector3(p[0], p[1], p[2])));
  }

  // A cylinder of three.js has its axis along y.
  along(mesh, a, b) {
    const from = new THREE.Vector3(...a), to = new THREE.Vector3(...b);
    mesh.position.copy(from).add(to).multiplyScalar(0.5);
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), to.sub(from).normalize());
    return mesh;
  }

  addSolid(s) {
    const material = new THREE.MeshLambertMaterial({color: this.colour('--muted'), transparent: true, opacity: 0.55});
    let mesh;
    if (s.kind === 'box') {
      if (s.b[0] > 5 && s.b[1] > 5) return; // a floor would hide the grid
      mesh = new THREE.Mesh(new THREE.BoxGeometry(...s.b), material);
      mesh.position.set(...s.a);
    } else {
      const length = new THREE.Vector3(...s.b).distanceTo(new THREE.Vector3(...s.a));
      mesh = this.along(new THREE.Mesh(new THREE.CylinderGeometry(s.radius, s.radius, length, 12), material), s.a, s.b);
    }
    this.scene.add(mesh);
  }

  addVehicle(vehicle) {
    this.body = new THREE.Group();
    this.scene.add(this.body);
    const arm = new THREE.MeshLambertMaterial({color: this.colour('--text')});
    const core = new THREE.Mesh(new THREE.SphereGeometry(0.16 * vehicle.size_m, 20, 14), arm);
    core.scale.z = 0.6;
    this.body.add(core);
    const nose = new THREE.Mesh(new THREE.ConeGeometry(0.06 * vehicle.size_m, 0.22 * vehicle.size_m, 12),
      new THREE.MeshLambertMaterial({color: this.colour('--planned')}));
    nose.rotation.z = -Math.PI / 2;
    nose.position.x = 0.24 * vehicle.size_m;
    this.body.add(nose);
    this.rotors = vehicle.rotors.map((r) => {
      const length = Math.hypot(...r.p);
      if (length > 1e-6)
        this.body.add(this.along(new THREE.Mesh(
          new THREE.CylinderGeometry(0.018 * vehicle.size_m, 0.018 * vehicle.size_m, length, 8), arm), [0, 0, 0], r.p));
      const group = new THREE.Group();
      group.position.set(...r.p);
      const disc = new THREE.Mesh(new THREE.CylinderGeometry(r.radius, r.radius, 0.02 * vehicle.size_m, 28),
        new THREE.MeshLambertMaterial({color: this.colour('--ok'), transparent: true, opacity: 0.75, side: THREE.DoubleSide}));
      const arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 1, 0), new THREE.Vector3(), r.radius,
        this.colour('--text').getHex(), 0.3 * r.radius, 0.2 * r.radius);
      group.add(disc, arrow);
      this.body.add(group);
      return {spec: r, group, disc, arrow};
    });
  }

  // load: thrust over its limit, one a rotor; alpha [rad].
  show(frame) {
    if (!frame.p || frame.p.some((x) => x === null)) return;
    this.body.position.set(...frame.p);
    if (frame.q && frame.q.every((x) => x !== null)) this.body.quaternion.set(frame.q[1], frame.q[2], frame.q[3], frame.q[0]);
    this.rotors.forEach((r, k) => {
      const axis = new THREE.Vector3(...r.spec.axis);
      if (r.spec.tilts && frame.alpha !== null && frame.alpha !== undefined)
        axis.applyAxisAngle(new THREE.Vector3(...r.spec.tilt_axis), frame.alpha);
      r.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis);
      const load = (frame.load || [])[k];
      const name = load >= 0.98 ? '--bad' : load >= 0.85 ? '--warn' : '--ok';
      r.disc.material.color.copy(this.colour(name));
      r.arrow.setLength(Math.max(0.02, 3 * r.spec.radius * (load || 0)), 0.3 * r.spec.radius, 0.2 * r.spec.radius);
    });
  }

  draw() {
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight;
    if (w === 0 || h === 0) return;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== w || size.y !== h) {
      this.renderer.setSize(w, h, false);
      this.camera.aspect = w / h;
      this.camera.updateProjectionMatrix();
    }
    if (this.follow) this.target.lerp(this.body.position, 0.2);
    const c = Math.cos(this.elevation), d = this.distance;
    this.camera.position.set(this.target.x + d * c * Math.cos(this.azimuth), this.target.y + d * c * Math.sin(this.azimuth),
      this.target.z + d * Math.sin(this.elevation));
    this.camera.lookAt(this.target);
    this.renderer.render(this.scene, this.camera);
  }

  listen() {
    const fingers = new Map();
    let spread = 0;
    const between = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    this.canvas.addEventListener('pointerdown', (e) => {
      fingers.set(e.pointerId, {x: e.clientX, y: e.clientY});
      this.canvas.setPointerCapture(e.pointerId);
      if (fingers.size === 2) spread = between();
    });
    this.canvas.addEventListener('pointermove', (e) => {
      const last = fingers.get(e.pointerId);
      if (!last) return;
      if (fingers.size === 1) {
        this.azimuth -= 0.008 * (e.clientX - last.x);
        this.elevation = Math.min(1.5, Math.max(-0.3, this.elevation + 0.008 * (e.clientY - last.y)));
      }
      fingers.set(e.pointerId, {x: e.clientX, y: e.clientY});
      if (fingers.size === 2) {
        const now = between();
        this.zoom(spread / Math.max(1, now));
        spread = now;
      }
    });
    ['pointerup', 'pointercancel'].forEach((n) => this.canvas.addEventListener(n, (e) => fingers.delete(e.pointerId)));
    this.canvas.addEventListener('wheel', (e) => {
      e.preventDefault();
      this.zoom(e.deltaY > 0 ? 1.1 : 1 / 1.1);
    }, {passive: false});
  }

  zoom(factor) {
    this.distance = Math.min(60, Math.max(0.3, this.distance * factor));
  }
}
