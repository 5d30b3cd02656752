"use strict";
// Tables that sort, and the charts of a run, drawn when its section is opened.

const MISSING = -32768;
const STYLES = JSON.parse(document.getElementById("styles").textContent);

// tables

function sortValue(cell) {
  const value = cell.dataset.v ?? cell.textContent.trim();
  return value !== "" && isFinite(value) ? Number(value) : value;
}

function compare(a, b) {
  const [numberA, numberB] = [typeof a === "number", typeof b === "number"];
  if (numberA && numberB) return a - b;
  if (numberA !== numberB) return numberA ? -1 : 1;
  return a.localeCompare(b, "en", {numeric: true});
}

function sortBy(head) {
  const table = head.closest("table");
  const column = [...head.parentNode.children].indexOf(head);
  const falling = head.getAttribute("aria-sort") === "ascending";
  for (const other of head.parentNode.children) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", falling ? "descending" : "ascending");
  const rows = [...table.tBodies[0].rows].map(row => [sortValue(row.cells[column]), row]);
  rows.sort((a, b) => (falling ? -1 : 1) * compare(a[0], b[0]));
  table.tBodies[0].append(...rows.map(([, row]) => row));
}

for (const head of document.querySelectorAll("table.sorts th")) {
  const button = element("span", {role: "button", tabIndex: 0});  // a real one is left out of repeated heads in print
  button.append(...head.childNodes);
  button.addEventListener("click", () => sortBy(head));
  button.addEventListener("keydown", event => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    sortBy(head);
  });
  head.append(button);
}

// numbers packed by freerock.report.curves

function bytes(text) {
  return Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
}

function unpack({scale, data}) {
  return Float64Array.from(new Int16Array(bytes(data)), whole => whole === MISSING ? NaN : whole * scale);
}

// charts

function columns(curves) {
  const all = {time: Float64Array.from(new Float32Array(bytes(curves.time)))};
  for (const source in curves.theta) {
    all[`theta_${source}`] = unpack(curves.theta[source]);
    all[`rate_${source}`] = unpack(curves.rate[source]);
    if (source !== "measured")
      all[`residual_${source}`] = all[`theta_${source}`].map((theta, i) => theta - all.theta_measured[i]);
  }
  return all;
}

function charts(curves) {
  const touch = matchMedia("(pointer: coarse)").matches;
  const source = new Bokeh.ColumnDataSource({data: columns(curves)});
  const time = source.data.time;
  const range = new Bokeh.Range1d({start: 0, end: time[time.length - 1], bounds: "auto"});
  const drawn = {};
  const keep = (name, renderer) => (drawn[name] ??= []).push(renderer);

  function chart(kind, title, x, y, height, more) {
    const figure = Bokeh.Plotting.figure({
      css_classes: [kind], title: title + STYLES.mark, x_axis_label: x, y_axis_label: y, height,
      sizing_mode: "stretch_width", tools: "box_zoom,pan,xwheel_zoom,reset,save",
      toolbar_location: "above", min_border_left: 70, ...more,
    });
    figure.toolbar.active_scroll = null;  // so that the page still scrolls
    figure.toolbar.active_drag = touch ? null : figure.toolbar.tools[0];
    figure.toolbar.logo = null;
    return figure;
  }
  const visible = () => new Bokeh.DataRange1d({only_visible: true, range_padding: 0.08});
  const inTime = (kind, title, y, height) => chart(
    kind, title, "time since release / s", y, height, {x_range: range, y_range: visible(), window_axis: "x"});

  function line(figure, x, prefix, name) {
    const {color, dash, width} = STYLES.lines[name];
    const y = `${prefix}_${name}`;
    const renderer = figure.line({field: x}, {field: y}, {
      source, line_color: color, line_dash: dash, line_width: width, line_join: "round"});
    keep(name, renderer);
    return renderer;
  }

  const names = Object.keys(curves.theta), models = names.filter(name => name !== "measured");
  const motion = inTime("motion", "Rotation", "θ / °", 300);
  names.forEach(name => line(motion, "time", "theta", name));
  const hits = curves.impacts.measured.map(impact => impact[0]);
  keep("measured", motion.scatter(hits, hits.map(() => 0), {
    marker: "circle", size: 6, line_color: "black", fill_color: "white"}));
  motion.add_tools(new Bokeh.HoverTool({
    renderers: [drawn.measured[0]], mode: "vline",
    tooltips: [["t / s", "@time{0.0000}"], ...names.map(
      name => [`${STYLES.lines[name].label} / °`, `@theta_${name}{0.000}`])],
  }));

  const figures = [motion];
  if (models.length) {
    const residual = inTime("residual", "Model minus record", "residual / °", 200);
    models.forEach(name => line(residual, "time", "residual", name));
    figures.push(residual);
  }
  const restitution = inTime("restitution", "Restitution", "restitution r", 220);
  for (const name of names) {
    const impacts = curves.impacts[name];
    if (!impacts.length) continue;
    const [x, y, error] = [0, 1, 2].map(i => impacts.map(impact => impact[i]));
    const {color, marker} = STYLES.lines[name];
    const open = name === "measured";
    keep(name, restitution.scatter(x, y, {
      marker, size: open ? 10 : 6, line_color: open ? "#555555" : color, fill_color: open ? null : color}));
    if (open)
      keep(name, restitution.segment(x, y.map((r, i) => r - error[i]), x, y.map((r, i) => r + error[i]), {
        line_color: "#555555"}));
  }
  figures.push(restitution);
  const phase = chart("phase", "Phase portrait", "θ / °", "angular rate / (°/s)", 380,
    {x_range: visible(), y_range: visible()});
  names.forEach(name => line(phase, `theta_${name}`, "rate", name));
  return {figures, phase, drawn, range};
}

