"use strict";
// The charts of a run: signals, rotation with release and end as handles, residuals; restitution.

const SIGNALS = ["#555555", "#0072b2"];
const WAIT_MS = 60;  // after the last movement of the window, before finer samples are asked for

class Charts {
  /** styles: looks of the lines by source; moved(release, end): the handles were dragged to these instants [s];
   *  asked(from, to): finer samples are wanted; told(text): what is below the cursor. */
  constructor(styles, {overTime, overSpeed, moved, asked, told}) {
    Object.assign(this, {styles, moved, asked, told, step: 0});
    this.range = new Bokeh.Range1d({start: 0, end: 1});
    this.sources = {};
    this.drawn = {};
    const wide = {sizing_mode: "stretch_width", min_border_left: 64, toolbar_location: null};
    const inTime = (kind, title, y, height, more = {}) => {
      const figure = Bokeh.Plotting.figure({
        css_classes: [kind], title, y_axis_label: y, height, x_range: this.range,
        y_range: new Bokeh.DataRange1d({only_visible: true, range_padding: 0.08}), window_axis: "x",
        tools: "xpan,xwheel_zoom,xbox_zoom", ...wide, ...more});
      figure.toolbar.active_scroll = figure.toolbar.tools[1];
      figure.toolbar.active_drag = figure.toolbar.tools[2];
      return figure;
    };
    this.signals = inTime("signals", "Signal", "output", 150);
    this.theta = inTime("theta", "Rotation: the band’s edges move release and end", "θ / °", 260);
    this.residual = inTime("residual", "Model minus record", "residual / σ", 170, {x_axis_label: "time / s"});
    const flagged = this.source("flagged", ["x0", "x1", "what"]);
    const strips = this.signals.vstrip({field: "x0"}, {field: "x1"}, {source: flagged, fill_color: "#b00020", fill_alpha: 0.25, line_color: null});
    this.signals.add_tools(new Bokeh.HoverTool({renderers: [strips], tooltips: [["invalid", "@what"]]}));
    const others = this.source("others", ["x0", "x1"]);
    this.theta.vstrip({field: "x0"}, {field: "x1"}, {source: others, fill_color: "#9aa0a6", fill_alpha: 0.13, line_color: null});
    const left = this.source("left", ["x0", "x1"]);
    for (const figure of [this.signals, this.theta, this.residual])
      figure.vstrip({field: "x0"}, {field: "x1"}, {source: left, fill_color: null, hatch_pattern: "/", hatch_color: "#b00020", hatch_alpha: 0.35, line_color: "#b00020"});
    SIGNALS.forEach((color, i) => this.line(this.signals, `signal${i}`, {line_color: color, line_width: 1}));
    const measured = styles.measured;
    this.line(this.theta, "overlay", {line_color: "#b34700", line_alpha: 0.6, line_width: 1});
    this.line(this.theta, "theta", {line_color: measured.color, line_width: measured.width});
    for (const figure of [this.signals, this.theta, this.residual]) figure.on_event("mousemove", event => this.read(event.x));
    this.residual.add_layout(new Bokeh.Span({location: 0, dimension: "width", line_color: "#999999"}));
    for (const [y, dash] of [[2, "dashed"], [-2, "dashed"]])
      this.residual.add_layout(new Bokeh.Span({location: y, dimension: "width", line_color: "#bbbbbb", line_dash: dash}));
    this.theta.scatter({field: "x"}, {field: "y"}, {
      source: this.source("impacts", ["x", "y"]), marker: "circle", size: 6, line_color: "black", fill_color: "white"});
    this.bands = [this.band(this.signals, false), this.band(this.theta, true), this.band(this.residual, false)];
    this.speed = Bokeh.Plotting.figure({
      css_classes: ["speed"], title: "Restitution against speed: measured from peaks (circles), of laws by energy",
      x_axis_label: "speed at the impact / (°/s)", y_axis_label: "r", height: 240,
      y_range: new Bokeh.DataRange1d({only_visible: true}), tools: "pan,wheel_zoom,box_zoom,reset", ...wide});
    this.speed.toolbar.active_scroll = null;
    this.housner = new Bokeh.Span({location: 1, dimension: "width", line_color: "#777777", line_dash: "dotted"});
    this.speed.add_layout(this.housner);
    this.speed.segment({field: "x"}, {field: "low"}, {field: "x"}, {field: "high"}, {
      source: this.source("r_measured", ["x", "y", "low", "high"]), line_color: "#555555"});
    this.speed.scatter({field: "x"}, {field: "y"}, {
      source: this.sources.r_measured, marker: "circle", size: 9, line_color: "#555555", fill_color: null});
    Bokeh.Plotting.show(new Bokeh.Column({children: [this.signals, this.theta, this.residual], sizing_mode: "stretch_width"}), overTime);
    Bokeh.Plotting.show(this.speed, overSpeed);
    this.range.change.connect(() => this.wanted());
  }

  source(name, columns) {
    this.sources[name] = new Bokeh.ColumnDataSource({data: Object.fromEntries(columns.map(each => [each, []]))});
    return this.sources[name];
  }

  line(figure, name, look) {
    return figure.line({field: "t"}, {field: "v"}, {source: this.source(name, ["t", "v"]), line_join: "round", ...look});
  }

