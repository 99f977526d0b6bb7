/* The 3-D picture of a film, and of a second film as a ghost beside it. Needs THREE and film.js. */
"use strict";

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const colourOf = (name) => new THREE.Color(css(name));

/* Arrows of one colour, of which as many are shown as are needed. They show through bodies: a force is at a surface
 * and points inwards. */
class Arrows {
    constructor(parent, colour) {
        this.material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true, opacity: 0.95 });
        this.colour = colour;
        this.parent = parent;
        this.list = [];
        this.used = 0;
    }

    begin() {
        this.used = 0;
    }

    put(position, force, metresPerNewton, thickness) {
        const length = metresPerNewton * Math.hypot(...force);
        if (!(length > 0.2 * thickness)) return;
        if (this.used === this.list.length) this.list.push(this.make());
        const arrow = this.list[this.used++], head = Math.min(6 * thickness, 0.5 * length);
        arrow.visible = true;
        arrow.position.set(...position);
        arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...force).normalize());
        arrow.children[0].scale.set(thickness, length - head, thickness);
        arrow.children[1].scale.set(head / 2.6, head, head / 2.6);
        arrow.children[1].position.y = length - head;
    }

    make() {
        const arrow = new THREE.Group();
        for (const geometry of [Arrows.shaft, Arrows.head]) arrow.add(new THREE.Mesh(geometry, this.material));
        for (const part of arrow.children) part.renderOrder = 10;
        this.parent.add(arrow);
        return arrow;
    }

    end() {
        for (let k = this.used; k < this.list.length; k++) this.list[k].visible = false;
    }

    recolour() {
        this.material.color = colourOf(this.colour);
    }
}

class Stage {
    constructor(canvas, film, ghost) {
        this.canvas = canvas;
        this.film = film;
        this.ghost = ghost;
        this.quality = 1;
        this.shown = { forces: true, cones: true, points: false, ghost: false, follow: false };
        this.scene = new THREE.Scene();
        this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
        this.camera = new THREE.PerspectiveCamera(35, 1, 0.001, 100);
        this.controls = new THREE.OrbitControls(this.camera, canvas);
        this.controls.enableKeys = false;
        this.controls.addEventListener("change", () => this.invalidate());
        Arrows.shaft = Arrows.shaft || new THREE.CylinderBufferGeometry(1, 1, 1, 12).translate(0, 0.5, 0);
        Arrows.head = Arrows.head || new THREE.ConeBufferGeometry(1, 1, 16).translate(0, 0.5, 0);
        this.build();
        this.reset();
        this.recolour();
        this.watcher = new ResizeObserver(() => this.resize());
        this.watcher.observe(canvas.parentElement);
        this.resize();
    }

