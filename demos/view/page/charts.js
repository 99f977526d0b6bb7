/* Charts over time whose cursor is the time that the picture shows. Needs Dygraph and film.js. */
"use strict";

const SERIES = ["--f0", "--f1", "--f2", "--f3", "--f4", "--f5", "--f6", "--f7"];

/* Lengths in the unit that people use for them: the factor and its name. */
function lengthUnit(largest) {
    return largest < 1e-3 ? [1e6, "µm"] : largest < 1 ? [1e3, "mm"] : [1, "m"];
}

function angleUnit(largest) {
    return largest < 1e-3 ? [1e6, "µrad"] : largest < 0.1 ? [1e3, "mrad"] : [1, "rad"];
}

/* Five digits, as readable as they can be; a dash for what does not exist. */
function number(value, digits = 5) {
    if (value === null || value === undefined || Number.isNaN(value)) return "–";
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-3 || size >= 1e5)) {
        const [part, power] = value.toExponential(Math.min(2, digits - 1)).split("e");
        const raised = power.replace("+", "").replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] || "⁻");
        return `${part.replace(/\.?0+$/, "").replace("-", "−")}\u00a0×\u00a010${raised}`;
    }
    return value.toPrecision(digits).replace("-", "−");
}

/* The rows of a chart: a time, and a value of every series. Two films have frames at the same steps, or the ghost's are
 * looked up by time. */
function rows(film, ghost, ofFilm, ofGhost) {
    const list = [];
    for (let k = 0; k < film.frames; k++) {
        const g = ghost && film.time[k] <= ghost.end + 1e-9 ? ghost.frameAt(film.time[k] + 1e-6) : -1;
        list.push([film.time[k], ...ofFilm(k), ...(ghost ? (g >= 0 ? ofGhost(g) : ofGhost(0).map(() => null)) : [])]);
    }
    return list;
}

class Charts {
    constructor(parent, film, ghost, seek) {
        this.parent = parent;
        this.film = film;
        this.seek = seek;
        this.list = [];
        const fingers = film.fingers.map((f) => f.name);
        /* two runs of a hand may press with different links */
        const each = (of, pick) => {
            const places = film.fingers.map((f) => (of ? of.fingers.findIndex((g) => g.name === f.name) : -1));
            return (k) => places.map((i) => (i < 0 ? null : pick(of.finger(i, k))));
        };
        const add = (title, unit, pick, options) => this.add(title, unit, fingers, ghost,
            rows(film, ghost, each(film, pick), ghost && each(ghost, pick)), options);
        add("Normal force", "N", (f) => f.normal, {});
        add("Tangential force", "N", (f) => f.tangential, {});
        add("Margin to slip", "", (f) => (Number.isNaN(f.margin) ? null : f.margin), { valueRange: [-0.03, 1.03] });
        const slips = rows(film, null, each(film, (f) => f.slip)).concat(ghost ? rows(ghost, null, each(ghost, (f) => f.slip)) : []);
        const [bySlip, slipUnit] = lengthUnit(Math.max(...slips.map((r) => Math.max(...r.slice(1)))));
        add("Slip path", slipUnit, (f) => bySlip * f.slip, {});
        this.addMotion(film, ghost);
    }

    addMotion(film, ghost) {
        const object = film.bodyCalled("object");
        const lost = ghost && ghost.motion(object, ghost.frames - 1).moved > 0.5 * film.radius;
        const largest = (what) => {
            let most = 0;
            for (const of of lost || !ghost ? [film] : [film, ghost])
                for (let k = 0; k < of.frames; k++) most = Math.max(most, of.motion(object, k)[what]);
            return most;
        };
        const [factor, unit] = lengthUnit(largest("moved")), [turn, angle] = angleUnit(largest("turned"));
        const pick = (of, what, by) => (k) => [by * of.motion(object, k)[what]];
        const add = (title, name, what, by) => this.add(title, name, ["object"], ghost,
            rows(film, ghost, pick(film, what, by), ghost && pick(ghost, what, by)), { lost });
        add("How far the object has moved", unit, "moved", factor);
        add("How far it has turned", angle, "turned", turn);
    }