  band(figure, editable) {
    const band = new Bokeh.BoxAnnotation({
      left: 0, right: 0, editable, movable: "none", resizable: "x", fill_color: "#0a4fb5", fill_alpha: 0.05,
      line_color: "#0a4fb5", line_width: editable ? 2 : 1, line_alpha: editable ? 0.8 : 0.3,
      hover_line_color: "#0a4fb5", hover_line_width: 3, hover_fill_alpha: 0.08, visible: false});
    figure.add_layout(band);
    if (editable)
      band.change.connect(() => this.dragged(band));
    return band;
  }

  /** The handles were moved: by a person, as what the page sets itself is known. */
  dragged(band) {
    const [left, right] = [band.left, band.right].map(Number);
    if (this.setting || (left === this.known?.[0] && right === this.known?.[1])) return;
    const snap = value => this.step ? Number((Math.round(value / this.step) * this.step).toFixed(6)) : value;
    const [release, end] = [left === this.known[0] ? left : snap(left), right === this.known[1] ? right : snap(right)];
    this.known = [left, right];
    for (const other of this.bands) if (other !== band) other.setv({left, right});
    this.moved(release, end);
  }

  place(release, end) {
    this.setting = true;
    this.known = [release, end];
    for (const band of this.bands) band.setv(release === null ? {visible: false} : {left: release, right: end, visible: true});
    this.setting = false;
  }

  /** What is below the cursor: time, rotation, and the residual of each candidate that is drawn. */
  read(time) {
    const near = name => {
      const {t, v} = this.sources[name].data, after = t.findIndex(each => each >= time);
      return after > 0 ? v[time - t[after - 1] < t[after] - time ? after - 1 : after] : NaN;
    };
    const told = [`${time.toFixed(4)} s`, `θ = ${near("theta").toFixed(3)}°`];
    for (const [name, [line]] of Object.entries(this.drawn)) {
      const residual = near(`residual_${name}`);
      if (line.visible && Number.isFinite(residual)) told.push(`${this.styles[name].label} ${residual.toFixed(2)} σ`);
    }
    this.told(told.join("   "));
  }

  /** The stretches that are left out. */
  leave(stretches) {
    this.sources.left.data = {x0: stretches.map(each => each[0]), x1: stretches.map(each => each[1])};
  }

  show(from, to) {
    this.range.setv({start: from, end: to});
  }

  wanted() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.asked(this.range.start, this.range.end), WAIT_MS);
  }

  /** Draw a candidate, or not. */
  only(name, shown) {
    for (const each of this.drawn[name] ?? []) each.visible = shown;
  }

  /** Scale the residuals by those of a candidate, where it is drawn: others may be a hundred times as large. */
  scale(name) {
    const own = this.drawn[name]?.[1];
    this.residual.y_range.renderers = own?.visible ? [own] : "auto";
  }

  /** Signals between two instants, as the server thins them. */
  samples({signals, theta, flags}) {
    SIGNALS.forEach((_, i) => { this.sources[`signal${i}`].data = floats(signals[i]); });
    this.signals.title.text = signals.length ? [...new Set(signals.map(each => each.label))].join(", ") : "no signal";
    this.signals.left[0].axis_label = signals[0]?.unit ? `output / ${signals[0].unit}` : "output";
    this.sources.theta.data = floats(theta);
    this.sources.flagged.data = {x0: flags.map(each => each[0]), x1: flags.map(each => each[1]), what: flags.map(each => each[2])};
  }

  /** A run beside its signals: impacts, the curves of candidates, restitution; null clears it. */
  run(picture, runs) {
    const others = runs.filter(each => each.run !== null && each.run !== picture?.run);
    this.sources.others.data = {x0: others.map(each => each.release_s), x1: others.map(each => each.release_s + each.duration_s)};
    const hits = (picture?.impacts.measured ?? []).filter(each => each[0] !== null);  // those hidden have no instant
    this.sources.impacts.data = {x: hits.map(each => each[0]), y: hits.map(() => 0)};
    for (const name of Object.keys(this.styles)) {
      if (name === "measured") continue;
      const curves = picture?.curves[name], own = picture?.impacts[name];
      if (curves || this.sources[`theta_${name}`]) {
        this.model(name);
        this.sources[`theta_${name}`].data = floats(curves?.theta);
        this.sources[`residual_${name}`].data = floats(curves?.residual);
        const known = (own ?? []).filter(each => each[3] !== null);
        this.sources[`r_${name}`].data = {x: known.map(each => each[2]), y: known.map(each => each[3])};
      }
    }
    const known = hits.filter(each => each[3] !== null);
    this.sources.r_measured.data = {
      x: known.map(each => each[2]), y: known.map(each => each[3]),
      low: known.map(each => each[3] - (each[4] ?? 0)), high: known.map(each => each[3] + (each[4] ?? 0))};
    this.housner.location = picture?.r_housner ?? 1;
  }

  model(name) {
    if (this.sources[`theta_${name}`]) return;
    const {color, dash, width, marker} = this.styles[name];
    const look = {line_color: color, line_dash: dash, line_width: width};
    const drawn = [this.line(this.theta, `theta_${name}`, look), this.line(this.residual, `residual_${name}`, look)];
    this.drawn[name] = drawn;
    drawn[2] = this.speed.scatter({field: "x"}, {field: "y"}, {
      source: this.source(`r_${name}`, ["x", "y"]), marker, size: 6, line_color: color, fill_color: color});
  }
}

function floats(curve) {
  return curve
    ? {t: Float64Array.from(curve.t), v: Float64Array.from(curve.v, each => each ?? NaN)}
    : {t: [], v: []};
}