// the controls beside the charts

function element(tag, attributes, ...content) {
  const made = Object.assign(document.createElement(tag), attributes);
  made.append(...content);
  return made;
}

function swatch({color, dash, width}) {
  const drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const stroke = document.createElementNS("http://www.w3.org/2000/svg", "path");
  drawing.setAttribute("class", "swatch");
  drawing.setAttribute("aria-hidden", "true");
  for (const [key, value] of Object.entries({
    d: "M0 6H32", stroke: color, "stroke-width": width, "stroke-dasharray": dash.join(" ") || "none"}))
    stroke.setAttribute(key, value);
  drawing.append(stroke);
  return drawing;
}

function switches({drawn}) {
  const boxes = Object.keys(STYLES.lines).filter(name => name in drawn).map(name => {
    const box = element("input", {type: "checkbox", checked: true, value: name});
    box.addEventListener("change", () => drawn[name].forEach(each => { each.visible = box.checked; }));
    return element("label", {}, box, " ", swatch(STYLES.lines[name]), " ", STYLES.lines[name].label);
  });
  return element("fieldset", {}, element("legend", {}, "Shown"), ...boxes);
}

function window_({range}) {
  const whole = range.end;
  const field = (label, value) => element("input", {type: "number", min: 0, step: "any", value, ariaLabel: label});
  const [from, to] = [field("from / s", 0), field("to / s", whole.toFixed(3))];
  const show = () => {
    from.value = range.start.toFixed(3);
    to.value = range.end.toFixed(3);
  };
  const set = () => {
    const [start, end] = [from.valueAsNumber, to.valueAsNumber];
    if (start < end) range.setv({start, end});
  };
  from.addEventListener("change", set);
  to.addEventListener("change", set);
  range.change.connect(show);
  const reset = element("button", {type: "button"}, "whole run");
  reset.addEventListener("click", () => range.setv({start: 0, end: whole}));
  return element("fieldset", {}, element("legend", {}, "t / s"), from, " to ", to, " ", reset);
}

function draw(section) {
  const place = section.querySelector(".charts");
  if (!place || place.childElementCount) return;
  const made = charts(JSON.parse(section.querySelector(".curves").textContent));
  const wide = place.clientWidth > 850;
  const left = new Bokeh.Column({children: made.figures, sizing_mode: "stretch_width"});
  const layout = wide
    ? new Bokeh.Row({children: [left, made.phase], sizing_mode: "stretch_width"})
    : new Bokeh.Column({children: [left, made.phase], sizing_mode: "stretch_width"});
  const canvas = element("div", {className: wide ? "canvas wide" : "canvas"});
  place.append(element("form", {}, switches(made), window_(made)), canvas);
  section.bokeh = made;
  Bokeh.Plotting.show(layout, canvas);
}

for (const section of document.querySelectorAll("details.run")) {
  section.addEventListener("toggle", () => { if (section.open) draw(section); });
  if (section.open) draw(section);
}

function openTarget() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const section = target && target.closest("details");
  if (!section) return;
  section.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", openTarget);
openTarget();
addEventListener("beforeprint", () => { document.querySelector("#provenance details").open = true; });