    add(title, unit, names, ghost, data, options) {
        if (!names.length) return;
        const figure = document.createElement("figure"), plot = document.createElement("div");
        const cursor = document.createElement("div"), caption = document.createElement("figcaption");
        figure.className = "chart";
        plot.className = "plot";
        cursor.className = "cursor";
        caption.textContent = unit ? `${title}, ${unit}` : title;
        figure.append(caption, plot);
        this.parent.append(figure);
        const labels = ["time", ...names.map((n, i) => `pinch ${i}`), ...(ghost ? names.map((n, i) => `ghost ${i}`) : [])];
        const range = Charts.range(data, names.length, options);
        const graph = new Dygraph(plot, data, {
            labels, height: 150, legend: "never", drawGapEdgePoints: false, interactionModel: {}, strokeWidth: 1.8,
            highlightCircleSize: 0, axisLabelFontSize: 11, xRangePad: 0, rightGap: 8, valueRange: range,
            axes: { y: { axisLabelWidth: 52, pixelsPerLabel: 26, axisLabelFormatter: (v) => Charts.tick(v) },
                x: { pixelsPerLabel: 50, drawGrid: false, axisLabelFormatter: (v) => `${+v.toPrecision(6)} s` } },
            ...this.style(names.length, ghost),
        });
        plot.append(cursor);
        const entry = { graph, plot, cursor, names: names.length, ghost };
        this.list.push(entry);
        this.drag(plot, graph);
    }

    /* Both runs as a whole, unless the ghost has lost the object: what falls would flatten the rest. Nothing here is
     * negative, so that ranges begin at 0; what is constant is not magnified to its rounding. */
    static range(data, count, options) {
        if (options.valueRange) return options.valueRange;
        let high = 0;
        for (const row of data)
            for (let i = 1; i < (options.lost ? 1 + count : row.length); i++) high = Math.max(high, row[i] || 0);
        const top = Math.max(1.08 * high, 0.01);
        return [-0.04 * top, top];
    }

    static tick(v) {
        return Math.abs(v) < 1e-12 ? "0" : number(+v.toPrecision(4), 4).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
    }

    style(count, ghost) {
        const names = ["--ink", ...SERIES], series = {}, colours = [];
        for (let i = 0; i < count * (ghost ? 2 : 1); i++) {
            const own = count === 1 ? (i < count ? "--pinch" : `--${ghost.solver}`) : SERIES[i % count % SERIES.length];
            colours.push(css(own.slice(2)));
            if (i >= count) series[`ghost ${i - count}`] = { strokePattern: [6, 4], strokeWidth: 1.4 };
        }
        return { colors: colours, series, gridLineColor: css("rule"), axisLineColor: css("dim"), names };
    }

    recolour() {
        for (const c of this.list) {
            const { colors, gridLineColor, axisLineColor } = this.style(c.names, c.ghost);
            c.graph.updateOptions({ colors, gridLineColor, axisLineColor });
        }
    }

    /* Pressing or dragging in a chart sets the time. Vertical strokes of a finger still scroll the page. */
    drag(plot, graph) {
        const to = (event) => this.seek(graph.toDataXCoord(event.clientX - plot.getBoundingClientRect().left));
        plot.addEventListener("pointerdown", (event) => {
            if (event.button !== 0) return;
            plot.setPointerCapture(event.pointerId);
            to(event);
        });
        plot.addEventListener("pointermove", (event) => {
            if (event.buttons & 1) to(event);
        });
    }

    update(t) {
        for (const { graph, cursor } of this.list) {
            const area = graph.getArea();
            cursor.style.transform = `translateX(${Math.min(area.x + area.w, Math.max(area.x, graph.toDomXCoord(t)))}px)`;
        }
    }

    resize() {
        for (const { graph } of this.list) graph.resize();
    }

    /* With its size a chart keeps what is drawn in it. */
    keepSize(on) {
        for (const { plot } of this.list) plot.style.width = on ? `${plot.clientWidth}px` : "";
    }

    close() {
        for (const { graph } of this.list) graph.destroy();
    }
}