    build() {
        const film = this.film;
        this.geometries = film.meshes.map((m) => {
            const geometry = new THREE.BufferGeometry();
            geometry.setAttribute("position", new THREE.BufferAttribute(film.floats(m.positions_at, 3 * m.vertices), 3));
            const normals = new THREE.InterleavedBuffer(new Int8Array(film.bytes, m.normals_at, 4 * m.vertices), 4);
            geometry.setAttribute("normal", new THREE.InterleavedBufferAttribute(normals, 3, 0, true));
            geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(film.bytes, m.indices_at, m.indices), 1));
            geometry.computeBoundingSphere();
            return geometry;
        });
        this.materials = {};
        for (const kind of ["object", "finger", "environment"])
            this.materials[kind] = new THREE.MeshLambertMaterial(kind === "finger"
                ? {} : { transparent: true, opacity: kind === "object" ? 0.82 : 0.45, depthWrite: kind === "object" });
        this.ghostMaterial = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.22, depthWrite: false,
            polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
        this.edgeMaterial = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.55 });
        this.ghostEdges = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.8 });
        this.edges = this.geometries.map((g) => new THREE.EdgesGeometry(g, 35));
        this.bodies = film.bodies.map((b) => this.addBody(b, this.materials[b.kind], this.edgeMaterial, 0));
        this.ghosts = this.ghost ? this.ghost.bodies.map((b, i) => b.track_at === null || b.kind !== "object" ? null
            : this.addBody({ ...b, mesh: film.bodies[i].mesh }, this.ghostMaterial, this.ghostEdges, 1)) : [];
        this.arrows = new Arrows(this.scene, "pinch");
        this.ghostColour = this.ghost ? this.ghost.solver : "quickstep";
        this.ghostArrows = new Arrows(this.scene, this.ghostColour);
        this.cones = [];
        this.dots = [];
        this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 0.75));
        const lamp = new THREE.DirectionalLight(0xffffff, 0.55);
        lamp.position.set(0.6, 0.8, 1);
        this.camera.add(lamp);
        this.scene.add(this.camera);
    }

    addBody(body, material, edges, order) {
        const group = new THREE.Group(), mesh = new THREE.Mesh(this.geometries[body.mesh], material);
        mesh.renderOrder = order;
        group.add(mesh, new THREE.LineSegments(this.edges[body.mesh], edges));
        this.scene.add(group);
        return group;
    }

    recolour() {
        for (const kind in this.materials) this.materials[kind].color = colourOf(kind);
        this.ghostMaterial.color = this.ghostEdges.color = colourOf(this.ghostColour);
        this.edgeMaterial.color = colourOf("ink");
        this.scene.background = colourOf("sky");
        this.palette = Object.fromEntries(["stick", "near", "slip", "yield", "open", "ink"].map((n) => [n, colourOf(n)]));
        this.arrows.recolour();
        this.ghostArrows.recolour();
        this.invalidate();
    }

    /* The object in the middle, its fingers in the picture; of large ones the part that touches. */
    reset() {
        const film = this.film, object = film.bodyCalled("object"), centre = film.pose(object, 0);
        let size = film.radius;
        film.bodies.forEach((b, i) => {
            if (b.kind !== "finger") return;
            const p = film.pose(i, 0), away = Math.hypot(p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]);
            size = Math.max(size, Math.min(away + this.geometries[b.mesh].boundingSphere.radius, 2.2 * film.radius));
        });
        const flat = film.up === "y", direction = flat ? [0.25, 0.2, 1] : [0.75, -1, 0.5];
        /* a sphere of this size touches the picture's edges, and the object is as large or smaller */
        const shown = 0.98 * size;
        this.room = Math.max(0.1 * film.radius, shown - film.radius);
        this.camera.up.set(0, flat ? 1 : 0, flat ? 0 : 1);
        this.camera.near = 0.01 * size;
        this.camera.far = 400 * size;
        this.controls.target.set(centre[0], centre[1], centre[2]);
        const distance = shown / Math.sin(Math.PI / 180 * this.camera.fov / 2);
        this.camera.position.set(...direction).setLength(distance).add(this.controls.target);
        this.camera.updateProjectionMatrix();
        this.followed = this.controls.target.clone();
        this.controls.update();
        if (this.time !== undefined) this.update(this.time);
    }

    /* The part of the screen's dots in a line that are drawn: fewer where there is no time for all. */
    setQuality(part) {
        const quality = Math.max(0.5, part);
        if (quality === this.quality) return;
        this.quality = quality;
        this.resize();
    }

    resize() {
        const box = this.canvas.parentElement.getBoundingClientRect();
        if (!(box.width > 0 && box.height > 0)) return;
        this.renderer.setPixelRatio(this.quality * Math.min(devicePixelRatio, 2));
        this.renderer.setSize(box.width, box.height, false);
        this.camera.aspect = box.width / box.height;
        /* what fits the height of a wide picture fits the width of a tall one */
        this.camera.zoom = Math.min(1, this.camera.aspect);
        this.camera.updateProjectionMatrix();
        this.invalidate();
    }

    /* Turns the picture by angles (rad), as with the mouse. */
    orbit(around, up) {
        const offset = this.camera.position.clone().sub(this.controls.target), axis = this.camera.up;
        const side = axis.clone().cross(offset).normalize();
        const tilt = axis.angleTo(offset) - up;
        if (tilt > 0.05 && tilt < Math.PI - 0.05) offset.applyAxisAngle(side, -up);
        offset.applyAxisAngle(axis, around);
        this.camera.position.copy(this.controls.target).add(offset);
        this.controls.update();
        this.invalidate();
    }

    zoom(factor) {
        this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
        this.controls.update();
        this.invalidate();
    }

    place(group, film, body, frame, part) {
        const a = film.pose(body, frame), b = film.pose(body, part > 0 ? frame + 1 : frame);
        group.position.set(...[0, 1, 2].map((i) => a[i] + part * (b[i] - a[i])));
        group.quaternion.set(a[4], a[5], a[6], a[3]);
        if (part > 0) group.quaternion.slerp(new THREE.Quaternion(b[4], b[5], b[6], b[3]), part);
    }

    placeAll(groups, film, t, visible) {
        const frame = film.frameAt(t), part = film.partAt(frame, t);
        groups.forEach((group, i) => {
            if (!group) return;
            group.visible = visible;
            if (visible) this.place(group, film, i, frame, part);
        });
    }

    coneColour(contact) {
        if (contact.state !== "stick") return this.palette[contact.state];
        const part = Number.isNaN(contact.margin) ? 1 : Math.min(1, Math.max(0, contact.margin / 0.5));
        return this.palette.near.clone().lerp(this.palette.stick, part);
    }

    showContact(k, contact, position) {
        if (k === this.cones.length) {
            const cone = new THREE.Mesh(Stage.cone(), new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.38,
                side: THREE.DoubleSide, depthTest: false }));
            const dot = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 12, 8),
                new THREE.MeshBasicMaterial({ depthTest: false, transparent: true }));
            cone.renderOrder = 5;
            dot.renderOrder = 11;
            this.scene.add(cone, dot);
            this.cones.push(cone);
            this.dots.push(dot);
        }
        const cone = this.cones[k], dot = this.dots[k], h = this.film.cone, w = h * Math.min(contact.friction, 2);
        cone.visible = this.shown.cones && contact.friction > 0;
        dot.visible = this.shown.points;
        for (const thing of [cone, dot]) thing.position.set(...position);
        cone.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...contact.normal));
        cone.scale.set(w, h, w);
        cone.material.color.copy(this.coneColour(contact));
        dot.scale.setScalar(0.025 * this.film.radius);
        dot.material.color.copy(this.palette.ink);
    }

    static cone() {
        if (!Stage.coneShape)
            Stage.coneShape = new THREE.ConeBufferGeometry(1, 1, 32, 1, true).rotateX(Math.PI).translate(0, 0.5, 0);
        return Stage.coneShape;
    }

    /* Between two frames a force goes from one to the other in a straight line. */
    putForces(arrows, film, t, each) {
        const frame = film.frameAt(t), part = film.partAt(frame, t);
        for (let k = 0; k < film.contactCount(frame); k++) {
            const now = film.contact(frame, k), next = part > 0 ? film.sameContact(now, frame + 1) : null;
            const between = (a, b) => [0, 1, 2].map((i) => a[i] + part * (b[i] - a[i]));
            const position = next ? between(now.position, next.position) : now.position;
            const force = next ? between(now.force, next.force) : now.force;
            if (this.shown.forces)
                arrows.put(position, force, this.film.arrow / this.film.largest_force, 0.02 * this.film.radius);
            each(k, now, position);
        }
    }

    follow() {
        const object = this.bodies[this.film.bodyCalled("object")].position;
        if (this.shown.follow && this.followed) {
            const step = object.clone().sub(this.followed);
            this.controls.target.add(step);
            this.camera.position.add(step);
        }
        this.followed = object.clone();
    }

    update(t) {
        this.time = t;
        this.placeAll(this.bodies, this.film, t, true);
        if (this.ghost) this.placeAll(this.ghosts, this.ghost, t, this.shown.ghost);
        this.follow();
        this.arrows.begin();
        this.ghostArrows.begin();
        for (const thing of [...this.cones, ...this.dots]) thing.visible = false;
        this.putForces(this.arrows, this.film, t, (k, contact, position) => this.showContact(k, contact, position));
        if (this.ghost && this.shown.ghost) this.putForces(this.ghostArrows, this.ghost, t, () => {});
        this.arrows.end();
        this.ghostArrows.end();
        this.invalidate();
    }

    /* Draws at the next picture of the screen, once, however often it is asked to. */
    invalidate() {
        if (this.waiting) return;
        this.waiting = requestAnimationFrame(() => {
            this.waiting = 0;
            this.draw();
        });
    }

    draw() {
        this.renderer.render(this.scene, this.camera);
        this.drawn = (this.drawn || 0) + 1;
    }

    close() {
        cancelAnimationFrame(this.waiting);
        this.waiting = 1;
        this.watcher.disconnect();
        this.controls.dispose();
        this.renderer.dispose();
    }
}
